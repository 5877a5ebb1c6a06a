// Replays a recording as if its devices were connected.
#pragma once
#include <link/link_context.hpp>
#include <link/replay_file.hpp>
#include <sys/alarm.hpp>

#include <cstddef>
#include <vector>

namespace anogate {

/// Has a channel for each recorded link. Up while the file can be read, and after its end.
class ReplayLink final : public Link, public PlayedRecording {
public:
    ReplayLink(LinkId id, LinkSettings settings, const LinkContext& context);
    void start() override;
    void stop_reading() override;
    void stop() override { stop_reading(); }
    void flush(Channel& channel) override;
    LinkFacts facts() const override;
    LinkError trouble() const override;
    bool is_over() const override { return is_over_; }
    DecodingPtr decoding() const override { return decoding_; }

private:
    const ReplaySettings& replay() const { return settings().as<ReplaySettings>(); }
    bool is_at_once() const { return replay().rate == 0; }
    void look();
    void step();
    bool emit_next();
    bool must_wait(TimePoint now);
    void note_none();
    void note_decoding();
    void emit(const ReplayFile::Frame& frame);
    Channel* channel_of(std::size_t link);

    LinkContext context_;
    ReplayFile file_;
    DecodingPtr decoding_;    // of the current frames
    Alarm due_;
    std::vector<Channel*> channels_;    // by the number of the recorded link; nullptr: no channel was free
    bool is_up_ = false;
    bool is_over_ = false;
    bool has_begun_ = false;
    TimePoint begun_at_{};                  // the time of Frame::due 0
    ano::Duration position_{};              // Frame::due of the last frame replayed
    std::uint64_t no_channel_ = 0;          // frames without a channel
    std::optional<TimePoint> dry_since_;    // since when no frame is available, although the end is not reached

    // At rate 0: the time since which it waits for full outboxes, and the channels for which it no longer waits.
    std::optional<TimePoint> waits_since_;
    ChannelSet stuck_;
};

}    // namespace anogate
