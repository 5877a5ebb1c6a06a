// Prints the table of the capacity of a CAN bus in src/link/README.md.
#include "can_rate.hpp"

#include <cstdio>

int main() {
    std::printf(
        "| DATA | framing | 500 kbit/s | 1 Mbit/s | FD 500 kbit/s / 2 Mbit/s | FD 1 / 5 Mbit/s |\n|---|---|---|---|---|---|\n");
    for (const std::size_t data : {4u, 13u, 50u, 200u}) {
        for (const bool isotp : {false, true}) {
            std::printf("| %zu | %s |", data, isotp ? "isotp" : "stream");
            for (const auto& [rate, data_rate] : {std::pair{500e3, 0.0}, {1e6, 0.0}, {500e3, 2e6}, {1e6, 5e6}}) {
                const std::size_t frame = data + 8;
                const auto sizes = isotp ? can_rate::isotp(frame, data_rate > 0) : can_rate::stream(frame, data_rate > 0);
                const double frames = 1 / can_rate::seconds(sizes, rate, data_rate);
                std::printf(" %.0f frames, %.1f kB |", frames, frames * static_cast<double>(data) / 1000);
            }
            std::printf("\n");
        }
    }
}
