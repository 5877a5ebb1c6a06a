#include <config/key_rows.hpp>

namespace anogate {
namespace {

using namespace key_rows;
using P = GpioSettings;

constexpr std::uint64_t max_line_name = 31;    // bytes; limit of the kernel

constexpr Key<P> gpio_rows[] = {
    text<&P::chip>("chip", 1, max_path,
                   "the chip by name, path or label; not needed if only one chip has a line with this name") |
        as("gpiochip0"),
    row<&P::line>({.name = "line",
                   .form = Form::line,
                   .help = "the line, by number on the chip or by name",
                   .min = 1,
                   .max = max_line_name,
                   .required = true}),
    choice<&P::use>("use", "link_up|activity|power|reset|inhibit|rs485",
                    "on while the link is up, blinks with its traffic, switches power, pulses a reset, blocks control frames, "
                    "or switches an RS-485 transceiver to sending") |
        needed,
    text<&P::link>("link", 1, max_name, "the name of the link") | as("LINK"),
    row<&P::links>({.name = "links",
                    .form = Form::names,
                    .help = "the links whose control frames are blocked while the line is active",
                    .min = 1,
                    .max = max_name,
                    .kinds = "inhibit"}),
    boolean<&P::active_low>("active_low", "the line is active when it is low"),
    choice<&P::bias>("bias", "as_is|disabled|pull_up|pull_down", "the resistor inside the chip"),
    duration<&P::pulse>("pulse", 1, 60 * second, "how long the reset is active or the power is off (default: 100ms, power 1s)") |
        of("power reset"),
    row<&P::silent_for>({.name = "when",
                         .form = Form::silence,
                         .help = "reset automatically when the link received no valid frame for this time; at most once a minute",
                         .min = second,
                         .max = day,
                         .kinds = "reset"}),
};

}    // namespace

Keys<GpioSettings> gpio_keys() noexcept { return gpio_rows; }

}    // namespace anogate
