// The duration of operations with a device over a line, compared with the minimum that the line needs.
#include "device_line.hpp"
#include "gateway_process.hpp"
#include "goals.hpp"
#include "traffic_ends.hpp"

#include <ano/address.hpp>
#include <support/bytes.hpp>
#include <support/http.hpp>

#include <nlohmann/json.hpp>

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>

namespace bench {

using namespace std::chrono_literals;

namespace {

using Seconds = std::chrono::duration<double>;

// Read line by line, so that the connection is never idle.
nlohmann::json last_line(const GatewayProcess& gateway, const std::string& head, const std::string& body = {}) {
    const std::string answer = support::http(
        gateway.control(), head + " HTTP/1.0\r\nConnection: close\r\nAccept: application/x-ndjson\r\n" +
                               "Content-Type: application/octet-stream\r\nContent-Length: " + std::to_string(body.size()) +
                               "\r\n\r\n" + body);
    must(answer.ends_with('\n'), answer.c_str());
    return nlohmann::json::parse(answer.substr(answer.rfind('\n', answer.size() - 2) + 1), nullptr, false);
}

void until_heard(const GatewayProcess& gateway) {
    for (int i = 0; i < 500; ++i) {
        if (support::http(gateway.control(), "GET /devices HTTP/1.0\r\nConnection: close\r\n\r\n").find("0xDC") !=
            std::string::npos)
            return;
        std::this_thread::sleep_for(20ms);
    }
    must(false, "the device is heard");
}

struct Took {
    double seconds;
    std::uint64_t bytes_there, bytes_back;
};

Took took(Run& run, DeviceLine::Wire wire, support::LineFaults faults, std::size_t parameters, const std::string& head,
          const std::string& body = {}) {
    DeviceLine line{wire, faults, parameters};
    const GatewayProcess gateway{run.anogated, {line.link()}};
    until_heard(gateway);
    const auto before = line.bytes();
    const auto begin = std::chrono::steady_clock::now();
    const nlohmann::json last = last_line(gateway, head, body);
    const double seconds = Seconds(std::chrono::steady_clock::now() - begin).count();
    must(last.is_object() && last.value("state", "") == "done", last.dump().substr(0, 300).c_str());
    must(!last.contains("result") || !last["result"].contains("incomplete"), "whole");
    return {seconds, line.bytes().first - before.first, line.bytes().second - before.second};
}

// Descriptions and values are read one by one; each is requested again after a second without an answer. Returns the seconds for
// `parameters` parameters, extrapolated from the first ones.
double one_by_one(support::LineFaults faults, std::size_t parameters) {
    constexpr std::uint16_t asked = 15;
    DeviceLine line{DeviceLine::Wire::udp, faults, parameters};
    Socket host;
    host.connect(line.port());
    const auto begin = std::chrono::steady_clock::now();
    for (std::uint16_t id = 0; id < asked; ++id)
        for (const std::uint8_t what : {std::uint8_t{2}, std::uint8_t{3}}) {    // value, description
            const auto question = support::frame(
                ano::address::host, ano::address::flight_controller, 0xE0,
                {what, static_cast<std::uint8_t>(id & 0xFF), static_cast<std::uint8_t>(id >> 8)});
            bool is_answered = false;
            for (int tries = 0; tries < 50 && !is_answered; ++tries) {
                host.send(question);
                pollfd answer{host.fd(), POLLIN, 0};
                if (::poll(&answer, 1, 1000) <= 0) continue;
                std::uint8_t bytes[256];
                is_answered = ::recv(host.fd(), bytes, sizeof bytes, 0) > 0;
            }
            must(is_answered, "an answer");
        }
    return Seconds(std::chrono::steady_clock::now() - begin).count() * static_cast<double>(parameters) / asked;
}

}    // namespace

void measure_devices(Run& run) {
    const std::string read = "GET /devices/0xDC/parameters";
    using Wire = DeviceLine::Wire;
    const double clean = took(run, Wire::udp, {.delay = 100ms}, 300, read).seconds;
    const double lossy = took(run, Wire::udp, {.delay = 100ms, .loss = 0.1}, 300, read).seconds;
    run.table.compare("300 parameters, 200 ms there and back, 10 % lost each way, s, beside the same without loss", {lossy},
                      {clean}, at_most(2.5));
    run.table.compare("the same one by one, each waited for a second, s, beside it",
                      {one_by_one({.delay = 100ms, .loss = 0.1}, 300)}, {lossy}, at_least(10));
    const Took serial = took(run, Wire::pty, {.baud = 115200}, 300, read);
    const double wire = static_cast<double>(std::max(serial.bytes_there, serial.bytes_back)) * 10 / 115200;
    run.table.compare("300 parameters at 115200 baud, s, beside the time of their bytes", {serial.seconds}, {wire}, at_most(1.3));
    const Took flash = took(run, Wire::pty, {.baud = 500000}, 10, "POST /devices/0xDC/firmware",
                            std::string(std::size_t{256} << 10, '\x01'));
    // The request for an upgrade returns its job at once; the job listens for 2 s and then writes.
    const double bytes = static_cast<double>(flash.bytes_there + flash.bytes_back) * 10 / 500000 + 2;
    run.table.compare("256 KiB of firmware at 500000 baud, s, beside the time of bytes and answers and 2 s of listening",
                      {flash.seconds}, {bytes}, at_most(1.15));
}

}    // namespace bench
