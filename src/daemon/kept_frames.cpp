#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <ano/typed.hpp>
#include <config/link_kind.hpp>
#include <daemon/gateway.hpp>
#include <daemon/kept_frames.hpp>
#include <device/device.hpp>
#include <link/clocks.hpp>

#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::size_t cost_of_part = 256;    // beside the records: what holds them, twice over
constexpr std::size_t bytes_at_once = 16 * 1024;

std::uint64_t count_of(std::string_view records) noexcept {
    std::uint64_t count = 0;
    while (take_record(records)) ++count;
    return count;
}

std::string_view name_at(const std::vector<std::string>& names, std::size_t number) {
    return number < names.size() ? std::string_view{names[number]} : std::string_view{};
}

std::uint64_t nanoseconds(ano::Duration time) {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time).count());
}

}    // namespace

RecordingHead recording_head() {
    const ClockReading clocks = read_clocks();
    return {"anogated " ANOGATE_VERSION, nanoseconds(clocks.real), nanoseconds(clocks.boot)};
}

std::string names_of(const LostFrames& lost) {
    std::string names;
    for (unsigned n = 0; n < lost.by_id.size(); ++n) {
        if (lost.by_id[n] == 0) continue;
        const auto id = static_cast<std::uint8_t>(n);
        const ano::Message* message = ano::find_message(id);
        names += (names.empty() ? "" : ", ") + (message ? std::string{message->name} : ano::hex_byte(id)) + " " +
                 std::to_string(lost.by_id[n]);
    }
    return names;
}

std::uint64_t KeptFrames::frames() const noexcept {
    std::uint64_t count = 0;
    for (const FramesPart& part : parts) count += part.frames;
    return count;
}

KeptFramesWriting::KeptFramesWriting(KeptFrames frames, RecordingFormat format) : frames_{std::move(frames)}, format_{format} {}

bool KeptFramesWriting::next(std::string& into) {
    if (!writer_) writer_ = make_recording_writer(format_, frames_.head, into);
    const std::size_t begin = into.size();
    while (part_ < frames_.parts.size()) {
        FramesPart& part = frames_.parts[part_];
        if (!std::exchange(in_part_, true)) {
            if (part.lost.count > 0) writer_->write(RecordedLoss{part.lost.count, part.lost_names});
            rest_ = part.batch ? std::string_view{*part.batch} : std::string_view{};
        }
        while (const auto record = take_record(rest_)) {
            write(*record, part, into);
            if (into.size() - begin >= bytes_at_once) return true;
        }
        part = {};    // what is written need not be held
        in_part_ = false;
        ++part_;
    }
    writer_->end(into);
    return false;
}

void KeptFramesWriting::write(const FrameRecord& record, const FramesPart& part, std::string& into) {
    const std::string_view link = name_at(part.tables->links, record.link);
    const auto described = frames_.descriptions.find(link);
    const auto causes = frame_causes();
    const bool has_channel = record.channel != FrameRecord::no_channel;
    writer_->write({.time_ns = record.time_ns,
                    .boottime_ns = record.boottime_ns,
                    .link = link,
                    .link_description = described != frames_.descriptions.end() ? std::string_view{described->second} : "",
                    .direction = record.direction,
                    .cause = record.cause < causes.size() ? causes[record.cause] : std::string_view{},
                    .channel = has_channel ? std::optional{record.channel} : std::nullopt,
                    .peer = has_channel ? name_at(part.tables->peers, record.channel) : std::string_view{},
                    .frame = record.frame},
                   into);
}

FrameMemory::FrameMemory(Gateway& gateway, FrameWatch& watch, const FrameFilterSettings& filter, ano::Duration span)
    : gateway_{gateway}, watch_{watch}, ring_{span, most} {
    watch_.add(*this, filter);
}

FrameMemory::~FrameMemory() { watch_.remove(*this); }

void FrameMemory::more() {
    const TimePoint now = Clock::now();
    while (auto item = queue.next(now)) {
        if (auto* tables = std::get_if<WatchQueue::Tables>(&*item)) {
            tables_ = std::move(*tables);
        } else if (const auto* lost = std::get_if<LostFrames>(&*item)) {
            lost_.count += lost->count;
            lost_names_ = names_of(*lost);
        } else {
            auto& batch = std::get<WatchQueue::Batch>(*item);
            const std::size_t cost = batch->capacity() + lost_names_.size() + cost_of_part;
            const std::uint64_t frames = count_of(*batch);
            ring_.push({std::move(batch), tables_, std::exchange(lost_, {}), std::exchange(lost_names_, {}), frames}, cost, now);
        }
    }
}

KeptFrames FrameMemory::frames() {
    ring_.forget_until(Clock::now());
    KeptFrames all;
    all.head = recording_head();
    for (const LinkState& state : gateway_.links())
        all.descriptions.emplace(state.link->name(), std::string{state.link->settings().kind->name});
    for (const auto& kept : ring_.items()) all.parts.push_back(kept.item);
    return all;
}

FrameMemory::Figures FrameMemory::figures() {
    const TimePoint now = Clock::now();
    ring_.forget_until(now);
    Figures figures{ring_.span(), ring_.reach(now), 0, ring_.cost()};
    for (const auto& kept : ring_.items()) figures.frames += kept.item.frames;
    return figures;
}

FaultEar::FaultEar(FrameWatch& watch, std::function<void()> call) : watch_{watch}, call_{std::move(call)} {
    FrameFilterSettings filter;
    filter.ids.reset();
    filter.ids.set(ano::id_of<"log">);
    filter.directions = {true, false, false};
    watch_.add(*this, filter);
}

FaultEar::~FaultEar() { watch_.remove(*this); }

void FaultEar::more() {
    bool is_fault = false;
    while (auto item = queue.next(Clock::now())) {
        const auto* batch = std::get_if<WatchQueue::Batch>(&*item);
        std::string_view rest = batch ? std::string_view{**batch} : std::string_view{};
        while (const auto record = take_record(rest)) {
            const auto log = ano::as<"log">(record->frame);
            is_fault = is_fault || (log && log->get<"color">() == static_cast<std::uint8_t>(ano::device::LogColor::red));
        }
    }
    if (is_fault) call_();
}

}    // namespace anogate
