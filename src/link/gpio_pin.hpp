// A GPIO line over its life: absent, in use by another, lost with its chip, it is waited for.
#pragma once
#include <link/descriptor.hpp>
#include <link/gpio_line.hpp>
#include <link/reconnect.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

class GpioPin {
public:
    enum class Direction { in, out };

    /// `changed`: it is held now, or no longer (or for another reason), or an input has changed. Comes from the loop, or from
    /// start(); never after stop().
    GpioPin(GpioSettings settings, Direction direction, asio::io_context& io, AlarmClock& alarms, std::function<void()> changed);

    void start();
    /// Lets go of the line; an output stays as it is.
    void stop();
    /// A chip came, went or changed its permissions: looks at once.
    void look();

    /// An output is to be so, now and whenever the line comes back.
    void set(bool active);
    /// What an output is to be; what an input was last.
    bool active() const noexcept { return active_; }

    bool is_held() const noexcept { return line_ != nullptr; }
    /// Why it is not held.
    const std::string& error() const noexcept { return error_; }
    /// The line itself; nullptr while it is not held.
    const GpioLine* line() const noexcept { return line_.get(); }
    const GpioSettings& settings() const noexcept { return settings_; }

    /// Changes of the value: by us, or of an input as the kernel counted them.
    std::uint64_t edges() const noexcept { return edges_; }
    /// The last of them; zero: none yet.
    TimePoint edge_at() const noexcept { return edge_at_; }

private:
    Opened<void> open();
    void not_held(std::string why);
    bool read_value();
    void take_edges();
    void lose();
    void count(std::uint64_t edges);

    GpioSettings settings_;
    Direction direction_;
    Descriptor events_;
    Reconnect reconnect_;
    std::function<void()> changed_;
    std::unique_ptr<GpioLine> line_;
    std::string error_ = "not tried yet";
    bool active_ = false;
    std::uint64_t edges_ = 0;
    TimePoint edge_at_{};
};

}    // namespace anogate
