#include <gpio/gpio_pin.hpp>

namespace anogate {

GpioPin::GpioPin(GpioSettings settings, Direction direction, asio::io_context& io, AlarmClock& alarms,
                 std::function<void()> changed)
    : settings_{std::move(settings)},
      direction_{direction},
      events_{io},
      reconnect_{alarms, Clock::now, [this] { return open(); }, [this](LinkError why) { not_held(std::move(why.text)); }},
      changed_{std::move(changed)} {}

void GpioPin::start() { reconnect_.start(); }

void GpioPin::stop() {
    reconnect_.stop();
    events_.close();
    line_.reset();
    error_ = "stopped";
}

void GpioPin::look() {
    if (!line_) reconnect_.try_now();
    else if (!line_->value()) lose();
}

Opened<void> GpioPin::open() {
    auto line = direction_ == Direction::in ? GpioLine::open_input(settings_) : GpioLine::open_output(settings_, active_);
    if (!line) return Unexpected{std::move(line.error())};
    line_ = std::move(*line);
    if (direction_ == Direction::in && !read_value()) return Unexpected{settings_.line + ": edge detection is not available"};
    reconnect_.came_up(Clock::now());
    error_.clear();
    changed_();
    return {};
}

void GpioPin::not_held(std::string why) {
    if (error_ == why) return;
    error_ = std::move(why);
    changed_();
}

// Requests edges before reading the level, so that no edge in between is missed.
bool GpioPin::read_value() {
    UniqueFd events = line_->edge_descriptor();
    const auto level = line_->value();
    if (!events || !level) {
        line_.reset();
        return false;
    }
    events_.open(std::move(events));
    events_.read_with([this] { read_edges(); });
    active_ = *level;
    return true;
}

// The kernel stores 16 edges and drops more, so the level is read after the edges and determines the value. A later edge causes
// another call.
void GpioPin::read_edges() {
    const auto edges = line_->read_edges();
    const auto level = edges ? line_->value() : std::nullopt;
    if (!level) return lose();
    count(*edges);
    if (active_ == *level) return;
    active_ = *level;
    changed_();
}

void GpioPin::lose() {
    std::string why = line_->chip() + " line " + std::to_string(line_->offset()) + ": the chip was removed";
    events_.close();
    line_.reset();
    reconnect_.lost(std::move(why));
}

void GpioPin::set(bool active) {
    if (active_ == active) return;
    active_ = active;
    if (!line_) return;
    if (line_->set(active)) count(1);
    else lose();
}

void GpioPin::count(std::uint64_t edges) {
    if (edges == 0) return;
    edges_ += edges;
    edge_at_ = Clock::now();
}

}    // namespace anogate
