// GPIO on the control interface: its section of GET /status, and POST /gpio.
#pragma once
#include <gpio/gpio.hpp>
#include <http/response.hpp>

#include <nlohmann/json_fwd.hpp>

#include <string>

namespace anogate {

/// One object per line (src/link/README.md, "GPIO").
nlohmann::ordered_json gpio_json(const Gpio& gpio, TimePoint now);

/// POST /gpio: {"line", "chip", "link", "use", "action"} must match exactly one reset or power line, which is then pulsed or
/// switched off and on again. Returns its state, or an error: 400, 404, 409 or 429.
http::Response gpio_request(Gpio& gpio, const std::string& body, TimePoint now);

}    // namespace anogate
