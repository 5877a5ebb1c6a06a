// One requested line of a GPIO chip. Only its source includes libgpiod.
#pragma once
#include <gateway/settings.hpp>
#include <sys/expected.hpp>
#include <sys/unique_fd.hpp>

#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// The line stays requested until destruction, which does not change an output. Values are logical: inverted for `active_low`.
class GpioLine {
public:
    /// An input that reports its edges. The error names chip, line and the program that holds the line.
    static Expected<std::unique_ptr<GpioLine>> open_input(const GpioSettings& settings);
    /// An output with the initial value `active`.
    static Expected<std::unique_ptr<GpioLine>> open_output(const GpioSettings& settings, bool active);

    ~GpioLine();
    GpioLine(const GpioLine&) = delete;
    GpioLine& operator=(const GpioLine&) = delete;

    /// False: the chip was removed.
    bool set(bool active) noexcept;
    /// std::nullopt: the chip was removed.
    std::optional<bool> value() noexcept;
    /// For an input: readable when there are edges. Empty if no more descriptors can be opened.
    UniqueFd edge_descriptor() const;
    /// Reads the waiting edges, at most 16 per call, and returns their number; std::nullopt: the chip was removed.
    std::optional<unsigned> read_edges() noexcept;

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
