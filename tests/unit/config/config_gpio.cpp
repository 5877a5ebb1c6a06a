// GPIO lines in a configuration.
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace anogate::config_gpio_tests {
namespace {

constexpr std::string_view gpio_links = R"("links": ["sim:fc", "udp-listen:0.0.0.0:1,name=ground", "serial:/dev/x,name=bus"])";

std::string with_gpio(std::string_view lines) {
    return "{" + std::string{gpio_links} + ", \"gpio\": [" + std::string{lines} + "]}";
}

TEST(ConfigGpio, reads_every_use) {
    const Settings s = settings_of(with_gpio(R"(
        {"chip": "gpiochip0", "line": 17, "use": "link_up", "link": "fc"},
        {"line": "ACT_LED", "use": "activity", "link": "ground"},
        {"chip": "gpiochip0", "line": 22, "use": "reset", "link": "fc", "active_low": true, "pulse": "50ms", "when": "silent 10s"},
        {"chip": "gpiochip0", "line": "23", "use": "power", "pulse": "3s"},
        {"chip": "/dev/gpiochip1", "line": 24, "use": "inhibit", "links": ["ground", "fc"], "bias": "pull_up", "active_low": true},
        {"chip": "gpiochip0", "line": 25, "use": "rs485", "link": "bus"})"));
    using namespace std::chrono_literals;
    const auto bias = GpioBias::as_is;
    EXPECT_EQ(s.gpio, (std::vector<GpioSettings>{
                          {"gpiochip0", "17", GpioUse::link_up, "fc", {}, false, bias, {}, {}},
                          {"", "ACT_LED", GpioUse::activity, "ground", {}, false, bias, {}, {}},
                          {"gpiochip0", "22", GpioUse::reset, "fc", {}, true, bias, 50ms, 10s},
                          {"gpiochip0", "23", GpioUse::power, "", {}, false, bias, 3s, {}},
                          {"/dev/gpiochip1", "24", GpioUse::inhibit, "", {"ground", "fc"}, true, GpioBias::pull_up, {}, {}},
                          {"gpiochip0", "25", GpioUse::rs485, "bus", {}, false, bias, {}, {}},
                      }));
    EXPECT_EQ(settings_of(print_config(s)), s);
    EXPECT_NE(print_config(s).find("\"line\": 17,"), std::string::npos) << "a number stays one";
}

TEST(ConfigGpio, errors_name_their_location) {
    const auto fault = [](std::string_view line) { return faults_in(with_gpio(line)); };
    EXPECT_EQ(fault(R"({"chip": "c", "line": 1, "use": "link_up", "link": "fc", "active_lo": true})"),
              "/gpio/0/active_lo: unknown key 'active_lo' (did you mean 'active_low'?)\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "linkup", "link": "fc"})").substr(0, 17), "/gpio/0/use: 'use");
    EXPECT_NE(fault(R"({"line": "x", "use": "linkup", "link": "fc"})").find("did you mean 'link_up'?"), std::string::npos);
    EXPECT_EQ(fault(R"({"line": "x", "use": "link_up", "link": "fd"})"),
              "/gpio/0/link: there is no link 'fd' (did you mean 'fc'?); use one of fc, ground, bus\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "inhibit", "links": ["fc", "groud"]})"),
              "/gpio/0/links/1: there is no link 'groud' (did you mean 'ground'?); use one of fc, ground, bus\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "link_up", "link": "fc", "pulse": "1s"})"),
              "/gpio/0/pulse: 'pulse' is not a key of link_up, but of power, reset\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "link_up", "link": "fc", "kind": "serial"})"),
              "/gpio/0/kind: unknown key 'kind' (did you mean 'line'?)\n");
    EXPECT_EQ(fault(R"({"use": "power"})").substr(0, 27), "/gpio/0: 'line' is missing:");
    EXPECT_EQ(fault(R"({"line": "x"})").substr(0, 26), "/gpio/0: 'use' is missing,");
    EXPECT_EQ(fault(R"({"line": 17, "use": "power"})"), "/gpio/0/line: 'line' 17 is a number: 'chip' must name its chip\n");
    EXPECT_EQ(fault(R"({"line": -1, "use": "power", "chip": "c"})"),
              "/gpio/0/line: 'line' must be a line's number such as 17 or its name such as \"GPIO17\", not -1\n");
    EXPECT_EQ(fault("7"), "/gpio/0: must be an object {...}, not 7\n");
    EXPECT_EQ(faults_in(R"({"gpio": {}})"), "/gpio: must be a list [...], not an object\n");
}

TEST(ConfigGpio, a_use_requires_the_links_it_acts_on) {
    const auto fault = [](std::string_view line) { return faults_in(with_gpio(line)); };
    EXPECT_EQ(fault(R"({"line": "x", "use": "activity"})"), "/gpio/0: 'link' is missing: the name of the link\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "rs485"})"), "/gpio/0: 'link' is missing: the name of the link\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "inhibit"})"),
              "/gpio/0: 'links' is missing: the links whose control frames to block\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "reset", "when": "silent 10s"})"),
              "/gpio/0: 'link' is missing: the link to monitor for silence\n");
    EXPECT_EQ(fault(R"({"line": "x", "use": "reset"})"), "");
    EXPECT_EQ(fault(R"({"line": "x", "use": "power"})"), "");
    EXPECT_EQ(fault(R"({"line": "x", "use": "inhibit", "link": "ground"})"), "");
    EXPECT_EQ(fault(R"({"line": "x", "use": "rs485", "link": "fc"})"),
              "/gpio/0/link: 'link' 'fc' is not a serial port: rs485 needs one\n");
}

TEST(ConfigGpio, when_must_be_a_silence_with_a_duration) {
    const auto fault = [](std::string_view when) {
        return faults_in(with_gpio(R"({"line": "x", "use": "reset", "link": "fc", "when": ")" + std::string{when} + "\"}"));
    };
    EXPECT_EQ(fault("silent 10s"), "");
    const std::string must =
        "/gpio/0/when: 'when' must be \"silent\" and a duration such as \"silent 10s\", from 1s to 24h, not ";
    for (const std::string bad : {"10s", "silent", "silent 10", "silent  10s", "silent 1ms", "loud 10s"})
        EXPECT_EQ(fault(bad), must + "'" + bad + "'\n");
}

TEST(ConfigGpio, a_line_can_be_used_only_once) {
    EXPECT_EQ(faults_in(with_gpio(R"({"line": "x", "use": "power"}, {"line": "x", "use": "reset"})")),
              "/gpio/1/line: 'line' 'x' is already used by /gpio/0\n");
    EXPECT_EQ(faults_in(with_gpio(
                  R"({"chip": "gpiochip0", "line": "x", "use": "power"}, {"chip": "gpiochip1", "line": "x", "use": "reset"})")),
              "");
    EXPECT_EQ(
        faults_in(with_gpio(R"({"line": "x", "use": "rs485", "link": "bus"}, {"line": "y", "use": "rs485", "link": "bus"})")),
        "/gpio/1/link: 'link' 'bus' already has a line for rs485 at /gpio/0\n");
    EXPECT_EQ(
        faults_in(
            R"({"links": ["serial:/dev/x,name=bus,flow=hardware"], "gpio": [{"line": "x", "use": "rs485", "link": "bus"}]})"),
        "/gpio/0/link: 'link' 'bus' uses the RTS line by 'flow' or 'rts', which rs485 needs\n");
}

}    // namespace
}    // namespace anogate::config_gpio_tests
