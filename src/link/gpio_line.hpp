// One requested line of a GPIO chip: libgpiod, and nothing else of the house includes it.
#pragma once
#include <gateway/settings.hpp>
#include <link/expected.hpp>
#include <link/unique_fd.hpp>

#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// Held by us until it is destroyed; an output is left as it is. Values are logical: what `active_low` makes of the level.
class GpioLine {
public:
    /// An input, whose edges are events. Why there is none names chip, line and holder.
    static Expected<std::unique_ptr<GpioLine>> open_input(const GpioSettings& settings);
    /// An output that begins with `active`.
    static Expected<std::unique_ptr<GpioLine>> open_output(const GpioSettings& settings, bool active);

    ~GpioLine();
    GpioLine(const GpioLine&) = delete;
    GpioLine& operator=(const GpioLine&) = delete;

    /// False: the chip is gone.
    bool set(bool active) noexcept;
    /// Nothing: the chip is gone.
    std::optional<bool> value() noexcept;
    /// Of an input: readable when there are edges. Empty when out of descriptors.
    UniqueFd edge_descriptor() const;
    /// Takes edges that have happened and says how many, 16 at the most a call; nothing: the chip is gone.
    std::optional<unsigned> take_edges() noexcept;

    const std::string& chip() const noexcept { return chip_; }    // "gpiochip0"
    unsigned offset() const noexcept { return offset_; }
    const std::string& name() const noexcept { return name_; }    // may be empty

private:
    struct Request;
    GpioLine(std::unique_ptr<Request> request, std::string chip, unsigned offset, std::string name);
    static Expected<std::unique_ptr<GpioLine>> open(const GpioSettings& settings, bool output, bool active);

    std::unique_ptr<Request> request_;
    std::string chip_;
    unsigned offset_;
    std::string name_;
};

}    // namespace anogate
