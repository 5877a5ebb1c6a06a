// A complete host: sets the named parameters, and prints all parameters of the device. It uses V8 on its standard input and
// output, and prints messages to standard error. On a serial port:
//     stty -F /dev/ttyUSB0 500000 raw -echo && ./parameters 0x21 RATE=20 <>/dev/ttyUSB0 >&0
#include <ano/parser.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <string>

using namespace std::chrono_literals;

// Drives `device` until `task` has ended: passes every received frame to it, and sends every frame of it.
static bool finish(ano::host::Device& device, ano::FrameParser& parser, const ano::host::Task& task) {
    while (!task.end()) {
        const auto now = ano::Clock::now();
        parser.expire(now);
        while (const auto frame = parser.next()) device.take(*frame, now);
        while (const auto frame = device.next_frame(now))
            if (write(STDOUT_FILENO, frame->bytes().data(), frame->bytes().size()) < 0) return false;
        if (task.end()) break;

        const auto due = std::min(device.due().value_or(now + 1s), parser.deadline().value_or(now + 1s));
        pollfd input{STDIN_FILENO, POLLIN, 0};
        poll(&input, 1, static_cast<int>(std::max(due - now, ano::Duration{}) / 1ms) + 1);
        if (input.revents == 0) continue;
        const auto room = parser.prepare();
        const ssize_t n = read(STDIN_FILENO, room.data(), room.size());
        if (n <= 0) return false;
        parser.commit(static_cast<std::size_t>(n), now);
    }
    std::cerr << task.end()->fault.text() << (task.end()->fault.empty() ? "" : "\n");
    return task.end()->ending == ano::host::Ending::done;
}

int main(int argc, char** argv) {
    if (argc < 2) return 2;
    ano::FrameParser parser{{}};
    ano::host::Device device{static_cast<std::uint8_t>(std::strtoul(argv[1], nullptr, 0))};
    ano::host::Parameters before{device}, after{device};
    before.read_all(ano::Clock::now());
    if (!finish(device, parser, before)) return 1;

    for (int i = 2; i < argc; ++i) {
        const std::string word = argv[i], name = word.substr(0, word.find('='));
        const auto found = before.find(name).parameter;
        if (!found || name.size() == word.size()) return 2;
        ano::host::ParameterWrite write{device, *found, std::strtod(word.c_str() + name.size() + 1, nullptr)};
        write.start(ano::Clock::now());
        if (!finish(device, parser, write)) return 1;
    }
    after.read_all(ano::Clock::now());
    if (!finish(device, parser, after)) return 1;
    for (const auto& parameter : after.descriptions())
        if (const auto value = after.value(parameter.id))
            std::cerr << parameter.name << " = " << ano::host::to_string(*value) << ", " << parameter.info << '\n';
}
