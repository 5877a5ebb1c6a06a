#include <config/link_kind.hpp>
#include <gpio/gpio.hpp>
#include <log/log_line.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

GpioPin::Direction direction(GpioUse use) { return use == GpioUse::inhibit ? GpioPin::Direction::in : GpioPin::Direction::out; }

Duration pulse_of(const GpioSettings& settings) {
    if (settings.pulse) return *settings.pulse;
    return settings.use == GpioUse::power ? Duration{std::chrono::seconds{1}} : Duration{std::chrono::milliseconds{100}};
}

constexpr Duration log_interval = std::chrono::seconds{1};    // between log lines: a bouncing switch must not fill the disk

double seconds(Duration d) { return std::chrono::duration<double>{d}.count(); }

}    // namespace

std::string text(GpioUse use) {
    GpioSettings settings;
    settings.use = use;
    return *find_key(gpio_keys(), "use")->text_in(settings);
}

Gpio::Line::Line(Gpio& gpio, const GpioSettings& settings, asio::io_context& io, AlarmClock& alarms)
    : pin{settings, direction(settings.use), io, alarms, [this, &gpio] { gpio.changed(*this); }},
      alarm{alarms, [this, &gpio] { gpio.ring(*this); }},
      reset{settings.silent_for, Clock::now()} {}

std::string Gpio::Line::what() const {
    const GpioSettings& s = settings();
    std::string names = s.link;
    for (const std::string& name : s.links) names += (names.empty() ? "" : ", ") + name;
    return "gpio " + text(s.use) + (names.empty() ? "" : " of " + names);
}

Gpio::Gpio(asio::io_context& io, AlarmClock& alarms, Inhibit& inhibit)
    : io_{io}, alarms_{alarms}, inhibit_{inhibit}, chips_{io, "gpiochip", [this] {
                                                              for (const auto& line : lines_) line->pin.look();
                                                          }} {}

Gpio::~Gpio() = default;

Gpio::Lines Gpio::change(const std::vector<GpioSettings>& settings, const FindLink& find, LinkSet fresh) {
    Lines before = std::exchange(lines_, {});
    watched_.clear();
    for (const GpioSettings& s : settings) {
        const auto same = std::find_if(before.begin(), before.end(), [&](const auto& line) { return line->settings() == s; });
        if (same == before.end()) {
            lines_.push_back(std::make_unique<Line>(*this, s, io_, alarms_));
        } else {
            lines_.push_back(std::move(*same));
            before.erase(same);
        }
    }
    for (const auto& line : before) let_go(*line);    // first, because the new settings may use the same line of the chip
    for (const auto& line : lines_) connect(*line, find, fresh);
    if (started_) start();
    return before;
}

void Gpio::connect(Line& line, const FindLink& find, LinkSet fresh) {
    const GpioSettings& s = line.settings();
    line.links.clear();
    if (!s.link.empty()) line.links.insert(find(s.link).id());
    for (const std::string& name : s.links) line.links.insert(find(name).id());
    if (line.inhibit_place) inhibit_.set_links(*line.inhibit_place, line.links);
    else if (s.use == GpioUse::inhibit) line.inhibit_place = inhibit_.add(line.links);
    if (s.use == GpioUse::power && !line.started) line.pin.set(true);
    const bool is_disabled = !s.link.empty() && !find(s.link).settings().enabled;
    if (std::exchange(line.link_is_disabled, is_disabled) && !is_disabled) {
        line.reset.heard(Clock::now());
        arm(line);
    }
    if (s.use == GpioUse::activity || s.silent_for) watched_ |= line.links;
    if (s.use == GpioUse::rs485 && fresh.contains(find(s.link).id())) {
        Link& link = find(s.link);    // its kind supports rs485, according to the checked configuration
        link.settings().kind->rs485->use(link, s.active_low, [&line](bool sending) { line.pin.set(sending); });
    }
}

void Gpio::start() {
    started_ = true;
    if (lines_.empty()) return;
    if (!std::exchange(watching_, true)) chips_.start();
    for (const auto& line : lines_)
        if (!std::exchange(line->started, true)) line->pin.start();
}

// Switches lamps and resets off; power stays as it is.
void Gpio::let_go(Line& line) {
    line.alarm.cancel();
    if (line.settings().use != GpioUse::inhibit) line.pin.set(line.settings().use == GpioUse::power);
    else if (line.inhibit_place) inhibit_.remove(*std::exchange(line.inhibit_place, std::nullopt));
    line.pin.stop();
}

