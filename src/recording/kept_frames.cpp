#include <ano/typed.hpp>
#include <device/device.hpp>
#include <recording/kept_frames.hpp>
#include <runtime/gateway.hpp>
#include <runtime/known_origin.hpp>

#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::size_t cost_of_part = 256;    // bytes besides the records: twice the size of their containers
constexpr std::size_t bytes_at_once = 16 * 1024;
constexpr int records_at_once = 100;    // thousands produce no byte yet if they are compressed together

}    // namespace

std::uint64_t KeptFrames::frames() const noexcept {
    std::uint64_t count = 0;
    for (const FramesPart& part : parts) count += part.frames;
    return count;
}

KeptFramesWriting::KeptFramesWriting(KeptFrames frames, RecordingFormat format, RecordingOptions options)
    : frames_{std::move(frames)}, format_{format}, options_{options} {}

bool KeptFramesWriting::next(std::string& into) {
    if (!writer_) {
        writer_ = make_recording_writer(format_, frames_.head, into, options_);
        decoding_ = frames_.head.decoding;
    }
    const std::size_t begin = into.size();
    int records = 0;
    while (part_ < frames_.parts.size()) {
        FramesPart& part = frames_.parts[part_];
        if (!std::exchange(in_part_, true)) {
            if (part.lost.count > 0) writer_->write(RecordedLoss{part.lost.count, part.lost_names});
            if (!decode_alike(part.names->decoding, decoding_)) writer_->use(decoding_ = part.names->decoding, into);
            rest_ = part.batch ? std::string_view{*part.batch} : std::string_view{};
        }
        while (const auto record = next_record(rest_)) {
            writer_->write(as_recorded(*record, *part.names), into);
            if (++records == records_at_once || into.size() - begin >= bytes_at_once) return true;
        }
        part = {};    // free the memory of the written part
        in_part_ = false;
        ++part_;
    }
    writer_->end(into);
    return false;
}

FrameMemory::FrameMemory(Gateway& gateway, FrameWatch& watch, const FrameFilterSettings& filter, ano::Duration span)
    : gateway_{gateway}, watch_{watch}, ring_{span, max_bytes} {
    watch_.add(*this, filter);
}

FrameMemory::~FrameMemory() { watch_.remove(*this); }

void FrameMemory::change(const FrameFilterSettings& filter, ano::Duration span) {
    watch_.change(*this, filter);
    more();
    ring_.set_span(span);
}

void FrameMemory::more() {
    const TimePoint now = Clock::now();
    while (auto item = queue.next(now)) {
        if (auto* tables = std::get_if<WatchQueue::Tables>(&*item)) {
            tables_ = std::move(*tables);
            renew_names();
        } else if (const auto* lost = std::get_if<LostFrames>(&*item)) {
            lost_.add(*lost);
        } else {
            auto& batch = std::get<WatchQueue::Batch>(*item);
            const LostFrames before = std::exchange(lost_, {});
            std::string lost_names = loss_names(before);
            const std::size_t cost = batch->capacity() + lost_names.size() + std::exchange(cost_of_names_, 0) + cost_of_part;
            const std::uint64_t frames = count_of_records(*batch);
            ring_.push({std::move(batch), names_, RecordedLoss{before.count, {}}, std::move(lost_names), frames}, cost, now);
        }
    }
}

void FrameMemory::renew_names() {
    names_ = std::make_shared<const RecordedNames>(recorded_names(*tables_, gateway_));
    cost_of_names_ = names_->cost();
}

void FrameMemory::catch_up() {
    watch_.catch_up(*this);
    more();
}

KeptFrames FrameMemory::frames() {
    catch_up();
    ring_.forget_until(Clock::now());
    KeptFrames all;
    for (const auto& kept : ring_.items()) all.parts.push_back(kept.item);
    all.head = recording_head(all.parts.empty() ? gateway_.decoding() : all.parts.front().names->decoding);
    return all;
}

FrameMemory::Figures FrameMemory::figures() {
    const TimePoint now = Clock::now();
    ring_.forget_until(now);
    Figures figures{ring_.span(), ring_.reach(now), 0, ring_.cost()};
    for (const auto& kept : ring_.items()) figures.frames += kept.item.frames;
    return figures;
}

FaultTrigger::FaultTrigger(Gateway& gateway, FrameWatch& watch, std::function<void()> call)
    : gateway_{gateway}, watch_{watch}, call_{std::move(call)} {
    FrameFilterSettings filter;
    filter.ids.reset();
    filter.ids.set(ano::id_of<"log">);
    filter.directions = {true, false, false};
    watch_.add(*this, filter);
}

FaultTrigger::~FaultTrigger() { watch_.remove(*this); }

void FaultTrigger::catch_up() {
    watch_.catch_up(*this);
    more();
}

void FaultTrigger::more() {
    bool is_fault = false;
    while (auto item = queue.next(Clock::now())) {
        const auto* batch = std::get_if<WatchQueue::Batch>(&*item);
        std::string_view rest = batch ? std::string_view{**batch} : std::string_view{};
        while (const auto record = next_record(rest)) {
            const auto log = ano::as<"log">(record->frame);
            const bool is_red = log && log->get<"color">() == static_cast<std::uint8_t>(ano::device::LogColor::red);
            is_fault = is_fault || (is_red && is_at_home(*record));
        }
    }
    if (is_fault) call_();
}

bool FaultTrigger::is_at_home(const FrameRecord& record) const {
    const auto channel = static_cast<ChannelId>(record.channel);
    if (record.channel == FrameRecord::no_channel || !gateway_.forwarder().channels().contains(channel)) return false;
    const std::uint8_t source = record.frame.source();
    return gateway_.forwarder().router().holds(source, channel) &&
           is_known_origin(gateway_, gateway_.forwarder().channel(channel), source);
}

}    // namespace anogate
