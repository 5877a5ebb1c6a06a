// The gateway as a V8 device: its device info, parameters and commands, and its lines in the log of hosts. It decides which links
// may change it. No I/O and no clock: the input is frames and the time, the output is frames, operations and the next due time.
//
// Flow:    GatewayDevice device{deeds};
//          device.configure(settings_of_file, written);
//          device.take(frame, {link, "ground", false, false}, now);    // frames to its id or to 0xFF
//          device.run(now);                                            // at due(), when there is one
//          while (const auto out = device.next()) ...                  // after each of them
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <device/device.hpp>
#include <gateway/settings.hpp>
#include <managed/managed_parameters.hpp>

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// The state of a link for hosts, in a flexible frame: number u8 (as in its parameters, from 0), state u8, and three u32.
struct LinkSummary {
    enum class State : std::uint8_t { disabled, waiting, up };
    State state{};
    std::uint64_t frames_in = 0, frames_out = 0;
    std::uint64_t dropped = 0;    // in both directions
};

/// The operations that hosts may request and the program executes. Each returns the reason for a failure, as a clause; empty: it
/// is done, or has begun.
class GatewayOperations {
public:
    /// Applies these values.
    virtual void apply(const WrittenValues& written) = 0;
    /// Calls GatewayDevice::saved() later, when the values are stored on the disk or writing has failed.
    virtual std::string save(const WrittenValues& written) = 0;
    virtual std::string reload() = 0;
    virtual std::string restart(const std::string& link) = 0;
    virtual std::string scan() = 0;
    /// `line` is an index among those of Settings::gpio that can be pulsed.
    virtual std::string pulse(std::size_t line) = 0;
    virtual std::string start_recording() = 0;
    virtual std::string stop_recording() = 0;
    virtual std::vector<LinkSummary> summaries() = 0;
    /// Reports to the control interface why its current request, or its save that was waiting for the disk, is refused; the
    /// protocol has no such answer.
    virtual void refuse_ourselves(const std::string& why) = 0;
    /// Writes a line to the log of the program.
    virtual void warn(const std::string& line) = 0;

protected:
    ~GatewayOperations() = default;
};

/// Counts the frames for the gateway by result.
struct GatewayDeviceCounters {
    std::uint64_t answered = 0;          // queries, and executed actions
    std::uint64_t not_managed = 0;       // actions from links without manage=yes
    std::uint64_t would_lock_out = 0;    // writes that would close the link of the request
    std::uint64_t refused = 0;           // actions that can't be executed now; the log has the reason
    std::uint64_t to_everybody = 0;      // actions to 0xFF, which are for devices
    std::uint64_t unanswered = 0;        // requests for something unsupported, or malformed
    std::uint64_t lines_left_out = 0;    // lines for the log of hosts beyond max_lines
};

/// A parameter for display.
struct ManagedValue {
    const ManagedParameter* row = nullptr;
    double value = 0;
    ValueFrom from{};
};

class GatewayDevice {
public:
    using Link = ano::device::Link;
    using LogColor = ano::device::LogColor;

    /// The origin of a frame. `is_ourselves`: the control interface, without a channel.
    struct Asker {
        Link link = 0;
        std::string name{};    // of the link
        bool may_manage = false;
        bool is_ourselves = false;
    };

    /// The minimum time between two lines about refused actions.
    static constexpr ano::Duration between_refusals = std::chrono::seconds{5};
    static constexpr ano::Duration between_summaries = std::chrono::seconds{1};
    /// At most `max_lines` lines for hosts in `lines_per`; then one line with the number of those left out.
    static constexpr unsigned max_lines = 10;
    static constexpr ano::Duration lines_per = std::chrono::seconds{5};
    static constexpr std::size_t max_saves = 8, max_listeners = 8;

    explicit GatewayDevice(GatewayOperations& operations) : operations_{operations} {}

    /// Sets the configuration file, and the values that overrule it. Without an id, or with the id of hosts, the gateway is not a
    /// device.
    void configure(const Settings& of_file, WrittenValues written);
    bool is_there() const noexcept { return device_ != nullptr; }

    /// Whether take() handles this message. All other frames to 0xFF are telemetry.
    static bool concerns(std::uint8_t id) noexcept;
    /// Processes a frame for the gateway's id or for 0xFF.
    void take(ano::FrameView frame, const Asker& asker, ano::TimePoint now);
    /// To be called when GatewayOperations::save() has ended; `fault` is empty if the values are stored.
    void saved(const std::string& fault, ano::TimePoint now);
    /// Sends a line for the log to all known hosts.
    void log(std::string_view text, LogColor color, ano::TimePoint now);
    void run(ano::TimePoint now);
    std::optional<ano::TimePoint> due() const noexcept;
    /// The next frame to be sent; std::nullopt: none. Link ano::device::every_link: to all known hosts.
    std::optional<ano::device::Outgoing::Departure> next();
    /// To be called when `link` was removed: drops its requests in progress.
    void forget(Link link);

    GatewayDeviceCounters counters() const noexcept;
    /// Valid until configure().
    std::vector<ManagedValue> values() const;
    const WrittenValues& written() const noexcept { return written_; }

private:
    struct Pending {    // a save that waits for the disk
        std::uint8_t address;
        Link link;
        std::array<std::uint8_t, 3> check;
        bool is_ourselves = false;
    };
    struct Listener {    // gets summaries
        std::uint8_t address;
        Link link;
        std::uint8_t id;
        friend bool operator==(const Listener&, const Listener&) = default;
    };
    void make_device();
    void add_parameters();
    void add_commands();
    bool act(ano::FrameView frame, const Asker& asker);
    bool begin_save(ano::FrameView frame);
    bool write(std::size_t row, const ano::device::Value& value);
    bool change(WrittenValues written);
    bool locks_out(const WrittenValues& written) const;
    bool summarise(std::uint8_t flexible);
    bool done(const std::string& refusal, std::string_view what);
    void refuse(std::uint64_t GatewayDeviceCounters::*cause, const std::string& why);
    void report_left_out();
    void send_summaries();
    std::string pulsed_lines() const;

    GatewayOperations& operations_;
    Settings of_file_;
    WrittenValues written_;
    std::vector<ManagedParameter> rows_;
    std::unique_ptr<ano::device::Device> device_;    // null: the gateway is not a device
    GatewayDeviceCounters counters_;
    ano::device::Counters former_;    // of earlier devices
    std::deque<Pending> saves_;
    std::vector<Listener> listeners_;
    std::optional<ano::TimePoint> summary_due_;
    std::deque<std::vector<std::uint8_t>> frames_;    // in addition to those of the device
    std::deque<Link> frame_links_;
    std::vector<std::uint8_t> leaving_;

    // Valid during take().
    const Asker* asker_ = nullptr;
    std::uint8_t asker_address_ = 0;
    ano::TimePoint now_{};

    ano::TimePoint next_refusal_ = ano::TimePoint::min();
    std::uint64_t unreported_refusals_ = 0;
    ano::TimePoint lines_until_ = ano::TimePoint::min();
    unsigned lines_ = 0;
    std::uint64_t lines_left_out_ = 0;    // in the current `lines_per`
};

}    // namespace anogate
