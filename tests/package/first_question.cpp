// Prints the first frame of a host that reads the parameters of the flight controller, and the time of its repeat.
#include <host/parameters.hpp>

#include <chrono>
#include <cstdio>

int main() {
    const ano::TimePoint start = ano::Clock::now();
    ano::host::Device device{0xDC};
    ano::host::Parameters parameters{device};
    parameters.read_all(start);
    const auto frame = device.next_frame(start);
    const auto due = device.due();
    if (!frame || !due) return 1;
    for (const std::uint8_t byte : frame->bytes()) std::printf("%02X ", byte);
    std::printf("again after %d ms\n",
                static_cast<int>(std::chrono::duration_cast<std::chrono::milliseconds>(*due - start).count()));
}
