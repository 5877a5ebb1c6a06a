// Connects the GPIO lines with the links: lamps, power, resets, the inhibit switch, RS-485. The logic is in include/gateway,
// the access to the lines in gpio_line.hpp.
#pragma once
#include <gateway/blink.hpp>
#include <gateway/inhibit.hpp>
#include <gateway/reset_policy.hpp>
#include <gpio/gpio_pin.hpp>
#include <link/link.hpp>
#include <sys/device_watch.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

class Gpio {
public:
    struct Line;
    using Lines = std::vector<std::unique_ptr<Line>>;
    using FindLink = std::function<Link&(const std::string& name)>;

    /// `inhibit` receives the states of the switches. There are no lines before change().
    Gpio(asio::io_context& io, AlarmClock& alarms, Inhibit& inhibit);
    ~Gpio();

    /// Replaces the lines by those of `settings`. Lines with unchanged settings are kept; the other old ones are released and
    /// returned. The caller must keep these for a while, because the loop may still hold callbacks of them, which run no later
    /// than those of a descriptor closed now. `find` must find every link that the settings name; those in `fresh` have not
    /// started. A link with rs485 calls its line, and must be destroyed first.
    Lines change(const std::vector<GpioSettings>& settings, const FindLink& find, LinkSet fresh);
    /// To be called before the links start, so that a switch applies to the first frame. Lines that are added later start at
    /// once.
    void start();
    /// Switches lamps and resets off; power stays as it is.
    void stop();

    void link_state(LinkId link, bool up);
    /// Whether some line depends on the frames of this link.
    bool watches(LinkId link) const noexcept { return watched_.contains(link); }
    /// To be called for each valid frame received on a watched link.
    void heard(LinkId link, TimePoint now);
    /// To be called when frames are sent on a watched link.
    void sends(LinkId link, TimePoint now);

    const Lines& lines() const noexcept { return lines_; }
    /// The reason why a request is refused.
    struct Refusal {
        std::string why;
        Duration wait{};    // the request may be repeated after this time; zero: no use
    };
    /// On request, pulses a reset, or switches power off and on again.
    std::optional<Refusal> act(Line& line, TimePoint now);

private:
    void connect(Line& line, const FindLink& find, LinkSet fresh);
    void let_go(Line& line);
    void ring(Line& line);
    void blink(Line& line, TimePoint now);
    /// False: the chip was lost.
    bool begin_pulse(Line& line, TimePoint now);
    void arm(Line& line);
    void changed(Line& line);
    void inhibit_changed(Line& line);
    void log_inhibit(Line& line, TimePoint now);

    asio::io_context& io_;
    AlarmClock& alarms_;
    Inhibit& inhibit_;
    LinkSet watched_;
    Lines lines_;
    DeviceWatch chips_;
    bool started_ = false;
    bool watching_ = false;    // for chips
};

/// One GPIO line.
struct Gpio::Line {
    Line(Gpio& gpio, const GpioSettings& settings, asio::io_context& io, AlarmClock& alarms);

    const GpioSettings& settings() const noexcept { return pin.settings(); }
    bool is_for(LinkId id) const noexcept { return links.contains(id); }
    /// "gpio reset of fc", for the log.
    std::string what() const;

    GpioPin pin;
    Alarm alarm;
    LinkSet links;
    Blink blink;
    ResetPolicy reset;
    std::optional<std::size_t> inhibit_place{};    // of an inhibit switch
    bool link_is_disabled = false;                 // its silence is ignored
    bool pulsing = false;                          // a reset is on, or power is off for a while
    std::uint64_t pulses = 0;
    bool was_held = false;
    bool started = false;
    std::optional<bool> was_inhibiting{};    // std::nullopt: not reported yet
    std::uint64_t unlogged = 0;              // changes of an inhibit switch that are not logged yet
};

/// "link_up" and so on.
std::string text(GpioUse use);

}    // namespace anogate
