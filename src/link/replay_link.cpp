#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/make_link.hpp>
#include <link/replay_link.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <span>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr int max_in_a_turn = 64;                       // frames, before other work of the loop is done
constexpr Duration before_links_are_looked_at = 1ms;    // until busy links are checked again
constexpr Duration patience_with_links = 5s;            // after which a link that accepts nothing is ignored
constexpr Duration too_late = 200ms;                    // a longer delay is not caught up
constexpr Duration dry_for = 500ms;

std::int64_t count_of(std::uint64_t count) { return static_cast<std::int64_t>(count); }

}    // namespace

ReplayLink::ReplayLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)}, context_{context}, file_{context.io, [this] { look(); }}, due_{context.alarms, [this] {
                                                                                                        step();
                                                                                                    }} {}

void ReplayLink::start() { file_.start(replay()); }

void ReplayLink::stop_reading() {
    file_.stop();
    due_.cancel();
}

// A replay accepts no frames, not even from a pinned route: drops them.
void ReplayLink::flush(Channel& channel) {
    std::array<std::span<const std::uint8_t>, 1> next;
    while (channel.outbox.gather(next, context_.host.now()) == 1) channel.outbox.drop_frame(&SendCounters::denied_out);
}

// The file appeared, disappeared, or has more frames.
void ReplayLink::look() {
    context_.host.now();
    const ReplayFile::State state = file_.state();
    if (state == ReplayFile::State::absent) {
        is_up_ = false;
        due_.cancel();
        return context_.host.link_down(*this, file_.error());
    }
    if (!std::exchange(is_up_, true)) {
        if (file_.next()) decoding_ = file_.decoding();
        context_.host.link_up(*this);
    }
    if (!due_.is_set()) step();
}

void ReplayLink::step() {
    for (int i = 0; i < max_in_a_turn; ++i) {
        if (is_at_once() && must_wait(context_.host.now())) return due_.set(context_.host.now() + before_links_are_looked_at);
        if (!emit_next()) return;
        context_.host.flush();    // after each frame: another frame might overtake it in an outbox
    }
    due_.set(context_.host.now());
}

// False: there is no frame, or it is not due.
bool ReplayLink::emit_next() {
    const auto frame = file_.next();
    if (!frame) return note_none(), false;
    dry_since_.reset();
    const TimePoint now = context_.host.now();
    if (!std::exchange(has_begun_, true)) begun_at_ = now;
    const TimePoint due = begun_at_ + frame->due;
    if (due > now) return due_.set(due), false;
    if (now - due > too_late) begun_at_ = now - frame->due;
    position_ = frame->due;
    note_decoding();
    emit(*frame);
    file_.pop();
    return true;
}

// A frame is decoded with the decoding that was in force when it was recorded.
void ReplayLink::note_decoding() {
    if (decode_alike(decoding_, file_.decoding())) return;
    decoding_ = file_.decoding();
    context_.host.link_up(*this);
}

void ReplayLink::note_none() {
    const ReplayFile::State state = file_.state();
    is_over_ = state == ReplayFile::State::ended;
    if (state == ReplayFile::State::playing && !dry_since_) dry_since_ = context_.host.now();
}

// At rate 0: waits for the outboxes, so that frames are neither stale nor superseded.
bool ReplayLink::must_wait(TimePoint now) {
    const ChannelSet busy = context_.host.busy_channels();
    stuck_ = stuck_ & busy;
    if ((busy - stuck_).empty()) {
        waits_since_.reset();
        return false;
    }
    if (!waits_since_) waits_since_ = now;
    if (now - *waits_since_ < patience_with_links) return true;
    stuck_ |= busy;
    waits_since_.reset();
    return false;
}

