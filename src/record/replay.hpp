// Which frames of a recording are replayed, and when. No I/O.
#pragma once
#include <ano/time.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// Why a frame should not be replayed: a replay must not start a vehicle.
enum class Risk : std::uint8_t {
    none,
    of_host,    // sent by a host
    command,    // it commands or changes a vehicle
    tunnel,     // a tunnel frame that contains or may contain such a frame
};
Risk risk_of(ano::FrameView frame) noexcept;
inline bool may_command(ano::FrameView frame) noexcept { return risk_of(frame) != Risk::none; }

/// The time at which each frame is due. Uses the boot-time clock if the recording has it. Otherwise the system clock may have
/// been set: a frame that is earlier than the one before is due at the same time as that one.
class ReplayClock {
public:
    /// `rate`: speed relative to the recording; 0: all frames at once.
    explicit ReplayClock(double rate) noexcept : rate_{rate} {}

    /// Time since the first frame. To be called once for each frame, in order.
    ano::Duration due(const RecordedFrame& frame) noexcept { return at_rate(elapsed(frame)); }
    /// The same at rate 1. For each frame call either this or due().
    ano::Duration elapsed(const RecordedFrame& frame) noexcept;
    /// How long `elapsed` of the recording takes at the rate.
    ano::Duration at_rate(ano::Duration elapsed) const noexcept;

private:
    double rate_;
    std::uint64_t last_time_ = 0, last_boottime_ = 0;
    bool begun_ = false;
    std::uint64_t elapsed_ns_ = 0;
};

/// Chooses the frames of a replay: received frames of the chosen links, within a time range, without Risk.
class ReplayPlan {
public:
    struct Options {
        double rate = 1;                        // see ReplayClock
        ano::Duration from{}, to{};             // since the first frame of the recording; `to` 0: until its end
        std::vector<std::string> links = {};    // by name; empty: all
        bool commands = false;                  // frames with a Risk as well
    };
    /// Number of frames that match the options but are left out, by their Risk.
    struct KeptBack {
        std::uint64_t of_hosts = 0, commands = 0, tunnels = 0;
    };

    explicit ReplayPlan(Options options) : options_{std::move(options)}, clock_{options_.rate} {}

    /// When the frame is due, since `from`; std::nullopt: it is left out. To be called for every frame of the recording, in
    /// order.
    std::optional<ano::Duration> due(const RecordedFrame& frame);
    /// Whether all further frames are after `to`.
    bool is_over() const noexcept { return is_over_; }
    const KeptBack& kept_back() const noexcept { return kept_back_; }
    /// After the last frame: why no frame was chosen, in a clause: "there is no link radio in it; it has fc". Empty: at least one was.
    std::string why_nothing() const;

private:
    bool is_wanted(const RecordedFrame& frame) const;
    void note(const RecordedFrame& frame, ano::Duration elapsed);

    Options options_;
    ReplayClock clock_;
    KeptBack kept_back_;
    bool is_over_ = false;

    bool has_chosen_ = false;    // a frame was chosen; from then on the members below are not updated
    bool has_frames_ = false;
    ano::Duration length_{};           // of the recording so far
    std::vector<std::string> seen_;    // names of links, at most 16
};

}    // namespace anogate