void Gpio::stop() {
    chips_.stop();
    for (const auto& line : lines_) let_go(*line);
}

void Gpio::link_state(LinkId link, bool up) {
    for (const auto& line : lines_)
        if (line->settings().use == GpioUse::link_up && line->is_for(link)) line->pin.set(up);
}

void Gpio::heard(LinkId link, TimePoint now) {
    for (const auto& line : lines_)
        if (line->is_for(link)) line->reset.heard(now);
    sends(link, now);
}

void Gpio::sends(LinkId link, TimePoint now) {
    for (const auto& line : lines_) {
        if (line->settings().use != GpioUse::activity || !line->is_for(link) || !line->blink.traffic()) continue;
        if (now >= line->blink.due()) blink(*line, now);
        else line->alarm.set(line->blink.due());
    }
}

void Gpio::blink(Line& line, TimePoint now) {
    const bool lit = line.blink.step(now);
    line.pin.set(lit);
    if (lit) line.alarm.set(line.blink.due());
}

// A line has one alarm, for four purposes: the light changes, the switch may be reported again, the pulse ends, or the link may
// have been silent for the configured time.
void Gpio::ring(Line& line) {
    const TimePoint now = Clock::now();
    if (line.settings().use == GpioUse::activity) {
        blink(line, now);
    } else if (line.settings().use == GpioUse::inhibit) {
        if (line.unlogged > 0) log_inhibit(line, now);
    } else if (line.pulsing) {
        line.pulsing = false;
        line.pin.set(line.settings().use == GpioUse::power);
        arm(line);
    } else if (const auto due = line.reset.due(); due && now >= *due && line.pin.is_held() && !line.link_is_disabled) {
        if (begin_pulse(line, now)) log_warning("{}: silent for {} s, pulsed", line.what(), seconds(*line.settings().silent_for));
    } else {
        arm(line);
    }
}

// Sets no alarm while the line is not held: changed() calls this function again.
void Gpio::arm(Line& line) {
    if (const auto due = line.reset.due(); due && !line.pulsing && line.pin.is_held() && !line.link_is_disabled)
        line.alarm.set(*due);
}

bool Gpio::begin_pulse(Line& line, TimePoint now) {
    const bool is_reset = line.settings().use == GpioUse::reset;
    line.pin.set(is_reset);
    if (!line.pin.is_held()) return line.pin.set(!is_reset), false;
    line.pulsing = true;
    ++line.pulses;
    line.reset.pulsed(now);
    line.alarm.set(now + pulse_of(line.settings()));
    return true;
}

std::optional<Gpio::Refusal> Gpio::act(Line& line, TimePoint now) {
    const GpioUse use = line.settings().use;
    const auto not_there = [&] { return Refusal{"the line is not available: " + line.pin.error()}; };
    if (!line.pin.is_held()) return not_there();
    if (line.pulsing) return Refusal{"already in progress", pulse_of(line.settings())};
    if (use == GpioUse::reset && !line.reset.may_pulse(now))
        return Refusal{"it was reset less than a minute ago", line.reset.may_pulse_at() - now};
    if (!begin_pulse(line, now)) return not_there();
    log_info("{}: {} on request", line.what(), use == GpioUse::reset ? "pulsed" : "power-cycled");
    return std::nullopt;
}

void Gpio::changed(Line& line) {
    const bool held = line.pin.is_held();
    if (held && !line.was_held) {
        log_info("{}: holds {} line {}", line.what(), line.pin.line()->chip(), line.pin.line()->offset());
        arm(line);
    } else if (!held) {
        log_warning("{}: {}; waiting for it", line.what(), line.pin.error());
    }
    line.was_held = held;
    if (line.settings().use == GpioUse::inhibit) inhibit_changed(line);
}

void Gpio::inhibit_changed(Line& line) {
    const bool on = !line.pin.is_held() || line.pin.active();
    if (line.inhibit_place) inhibit_.set(*line.inhibit_place, on);
    if (on == std::exchange(line.was_inhibiting, on)) return;
    ++line.unlogged;
    if (!line.alarm.is_set()) log_inhibit(line, Clock::now());
}

void Gpio::log_inhibit(Line& line, TimePoint now) {
    const std::uint64_t changes = std::exchange(line.unlogged, 0);
    log_warning("{}: {}{}", line.what(),
                inhibit_.is_on(*line.inhibit_place) ? "on, control frames are dropped" : "off, control frames are forwarded",
                changes > 1 ? ", changed " + std::to_string(changes) + " times" : "");
    line.alarm.set(now + log_interval);
}

}    // namespace anogate
