#include "detect_rate.hpp"
#include "port_list.hpp"

#include <ano/hex.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/frame_json.hpp>
#include <gateway/v7_guess.hpp>
#include <link/serial/termios.hpp>
#include <sys/errors.hpp>
#include <sys/unique_fd.hpp>

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/file.h>
#include <sys/signalfd.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <optional>
#include <ostream>
#include <vector>

namespace anoctl {
namespace {

using namespace anogate;

constexpr std::size_t bytes_enough = 4096;    // this many bytes must contain some frames

/// A descriptor that becomes readable on SIGINT and SIGTERM. The signals are blocked while this object exists.
class Interruption {
public:
    Interruption() {
        sigset_t signals;
        sigemptyset(&signals);
        sigaddset(&signals, SIGINT);
        sigaddset(&signals, SIGTERM);
        pthread_sigmask(SIG_BLOCK, &signals, &before_);
        fd_ = UniqueFd{::signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK)};
    }
    Interruption(const Interruption&) = delete;
    Interruption& operator=(const Interruption&) = delete;
    ~Interruption() {
        for (signalfd_siginfo taken{}; ::read(fd_.get(), &taken, sizeof taken) > 0;) {}
        pthread_sigmask(SIG_SETMASK, &before_, nullptr);
    }
    int fd() const noexcept { return fd_.get(); }

private:
    sigset_t before_{};
    UniqueFd fd_;
};

std::string named(const std::vector<Holder>& holders) {
    std::string text;
    for (const Holder& h : holders) text += (text.empty() ? "" : ", ") + h.program + " (pid " + std::to_string(h.pid) + ")";
    return text;
}

[[noreturn]] void fail_busy(const std::string& port) {
    std::error_code none;
    const std::vector<Holder> holders = holders_of("/", std::filesystem::canonical(port, none).string());
    const bool is_ours = std::any_of(holders.begin(), holders.end(), [](const Holder& h) { return h.program == "anogated"; });
    if (is_ours)
        throw Failure{port + " is in use by " + named(holders) +
                      "; its status shows whether it receives frames. To detect the rate, stop it first (sudo systemctl stop "
                      "anogated, or Ctrl-C)"};
    throw Failure{port + " is in use by " +
                  (holders.empty() ? "another program (to identify it: sudo fuser -v " + port + ")" : named(holders)) +
                  "; stop it first"};
}

[[noreturn]] void fail_to_open(const std::string& port, int error) {
    if (error == EBUSY) fail_busy(port);
    if (error == ENOENT || error == ENXIO || error == ENODEV) throw Failure{port + " not found; to list the ports: anoctl ports"};
    std::error_code none;
    const std::string real = std::filesystem::canonical(port, none).string();
    const std::string missing = error == EACCES ? anogate::missing_permission("/", real, anogate::DeviceUser::this_process())
                                                : "";
    throw Failure{port + ": " + (missing.empty() ? error_text(error) : "permission denied: " + missing)};
}

/// A serial port, opened exclusively.
class Port {
public:
    explicit Port(const std::string& path) : fd_{::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)} {
        if (!fd_) fail_to_open(path, errno);
        if (::flock(fd_.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
            fd_ = UniqueFd{};    // closed first, so that the search for the holder does not find this process
            fail_busy(path);
        }
        terminal::claim(fd_.get());
    }
    Port(const Port&) = delete;
    Port& operator=(const Port&) = delete;
    ~Port() { terminal::release_exclusive(fd_.get()); }

    int fd() const noexcept { return fd_.get(); }
    /// Returns empty, or the reason why the driver can't set this rate. Some drivers then keep the previous one, without an error.
    std::string set_rate(std::uint32_t baud) {
        SerialSettings settings;
        settings.baud = baud;
        const auto actual = terminal::configure(fd(), settings);
        if (!actual) return actual.error();
        const std::uint32_t difference = std::max(*actual, baud) - std::min(*actual, baud);
        if (*actual != 0 && difference > baud / 20)    // a UART can't receive with a larger one
            return "the driver can't set " + std::to_string(baud) + " baud: it set " + std::to_string(*actual);
        terminal::discard_input(fd());
        return {};
    }

private:
    UniqueFd fd_;
};

class Detection {
public:
    Detection(const std::string& path, Streams& streams, ListeningTime time)
        : path_{path}, streams_{streams}, time_{time}, port_{path} {}

