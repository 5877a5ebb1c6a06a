// A complete device: a barometer that uses V8 on its standard input and output. On a serial port:
//     stty -F /dev/ttyUSB0 500000 raw -echo && ./barometer values <>/dev/ttyUSB0 >&0
#include <ano/parser.hpp>
#include <device/device.hpp>

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>

using namespace std::chrono_literals;

// Replaces the reading of a sensor: its height in cm.
static float measured() { return 12000; }

int main(int argc, char** argv) {
    const char* file = argc > 1 ? argv[1] : "barometer.values";
    float offset = 0;
    std::uint16_t rate = 10;
    ano::device::Device device{{.id = 0x21, .name = "Barometer"}};

    auto& parameters = device.parameters();
    parameters.add("OFFSET", offset, {.info = "cm, added to the height", .min = -1e6f, .max = 1e6f});
    parameters.add("RATE", rate, {.info = "heights a second", .min = 1, .max = 50});
    std::ifstream saved{file};
    double saved_offset = 0;
    std::int64_t saved_rate = 0;
    if (saved >> saved_offset >> saved_rate) {
        parameters.write("OFFSET", saved_offset);
        parameters.write("RATE", saved_rate);
    }
    parameters.on_save([&] {
        std::ofstream out{file};
        out << offset << ' ' << rate << std::endl;
        return out.good();
    });
    device.commands().add({1, 0, 1}, "ZERO", "the height is 0 here", [&] {
        offset = -measured();
        device.log("the height is 0 here", ano::device::LogColor::green);
    });

    ano::FrameParser parser{{.max_data = 198}};
    auto next_height = ano::Clock::now();
    while (true) {
        const auto now = ano::Clock::now();
        if (now >= next_height) {
            ano::Draft<"altitude"> altitude;
            if (altitude.set<"alt_bar">(static_cast<int>(measured() + offset))) device.send(altitude, ano::address::host);
            next_height = now + std::chrono::nanoseconds{1s} / rate;
        }
        parser.expire(now);
        while (const auto frame = parser.next()) device.take(*frame, now);
        device.run(now);
        while (const auto out = device.next())
            if (write(STDOUT_FILENO, out->frame.bytes().data(), out->frame.bytes().size()) < 0) return 1;

        const auto due = std::min({next_height, device.due().value_or(next_height), parser.deadline().value_or(next_height)});
        pollfd input{STDIN_FILENO, POLLIN, 0};
        poll(&input, 1, static_cast<int>(std::max(due - now, ano::Duration{}) / 1ms) + 1);
        if (input.revents == 0) continue;
        const auto room = parser.prepare();
        const ssize_t n = read(STDIN_FILENO, room.data(), room.size());
        if (n <= 0) return 0;
        parser.commit(static_cast<std::size_t>(n), now);
    }
}
