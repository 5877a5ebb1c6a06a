// What of a recording is said again, and when. No I/O.
#pragma once
#include <ano/time.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// Why a frame is better not said again: a replay must not start a vehicle.
enum class Risk : std::uint8_t {
    none,
    of_host,    // a host said it
    command,    // it commands or changes a vehicle
    tunnel,     // a tunnel frame that has such a frame in it, or may have one
};
Risk risk_of(ano::FrameView frame) noexcept;
inline bool may_command(ano::FrameView frame) noexcept { return risk_of(frame) != Risk::none; }

/// When each frame is due. By the clock that nobody sets, where the recording has it: otherwise by the other one, which may have been
/// set: what is earlier than the frame before is due with it.
class ReplayClock {
public:
    /// `rate` times as fast as it was; 0: at once.
    explicit ReplayClock(double rate) noexcept : rate_{rate} {}

    /// Since the first frame; of each frame once, in their order.
    ano::Duration due(const RecordedFrame& frame) noexcept { return at_rate(elapsed(frame)); }
    /// The same as the recording has it, at rate 1. Of each frame one of both.
    ano::Duration elapsed(const RecordedFrame& frame) noexcept;
    /// How long so much of the recording takes.
    ano::Duration at_rate(ano::Duration elapsed) const noexcept;

private:
    double rate_;
    std::uint64_t last_time_ = 0, last_boottime_ = 0;
    bool begun_ = false;
    std::uint64_t elapsed_ns_ = 0;
};

/// Chooses the frames of a replay: those that came in, by the links that are asked for, between two times, without risk.
class ReplayPlan {
public:
    struct Options {
        double rate = 1;                        // as of ReplayClock
        ano::Duration from{}, to{};             // since the first frame of the recording; `to` 0: up to its end
        std::vector<std::string> links = {};    // by name; empty: all
        bool commands = false;                  // frames with a risk as well
    };
    /// Frames that were asked for and are kept back, by their risk.
    struct KeptBack {
        std::uint64_t of_hosts = 0, commands = 0, tunnels = 0;
    };

    explicit ReplayPlan(Options options) : options_{std::move(options)}, clock_{options_.rate} {}

    /// When it is to be said, since `from`; nothing: it stays out. Of every frame of the recording, in their order.
    std::optional<ano::Duration> due(const RecordedFrame& frame);
    /// The frames from here on are behind `to`.
    bool is_over() const noexcept { return is_over_; }
    const KeptBack& kept_back() const noexcept { return kept_back_; }
    /// Behind the last frame: why not one was to be said, in a clause, "there is no link radio in it; there is fc". Empty: one was.
    std::string why_nothing() const;

private:
    bool is_wanted(const RecordedFrame& frame) const;
    void note(const RecordedFrame& frame, ano::Duration elapsed);

    Options options_;
    ReplayClock clock_;
    KeptBack kept_back_;
    bool is_over_ = false;

    bool says_some_ = false;    // behind that nothing of the following is noted
    bool has_frames_ = false;
    ano::Duration length_{};           // up to the last frame
    std::vector<std::string> seen_;    // the names of links, at most 16
};

}    // namespace anogate