    FoundRate run() {
        for (const std::uint32_t baud : usual_rates()) {
            if (const std::string wrong = port_.set_rate(baud); !wrong.empty()) {
                refusal_ = wrong;
                continue;
            }
            ++tried_;
            if (streams_.terminal) streams_.err << "anoctl: trying " << baud << std::endl;
            const HeardAtRate heard = listen(baud);
            if (interrupted_) throw Failure{"interrupted: no frames found up to " + std::to_string(baud) + " baud"};
            const bool any_rate = terminal::driver(port_.fd()) == "cdc_acm";
            if (heard.is_right()) return {baud, heard.from, any_rate};
            if (heard.is_right_in_v7()) return {baud, {}, any_rate, guess_v7_device(heard.v7_ids), heard.v7_ids};
            bytes_ += heard.counters.bytes_in;
        }
        throw Failure{path_ + ": " + why_not()};
    }

private:
    HeardAtRate listen(std::uint32_t baud) {
        ano::FrameParser parser{{}};
        ano::v7::FrameParser v7{{}};
        HeardAtRate heard;
        heard.baud = baud;
        auto end = ano::Clock::now() + time_.for_first_byte;
        while (!interrupted_ && parser.counters().bytes_in < bytes_enough) {
            const auto left = std::min(parser.deadline().value_or(end), end) - ano::Clock::now();
            const bool first = parser.counters().bytes_in == 0;
            if (read_some(parser, v7, left) && first && parser.counters().bytes_in > 0) end = ano::Clock::now() + time_.at(baud);
            parser.expire(ano::Clock::now());
            v7.expire(ano::Clock::now());
            read_frames(parser, v7, heard);
            if (heard.counters.frames_in >= 2 || ano::Clock::now() >= end) break;
        }
        parser.finish();
        v7.finish();
        read_frames(parser, v7, heard);
        return heard;
    }

    /// False: no data within `limit`.
    bool read_some(ano::FrameParser& parser, ano::v7::FrameParser& v7, Duration limit) {
        std::array<pollfd, 2> fds{{{port_.fd(), POLLIN, 0}, {interruption_.fd(), POLLIN, 0}}};
        const auto ms = std::chrono::ceil<std::chrono::milliseconds>(std::max(limit, Duration{})).count();
        if (::poll(fds.data(), fds.size(), static_cast<int>(ms)) <= 0) return false;
        interrupted_ = (fds[1].revents & POLLIN) != 0;
        if (fds[0].revents == 0) return false;
        const auto room = parser.prepare(), v7_room = v7.prepare();
        const ssize_t n = ::read(port_.fd(), room.data(), std::min(room.size(), v7_room.size()));
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) return false;
        if (n <= 0) throw Failure{path_ + " was unplugged"};
        std::copy_n(room.begin(), n, v7_room.begin());
        parser.commit(static_cast<std::size_t>(n), ano::Clock::now());
        v7.commit(static_cast<std::size_t>(n), ano::Clock::now());
        return true;
    }
    static void read_frames(ano::FrameParser& parser, ano::v7::FrameParser& v7, HeardAtRate& heard) {
        while (const auto frame = parser.next()) heard.from.insert(frame->source());
        while (const auto frame = v7.next()) heard.v7_ids.set(frame->id());
        heard.counters = parser.counters();
        heard.v7 = v7.counters();
    }

