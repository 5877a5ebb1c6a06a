// The gateway as a V8 device: its device info, parameters and commands, and its lines in the log of hosts. It decides which links may
// change it. No I/O, no clock: frames and a time in, frames, deeds and the next due time out.
//
// Flow:    GatewayDevice device{deeds};
//          device.configure(settings_of_file, written);
//          device.take(frame, {link, "ground", false, false}, now);    // frames for it, or for everybody
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

/// A link as hosts get it in a flexible frame: number u8 (the one in its parameters, from 0), state u8, and three u32.
struct LinkSummary {
    enum class State : std::uint8_t { disabled, waiting, up };
    State state{};
    std::uint64_t frames_in = 0, frames_out = 0;
    std::uint64_t dropped = 0;    // in both directions
};

/// The actions that a host may ask for and that the program carries out. Each returns why it can't be done, as a clause; empty: it is
/// done, or has begun.
class GatewayDeeds {
public:
    /// Puts these values into effect.
    virtual void apply(const WrittenValues& written) = 0;
    /// Calls GatewayDevice::saved() later, when the values are on the disk or can't be written.
    virtual std::string save(const WrittenValues& written) = 0;
    virtual std::string reload() = 0;
    virtual std::string restart(const std::string& link) = 0;
    virtual std::string scan() = 0;
    /// `line` is an index among those of Settings::gpio that can be pulsed.
    virtual std::string pulse(std::size_t line) = 0;
    virtual std::string start_recording() = 0;
    virtual std::string stop_recording() = 0;
    virtual std::vector<LinkSummary> summaries() = 0;
    /// Tells the control interface why its present request, or its save that waited for the disk, is refused; the protocol has no such answer.
    virtual void refuse_ourselves(const std::string& why) = 0;
    /// Writes a line to the log of the program.
    virtual void warn(const std::string& line) = 0;

protected:
    ~GatewayDeeds() = default;
};

/// What was done with the frames for the gateway.
struct GatewayDeviceCounters {
    std::uint64_t answered = 0;          // questions, and actions that were carried out
    std::uint64_t not_managed = 0;       // actions from links without manage=yes
    std::uint64_t would_lock_out = 0;    // writes that would close the link by which they came
    std::uint64_t refused = 0;           // actions that can't be carried out now; the log says why
    std::uint64_t to_everybody = 0;      // actions to 0xFF, which are for devices
    std::uint64_t unanswered = 0;        // for what it does not have, or malformed
    std::uint64_t lines_left_out = 0;    // lines for the log of hosts that were too many
};

/// A parameter in a form for people.
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
    /// At most `max_lines` lines for hosts in `lines_per`; then one that says how many were left out.
    static constexpr unsigned max_lines = 10;
    static constexpr ano::Duration lines_per = std::chrono::seconds{5};
    static constexpr std::size_t max_saves = 8, max_listeners = 8;

    explicit GatewayDevice(GatewayDeeds& deeds) : deeds_{deeds} {}

    /// The configuration file, and the values that were written over it. Without an id, or with the id of hosts, the gateway is no device.
    void configure(const Settings& of_file, WrittenValues written);
    bool is_there() const noexcept { return device_ != nullptr; }

    /// Whether take() handles this message. All other frames to everybody are telemetry.
    static bool concerns(std::uint8_t id) noexcept;
    /// Takes a frame for the gateway's id or for everybody.
    void take(ano::FrameView frame, const Asker& asker, ano::TimePoint now);
    /// To be called when GatewayDeeds::save() has ended; `fault` is empty when the values are stored.
    void saved(const std::string& fault, ano::TimePoint now);
    /// Sends a line for the log of the hosts that were heard.
    void log(std::string_view text, LogColor color, ano::TimePoint now);
    void run(ano::TimePoint now);
    std::optional<ano::TimePoint> due() const noexcept;
    /// The next frame to be sent; std::nullopt: none. Link ano::device::every_link: to all hosts that were heard.
    std::optional<ano::device::Outgoing::Departure> next();
    /// To be called when `link` is gone: its requests that continue are dropped.
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
    void tell_left_out();
    void send_summaries();
    std::string pulsed_lines() const;

    GatewayDeeds& deeds_;
    Settings of_file_;
    WrittenValues written_;
    std::vector<ManagedParameter> rows_;
    std::unique_ptr<ano::device::Device> device_;    // null: the gateway is no device
    GatewayDeviceCounters counters_;
    ano::device::Counters former_;    // of earlier devices
    std::deque<Pending> saves_;
    std::vector<Listener> listeners_;
    std::optional<ano::TimePoint> summary_due_;
    std::deque<std::vector<std::uint8_t>> frames_;    // in addition to those of the device
    std::deque<Link> frame_links_;
    std::vector<std::uint8_t> leaving_;

    // Valid in take().
    const Asker* asker_ = nullptr;
    std::uint8_t asker_address_ = 0;
    ano::TimePoint now_{};

    ano::TimePoint next_refusal_ = ano::TimePoint::min();
    std::uint64_t untold_refusals_ = 0;
    ano::TimePoint lines_until_ = ano::TimePoint::min();
    unsigned lines_ = 0;
    std::uint64_t lines_left_out_ = 0;    // in the present `lines_per`
};

}    // namespace anogate
