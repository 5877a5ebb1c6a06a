#include <link/gpio_pin.hpp>
#include <link/link_context.hpp>

namespace anogate {

GpioPin::GpioPin(GpioSettings settings, Direction direction, asio::io_context& io, AlarmClock& alarms,
                 std::function<void()> changed)
    : settings_{std::move(settings)},
      direction_{direction},
      events_{io},
      retry_{alarms, [this] { try_open(); }, retry_slack},
      changed_{std::move(changed)} {}

void GpioPin::start() {
    stopped_ = false;
    try_open();
}

void GpioPin::stop() {
    stopped_ = true;
    retry_.cancel();
    events_.close();
    line_.reset();
    error_ = "stopped";
}

void GpioPin::look() {
    if (stopped_) return;
    if (!line_) return try_open();
    if (!line_->value()) lose();
}

void GpioPin::try_open() {
    GpioLine::Opened opened = direction_ == Direction::in ? GpioLine::open_input(settings_)
                                                          : GpioLine::open_output(settings_, active_);
    line_ = std::move(opened.line);
    if (line_ && direction_ == Direction::in && !read_value()) opened.error = settings_.line + ": its edges can't be had";
    if (!line_) {
        const bool news = error_ != opened.error;
        error_ = std::move(opened.error);
        retry_.set(backoff_.retry_at(Clock::now()));
        if (news) changed_();
        return;
    }
    retry_.cancel();
    backoff_.came_up(Clock::now());
    error_.clear();
    changed_();
}

// The edges first, then the level: an edge between the two is reported as well.
bool GpioPin::read_value() {
    UniqueFd events = line_->edge_descriptor();
    const auto level = line_->value();
    if (!events || !level) {
        line_.reset();
        return false;
    }
    events_.open(std::move(events));
    events_.read_with([this] { take_edges(); });
    active_ = *level;
    return true;
}

// The kernel keeps 16 edges and drops what comes on top: the level decides, read behind them. A later edge wakes us again.
void GpioPin::take_edges() {
    const auto edges = line_->take_edges();
    const auto level = edges ? line_->value() : std::nullopt;
    if (!level) return lose();
    count(*edges);
    if (active_ == *level) return;
    active_ = *level;
    changed_();
}

void GpioPin::lose() {
    error_ = line_->chip() + " line " + std::to_string(line_->offset()) + ": the chip is gone";
    events_.close();
    line_.reset();
    retry_.set(backoff_.retry_at(Clock::now()));
    changed_();
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