    std::string why_not() const {
        if (tried_ == 0) return refusal_;
        const std::string rates = " at any of " + std::to_string(tried_) + " rates";
        if (bytes_ > 0)
            return "data but no valid frames" + rates +
                   "; check the protocol, baud rate, parity and RX polarity (SBUS is inverted)";
        return "no data received" + rates +
               "; check that the device is powered, RX and TX are crossed, and the ground is connected. Some devices send only "
               "after a hello: run anogated serial:" +
               path_ + ",baud=500000,profile=vendor, then try other rates";
    }

    std::string path_;
    Streams& streams_;
    ListeningTime time_;
    Interruption interruption_;
    Port port_;
    bool interrupted_ = false;
    std::size_t tried_ = 0;
    std::string refusal_;
    std::uint64_t bytes_ = 0;
};

std::string listed(const std::bitset<256>& ids) {
    std::string text;
    for (std::size_t id = 0; id < ids.size(); ++id)
        if (ids[id]) text += (text.empty() ? "" : ", ") + ano::hex_byte(static_cast<std::uint8_t>(id));
    return text;
}

void print_v7(const std::string& path, const FoundRate& found, bool json, Streams& streams) {
    if (json) {
        ano::Json ids = ano::Json::array();
        for (unsigned id = 0; id < found.v7_ids.size(); ++id)
            if (found.v7_ids[id]) ids.push_back(id);
        const ano::Json all{
            {"device", path},   {"baud", found.baud},           {"from", found.from}, {"any_rate", found.any_rate},
            {"protocol", "v7"}, {"v7_device", found.v7_device}, {"ids", ids}};
        streams.out << ano::json_text(all) << '\n';
        return;
    }
    const std::string baud = std::to_string(found.baud);
    const std::string at = found.any_rate ? " at any rate (a USB device, cdc_acm, ignores the baud rate)" : "";
    streams.out << path << (found.any_rate ? "" : ": " + baud + " baud") << ": valid frames of the older protocol V7 (0xAA)" << at
                << ", messages " << listed(found.v7_ids) << "\n"
                << "Link: serial:" << path << (found.any_rate ? "" : ",baud=" + baud) << ',' << v7_link_keys(found.v7_device)
                << '\n'
                << "V7 frames have no source: v7_device is a guess from the messages. Set it to the id of your device\n";
}

}    // namespace

std::span<const std::uint32_t> usual_rates() noexcept {
    static constexpr std::array<std::uint32_t, 16> rates{500000, 115200, 921600,  460800,  230400, 1000000, 57600, 38400,
                                                         19200,  9600,   1500000, 2000000, 256000, 250000,  4800,  2400};
    return rates;
}

FoundRate find_rate(const std::string& port, Streams& streams, ListeningTime time) {
    return Detection{port, streams, time}.run();
}

int detect_rate(const std::string& port, bool json, Streams& streams, ListeningTime time) {
    const std::string path = port.starts_with("serial:") ? port.substr(7, port.find(',') - 7) : port;
    const FoundRate found = find_rate(path, streams, time);
    if (found.v7_device != 0) {
        print_v7(path, found, json, streams);
        return fine;
    }
    if (json) {
        streams.out << ano::json_text(
                           ano::Json{{"device", path}, {"baud", found.baud}, {"from", found.from}, {"any_rate", found.any_rate}})
                    << '\n';
        return fine;
    }
    std::string from;
    for (const std::uint8_t address : found.from) from += (from.empty() ? "" : ", ") + ano::hex_byte(address);
    const std::string link = "serial:" + path;
    if (found.any_rate)
        streams.out << path << ": valid frames from " << from << " at any rate (a USB device, cdc_acm, ignores the baud rate)\n"
                    << "Link: " << link << '\n';
    else
        streams.out << path << ": " << found.baud << " baud: valid frames from " << from << '\n'
                    << "Link: " << link << ",baud=" << found.baud << '\n';
    return fine;
}

}    // namespace anoctl
