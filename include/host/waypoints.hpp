// The waypoints of a device (0x60, 0x61; protocol text, section 4).
#pragma once
#include <ano/frame.hpp>
#include <host/gather.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ano::host {

struct Waypoint {
    std::uint8_t num = 0;       // 0 is HOME
    double lng = 0, lat = 0;    // degrees
    std::int32_t alt = 0;       // cm
    std::uint16_t spd = 0;      // cm/s
    std::uint16_t yaw = 0;      // degrees from north, 0 to 359; 400: face the target
    std::uint8_t fun = 0;
    std::array<std::uint8_t, 4> cmd{};
    friend bool operator==(const Waypoint&, const Waypoint&) = default;
};

inline constexpr std::uint8_t last_waypoint = 0xFE;

/// The waypoint in `frame`; std::nullopt if it is not a 0x61, or too short for one.
std::optional<Waypoint> waypoint_in(FrameView frame);
/// The request that writes it; std::nullopt if the position is not on earth, or the number is beyond last_waypoint.
std::optional<Request> waypoint_write(const Waypoint& waypoint, std::uint32_t tag = 0);

/// Reads the number of waypoints, and each waypoint, from 0.
class WaypointsGet final : public Gather {
public:
    using Gather::Gather;

    void start(TimePoint now) { ask(how_many(ask_count), now); }
    /// Complete when the task is done.
    const std::vector<Waypoint>& waypoints() const noexcept { return waypoints_; }

    static Request how_many(std::uint32_t tag);
    static Request waypoint(std::uint32_t num, std::uint32_t tag);

private:
    enum Step : std::uint32_t { ask_count = first_step, ask_count_again };

    Request question(std::uint32_t i) override { return waypoint(i, i); }
    bool took(std::uint32_t i, FrameView answer) override;
    void gathered(TimePoint now) override { ask(how_many(ask_count_again), now); }
    Request probe() override { return how_many(0); }
    void step_ended(const Ended& ended, TimePoint now) override;
    Fault subject() const override { return {"waypoints"}; }

    std::vector<Waypoint> waypoints_;
};

/// Writes waypoints one by one, reads each back, and finally asks for their number. The protocol can't remove a waypoint: if the
/// device has more, the end states that.
///
/// A waypoint that is not acknowledged is read back, and written again if it is not stored: for `patience`, since some devices
/// take 3 s, and as long as the device does not store another value. One that is acknowledged and read back with another value is
/// written once more: the device may store other values than it receives, or have restarted with its old list. The whole list is
/// read again at the end if there are several, one was read back with another value, anything was lost on the way, or the device
/// was away: it may have restarted and lost waypoints. The list read last decides. Failed: the list differs from the stored
/// values, or none is stored as written; then the progress counts those that the device has.
class WaypointsPut final : public Task {
public:
    static constexpr Duration patience = std::chrono::seconds{4};

    WaypointsPut(Device& device, std::vector<Waypoint> waypoints) : Task{device}, waypoints_{std::move(waypoints)} {}

    void start(TimePoint now);
    Progress progress() const noexcept override { return {at_, waypoints_.size()}; }
    Duration max_duration() const noexcept override {
        return Task::max_duration() + std::chrono::seconds{8} * static_cast<int>(waypoints_.size());
    }
    void cancel(TimePoint now) override;
    void ended(const Ended& ended, TimePoint now) override;

    /// The waypoints written so far, as the device stored them.
    const std::vector<Waypoint>& stored() const noexcept { return stored_; }

private:
    enum Step : std::uint32_t { write, read_back, ask_count };

    void next(TimePoint now);
    void write_it(TimePoint now);
    void written(const Ended& ended, TimePoint now);
    void ask_patiently(TimePoint now);
    void was_read_back(const Ended& ended, TimePoint now);
    void counted(std::uint8_t count, TimePoint now);
    std::size_t wanted_count() const;
    void finish_stored(TimePoint now);
    void look_again(TimePoint now);
    void looked(TimePoint now);
    Fault order() const override { return {"write_of", number()}; }
    Fault number() const { return {"waypoint_number", waypoints_[at_].num}; }

    std::vector<Waypoint> waypoints_;
    std::vector<Waypoint> stored_;
    std::vector<Request> writes_;
    std::size_t at_ = 0;
    std::vector<std::uint8_t> changed_;    // their numbers: stored with other values than written
    std::size_t unacknowledged_ = 0, wrongly_acknowledged_ = 0;
    std::optional<TimePoint> begun_at_;    // this waypoint
    bool is_acknowledged_ = false;         // this waypoint
    bool is_written_again_ = false;        // this waypoint, because another value was read back
    TimePoint acknowledged_at_{};
    unsigned mismatches_ = 0;    // of this waypoint, read back without an acknowledgement
    Evidence silence_;           // of its writes
    bool may_have_restarted_ = false;
    std::uint32_t presence_ = 0;
    std::uint8_t count_ = 0;                // of the device, at the end
    std::unique_ptr<WaypointsGet> look_;    // at the end
};

}    // namespace ano::host
