#include "service_config.hpp"

#include <ano/hex.hpp>
#include <ano_json/frame_json.hpp>
#include <nlohmann/json.hpp>

namespace anoctl {

std::string service_config(const std::string& device, std::uint32_t baud, std::uint8_t v7_device) {
    const std::string protocol = v7_device == 0 ? "\"profile\": \"vendor\""
                                                : "\"protocol\": \"v7\", \"v7_device\": \"" + ano::hex_byte(v7_device) + "\"";
    const std::string rate = baud == 0 ? "" : "\"baud\": " + std::to_string(baud) + ", ";
    return "// Every key, with its default: /etc/anogate/anogate.full.json\n"
           "// After a change: anogated --check && sudo systemctl reload anogated\n"
           "{\n"
           "    \"links\": [\n"
           "        {\"name\": \"fc\", \"kind\": \"serial\", \"device\": " +
           ano::Json(device).dump() + ", " + rate + protocol +
           "},\n"
           "        {\"name\": \"ground\", \"kind\": \"udp-listen\", \"address\": \"0.0.0.0:12333\"}\n"
           "    ],\n"
           "    \"control\": {\"http\": \"127.0.0.1:8088\"}\n"
           "}\n";
}

}    // namespace anoctl
