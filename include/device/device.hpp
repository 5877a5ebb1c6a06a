// A V8 device: answers hosts according to the protocol text. No I/O, no clock: frames and a time in, frames and the next due time
// out.
//
// Flow:    ano::device::Device device{{.id = 0x21, .name = "Thermometer"}};
//          device.parameters().add("OFFSET", offset, {.min = -5, .max = 5});
//          device.take(frame, now);                                    // each received valid frame
//          device.run(now);                                            // at due(), if it has a value
//          while (const auto out = device.next()) write(out->frame);   // after each of them
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <ano/typed.hpp>
#include <device/commands.hpp>
#include <device/firmware.hpp>
#include <device/info.hpp>
#include <device/outgoing.hpp>
#include <device/parameters.hpp>
#include <device/profile.hpp>
#include <device/reply.hpp>
#include <device/waypoints.hpp>

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string_view>
#include <vector>

namespace ano::device {

/// The color of a line in the log of a host (protocol text, section 4, 0xA0).
enum class LogColor : std::uint8_t { standard, red, green, blue };

/// The results for the received frames. Each frame is counted in exactly one row, except those that still wait; answers_lost
/// counts answers.
struct Counters {
    std::uint64_t not_ours = 0;       // for another address
    std::uint64_t from_nobody = 0;    // S_ADDR is 0, 0xFF or the device's own: there is no address for the answer
    std::uint64_t too_long = 0;       // longer than Profile::max_data
    std::uint64_t queue_full = 0;     // Profile::queue frames were already waiting
    std::uint64_t crashed = 0;        // received after the crash that Profile::crashes_at_the_count simulates
    std::uint64_t unanswered = 0;     // acknowledgements, telemetry, answers of other devices
    std::uint64_t unknown = 0;
    std::uint64_t malformed = 0;
    std::uint64_t refused = 0;
    std::uint64_t answered = 0;        // immediately or later
    std::uint64_t answers_lost = 0;    // of the answered ones: Outgoing::max_frames frames were already waiting
};

/// Does not throw by itself and performs no I/O; exceptions of the user's functions are passed on. Not thread-safe.
class Device {
public:
    /// Throws std::invalid_argument for an id that no device may have (0, 254, 255), or a name of more than 20 bytes.
    explicit Device(Info info, const Profile& profile = {});
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const Info& info() const noexcept { return info_; }
    const Profile& profile() const noexcept { return profile_; }
    Parameters& parameters() noexcept { return parameters_; }
    Commands& commands() noexcept { return commands_; }
    Waypoints& waypoints() noexcept { return waypoints_; }
    Firmware& firmware() noexcept { return firmware_; }

    /// Processes a received valid frame with any destination: handles it, or queues it if the profile has a queue.
    void take(FrameView frame, TimePoint now, Link link = 0);
    /// Performs the work that is due at `now`.
    void run(TimePoint now);
    /// When to call run(); std::nullopt: nothing is in progress.
    std::optional<TimePoint> due() const noexcept;
    /// The next frame to be sent, and its link; std::nullopt: no frame waits.
    std::optional<Outgoing::Departure> next() noexcept { return out_.next(); }

    /// Sends a message of the user from this device; false: Outgoing is full, or the message has more than max_sent bytes of
    /// DATA.
    template <Name M, Name Label>
    bool send(const Draft<M, Label>& draft, std::uint8_t destination, Link link = every_link) noexcept {
        std::uint8_t* memory = out_.prepare();
        if (memory == nullptr) return false;
        const std::size_t size = draft.encode({memory, Outgoing::room}, info_.id, destination);
        out_.commit(size, link);
        return size != 0;
    }
    /// Sends a line for the log of the hosts (0xA0), or one with a number (0xA1), truncated to fit into a frame. False: Outgoing
    /// is full.
    bool log(std::string_view text, LogColor color = LogColor::standard, std::uint8_t destination = address::host) noexcept;
    bool log(float value, std::string_view text, std::uint8_t destination = address::host) noexcept;

    const Counters& counters() const noexcept { return counters_; }
    /// The crash that Profile::crashes_at_the_count simulates has happened.
    bool crashed() const noexcept { return parameters_.crashed(); }

private:
    struct Waiting {
        std::vector<std::uint8_t> bytes;
        Link link;
        TimePoint due;
    };
    void enqueue(FrameView frame, TimePoint now, Link link);
    void handle_first();
    void handle(FrameView frame, TimePoint now, Link link);
    Outcome dispatch(FrameView frame, TimePoint now, Reply& reply);
    Outcome parameter_command(FrameView frame, Reply& reply);
    Outcome send_info(Reply& reply) const;
    Outcome firmware_step(FrameView frame, TimePoint now, Reply& reply);
    void end_firmware_step(TimePoint now);
    void count(Outcome outcome) noexcept;

    Info info_;
    Profile profile_;
    Outgoing out_;
    Parameters parameters_{profile_};
    Commands commands_{profile_};
    Waypoints waypoints_;
    Firmware firmware_{info_, profile_};
    std::deque<Waiting> queue_;    // at most Profile::queue
    Counters counters_;
};

}    // namespace ano::device