void ReplayLink::emit(const ReplayFile::Frame& item) {
    Channel* const channel = channel_of(item.link);
    if (!channel) {
        ++no_channel_;
        return;
    }
    const ano::FrameView frame = item.frame;
    channel->arrived_at = context_.host.now();
    channel->beside.bytes_in += frame.bytes().size();
    if (frame.data().size() > ano::max_data_of(frame.id(), settings().max_data)) {
        ++channel->beside.bad_length;
        channel->beside.skipped_bytes += frame.bytes().size();
        return;
    }
    ++channel->beside.frames_in;
    context_.host.receive(*channel, frame);
}

Channel* ReplayLink::channel_of(std::size_t link) {
    if (link < channels_.size()) return channels_[link];
    while (channels_.size() <= link) {
        Channel* const channel = context_.host.open_channel(*this, file_.links()[channels_.size()]);
        channels_.push_back(channel || channels_.empty() ? channel : channels_.front());
    }
    context_.host.link_up(*this);
    return channels_[link];
}

LinkFacts ReplayLink::facts() const {
    const ReplayPlan::KeptBack kept = file_.kept_back();
    return {{"file", replay().file},
            {"replay", is_over_ ? "ended"
                       : is_up_ ? "playing"
                                : "waiting"},
            {"position_s", std::chrono::duration_cast<std::chrono::seconds>(position_).count()},
            {"kept_back_of_hosts", count_of(kept.of_hosts)},
            {"kept_back_commands", count_of(kept.commands)},
            {"kept_back_tunnels", count_of(kept.tunnels)}};
}

LinkError ReplayLink::trouble() const {
    if (no_channel_ > 0) return {"no_channel", "all 64 channels of the gateway are in use: frames of this link are dropped", {}};
    if (dry_since_ && !is_over_ && context_.host.now() - *dry_since_ >= dry_for)
        return {"recording_slow", replay().file + ": the disk is too slow; frames are replayed late", {{"file", replay().file}}};
    return file_.error();
}

namespace {

using namespace key_rows;

constexpr std::uint64_t max_rate = 1'000'000, max_part = 365 * day;

constexpr Key<LinkSettings> replay_keys[] = {
    text<own<ReplaySettings>, &ReplaySettings::file>("file", 1, max_path,
                                                     "the recording file; if it doesn't exist, the link waits for it") |
        as("FILE") | needed,
    decimal<own<ReplaySettings>, &ReplaySettings::rate>("rate", 0, max_rate, "speed factor; 0: as fast as possible"),
    boolean<own<ReplaySettings>, &ReplaySettings::loop>("loop", "start again at the end"),
    duration<own<ReplaySettings>, &ReplaySettings::from>("from", 1, max_part,
                                                         "start this long after the first frame (default: at the first frame)"),
    duration<own<ReplaySettings>, &ReplaySettings::to>("to", 1, max_part,
                                                       "stop this long after the first frame (default: after the last frame)"),
    words<own<ReplaySettings>, &ReplaySettings::links>("links", 1, max_name, "replay only these recorded links (default: all)"),
    boolean<own<ReplaySettings>, &ReplaySettings::commands>(
        "commands",
        "also replay frames sent by hosts and frames that command or modify a vehicle; vehicles on this gateway act on them"),
};

void validate_replay(const LinkSettings& link, LinkFaults& faults) {
    const auto& replay = link.as<ReplaySettings>();
    if (replay.from && replay.to && *replay.from >= *replay.to) faults.error("to", "'to' must be later than 'from'");
}

}    // namespace

extern const LinkKind replay_kind;    // listed in kinds.cpp
constinit const LinkKind replay_kind{
    .name = "replay",
    .address = "file",
    .example = "flight.pcapng",
    .help = "replays a recording at its original times. It accepts no frames and does not affect routing",
    .carries = Carries::pieces,
    .devices_only = true,
    .replays = true,
    .keys = replay_keys,
    .settings = [] { return KindSettings{ReplaySettings{}}; },
    .make = make_link_of<ReplayLink>,
    .usual_name = [](const LinkSettings& link) { return std::filesystem::path{link.as<ReplaySettings>().file}.stem().string(); },
    .validate = validate_replay,
};

}    // namespace anogate
