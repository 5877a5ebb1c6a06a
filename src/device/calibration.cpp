// The names of calibration parameters (protocol text, section 4). A host finds the first and the last by name, and derives the
// ids between them.
#include <device/parameters.hpp>

namespace ano::device {
namespace {

template <std::size_t N>
void add_all(Parameters& parameters, std::array<float, N>& values, const std::array<const char*, N / 3>& groups,
             const std::array<float, N>& initial) {
    values = initial;
    for (std::size_t i = 0; i < N; ++i) parameters.add(std::string{"CAL_"} + groups[i / 3] + "_" + "XYZ"[i % 3], values[i]);
}

}    // namespace

void Parameters::add_accelerometer_calibration(std::array<float, 15>& values) {
    add_all<15>(*this, values, {"AOFF", "ASEN", "AEM1", "AEM2", "AEM3"}, {0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 1, 0, 0, 0, 1});
}

void Parameters::add_compass_calibration(std::array<float, 6>& values) {
    add_all<6>(*this, values, {"MOFF", "MSEN"}, {0, 0, 0, 1, 1, 1});
}

}    // namespace ano::device
