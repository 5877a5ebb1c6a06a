// The gateway as a V8 device: who it is, its parameters and commands, its lines in the log of hosts. It decides who may change it. No I/O,
// no clock: frames and a time in, frames, deeds and the next due time out.
//
// Flow:    GatewayDevice device{deeds};
//          device.configure(settings_of_file, written);
//          device.take(frame, {link, "ground", false, false}, now);    // what is for it, or for everybody
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

/// A link as hosts see it in a flexible frame: number u8 (that of its parameters, from 0), state u8, and three u32.
struct LinkSummary {
    enum class State : std::uint8_t { disabled, waiting, up };
    State state{};
    std::uint64_t frames_in = 0, frames_out = 0;
    std::uint64_t dropped = 0;    // of both ways
};

/// What a host may ask for, and others do. Each says why not, in a clause; empty: it is done, or begins.
class GatewayDeeds {
public:
    /// These values hold from now on.
    virtual void apply(const WrittenValues& written) = 0;
    /// Calls GatewayDevice::saved() once it is on the disk or can't be, not at once.
    virtual std::string save(const WrittenValues& written) = 0;
    virtual std::string reload() = 0;
    virtual std::string restart(const std::string& link) = 0;
    virtual std::string scan() = 0;
    /// `line` counts those of Settings::gpio that can be asked for something.
    virtual std::string pulse(std::size_t line) = 0;
    virtual std::string start_recording() = 0;
    virtual std::string stop_recording() = 0;
    virtual std::vector<LinkSummary> summaries() = 0;
    /// What the control interface asked for just now is not done; the protocol has no such answer.
    virtual void refuse_ourselves(const std::string& why) = 0;
    /// A line for the log of the program.
    virtual void warn(const std::string& line) = 0;

protected:
    ~GatewayDeeds() = default;
};

/// What became of the frames that came for it.
struct GatewayDeviceCounters {
    std::uint64_t answered = 0;          // questions, and acts that were done
    std::uint64_t not_managed = 0;       // acts from links without manage=yes
    std::uint64_t would_lock_out = 0;    // writes that would close the link of who writes
    std::uint64_t refused = 0;           // acts that can't be done now; the log says why
    std::uint64_t to_everybody = 0;      // acts to 0xFF: they are for devices
    std::uint64_t unanswered = 0;        // what it does not have, or was not laid out as the protocol has it
    std::uint64_t lines_left_out = 0;    // of the log of hosts, where there were too many
};

/// A parameter as people read it.
struct ManagedValue {
    const ManagedParameter* row = nullptr;
    double value = 0;
    ValueFrom from{};
};

class GatewayDevice {
public:
    using Link = ano::device::Link;
    using LogColor = ano::device::LogColor;

    /// Who a frame came from. `ourselves`: by the control interface, and no channel.
    struct Asker {
        Link link = 0;
        std::string name{};    // of the link
        bool may_manage = false;
        bool is_ourselves = false;
    };

    /// Refused acts are told once in so long.
    static constexpr ano::Duration between_refusals = std::chrono::seconds{5};
    static constexpr ano::Duration between_summaries = std::chrono::seconds{1};
    /// Lines for hosts: so many in so long, then how many were left out.
    static constexpr unsigned max_lines = 10;
    static constexpr ano::Duration lines_per = std::chrono::seconds{5};
    static constexpr std::size_t max_saves = 8, max_listeners = 8;

    explicit GatewayDevice(GatewayDeeds& deeds) : deeds_{deeds} {}

    /// What the file says, and what was written behind it. Without an id, or with that of hosts, it is no device.
    void configure(const Settings& of_file, WrittenValues written);
    bool is_there() const noexcept { return device_ != nullptr; }

    /// The messages that take() does something with. What else comes to everybody is telemetry.
    static bool concerns(std::uint8_t id) noexcept;
    /// A frame that is for the gateway's id or for everybody.
    void take(ano::FrameView frame, const Asker& asker, ano::TimePoint now);
    /// What save() began has ended; `fault` is empty when it is kept.
    void saved(const std::string& fault, ano::TimePoint now);
    /// For the log of the hosts that were heard.
    void log(std::string_view text, LogColor color, ano::TimePoint now);
    void run(ano::TimePoint now);
    std::optional<ano::TimePoint> due() const noexcept;
    /// The next frame that is to leave; ano::device::every_link: to all hosts that were heard.
    std::optional<ano::device::Outgoing::Departure> next();
    /// Whoever asked by `link` for something that goes on is gone.
    void forget(Link link);

    GatewayDeviceCounters counters() const noexcept;
    /// Valid until configure().
    std::vector<ManagedValue> values() const;
    const WrittenValues& written() const noexcept { return written_; }

private:
    struct Pending {    // waits for the disk
        std::uint8_t address;
        Link link;
        std::array<std::uint8_t, 3> check;
    };
    struct Listener {    // to summaries
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
    std::unique_ptr<ano::device::Device> device_;    // null: it is none
    GatewayDeviceCounters counters_;
    ano::device::Counters former_;    // of the devices before
    std::deque<Pending> saves_;
    std::vector<Listener> listeners_;
    std::optional<ano::TimePoint> summary_due_;
    std::deque<std::vector<std::uint8_t>> frames_;    // beside those of the device
    std::deque<Link> frame_links_;
    std::vector<std::uint8_t> leaving_;

    // While a frame is taken.
    const Asker* asker_ = nullptr;
    std::uint8_t asker_address_ = 0;
    ano::TimePoint now_{};

    ano::TimePoint next_refusal_ = ano::TimePoint::min();
    std::uint64_t untold_refusals_ = 0;
    ano::TimePoint lines_until_ = ano::TimePoint::min();
    unsigned lines_ = 0;
    std::uint64_t lines_left_out_ = 0;    // of this while
};

}    // namespace anogate
