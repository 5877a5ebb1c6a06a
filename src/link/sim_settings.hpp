// The settings of a simulated device and of the faults on its line.
#pragma once
#include <ano/attitude.hpp>
#include <ano/schema.hpp>
#include <ano/time.hpp>
#include <world/device_forms.hpp>

#include <cstdint>
#include <optional>
#include <string>

namespace anogate {

/// How a simulated device parses frames.
enum class SimParser : std::uint8_t {
    searching,    // damaged frames do not affect later ones
    vendor,       // as the vendor's libraries: a damaged LEN swallows the next frames
};

struct SimSettings {
    std::string device = "fc";
    std::uint16_t hz = 50;      // Hz, of attitude and inertial frames, 1 to 100; slower frames scale with it
    std::uint8_t dev_id = 0;    // 0: the default of `device`
    std::uint32_t seed = 1;
    ano::world::ParameterForm parameters = ano::world::ParameterForm::typed;
    ano::world::TextForm texts = ano::world::TextForm::en;
    ano::ByteOrder firmware = ano::ByteOrder::little;    // byte order of the codes of an upgrade
    bool any_address = false;                            // accepts frames for every address
    ano::EulerSigns euler{};                             // the signs of its Euler angles

    // ano::world::Faults; std::nullopt: no such fault.
    std::optional<std::uint8_t> loss{}, duplicate{}, corrupt{};    // %
    std::optional<ano::Duration> delay{}, jitter{}, deaf_after{}, restart_after{}, slow{};
    bool one_at_a_time = false;
    SimParser parser = SimParser::searching;
    bool operator==(const SimSettings&) const = default;
};

}    // namespace anogate
