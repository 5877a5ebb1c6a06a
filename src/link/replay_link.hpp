// A recording, said again as if its devices stood behind a port.
#pragma once
#include <link/alarm.hpp>
#include <link/link_context.hpp>
#include <link/replay_file.hpp>

#include <cstddef>
#include <vector>

namespace anogate {

/// Has a channel for each link that was recorded. Up while the file is there, and behind its end.
class ReplayLink final : public Link {
public:
    ReplayLink(LinkId id, LinkSettings settings, const LinkContext& context);
    void start() override;
    void stop_reading() override;
    void stop() override { stop_reading(); }
    void flush(Channel& channel) override;
    LinkFacts facts() const override;
    LinkError trouble() const override;
    bool is_over() const override { return is_over_; }

private:
    const ReplaySettings& replay() const { return settings().as<ReplaySettings>(); }
    bool is_at_once() const { return replay().rate == 0; }
    void look();
    void step();
    bool say_next();
    bool must_wait(TimePoint now);
    void note_none();
    void say(const ReplayFile::Frame& frame);
    Channel* channel_of(std::size_t link);

    LinkContext context_;
    ReplayFile file_;
    Alarm due_;
    std::vector<Channel*> channels_;    // by the number of the recorded link; nullptr: none was to be had
    bool is_up_ = false;
    bool is_over_ = false;
    bool has_begun_ = false;
    TimePoint begun_at_{};                  // when what is due at 0 is said
    ano::Duration position_{};              // of what was said last
    std::uint64_t no_channel_ = 0;          // frames for which there was none
    std::optional<TimePoint> dry_since_;    // the file is not at its end and gives nothing

    // At rate 0: since when it waits for links that have not taken all, and those that it waits for no longer.
    std::optional<TimePoint> waits_since_;
    ChannelSet stuck_;
};

}    // namespace anogate
