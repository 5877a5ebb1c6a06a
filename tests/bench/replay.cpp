// How exactly a replay at rate 1 keeps the times of its recording, compared with a bare Asio timer that is set to the same times.
#include "forwarder.hpp"
#include "goals.hpp"

#include <record/recording_writer.hpp>
#include <support/temp_dir.hpp>
#include <sys/asio.hpp>

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

namespace bench {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using Times = std::vector<nanoseconds>;

constexpr std::size_t frames = 10'000, frames_a_round = 500;    // 1000 a second
constexpr std::size_t at_the_start = 1000;                      // frames before the program has started
constexpr auto patience = 5s;

// Offsets from the first frame: the distances always differ, with a mean of one millisecond.
Times recorded_times() {
    std::mt19937 random{18};
    std::uniform_int_distribution<int> distance{100'000, 1'900'000};
    Times times{0ns};
    while (times.size() < frames) times.push_back(times.back() + nanoseconds{distance(random)});
    return times;
}

std::string recording_of(const Times& times) {
    std::string bytes;
    const auto writer = anogate::make_recording_writer(anogate::RecordingFormat::pcapng, {"bench", 0, 0}, bytes);
    for (std::size_t n = 0; n < times.size(); ++n) {
        const auto said = frame(0x30, target, n);
        anogate::RecordedFrame recorded{.link = "fc", .frame = ano::FrameView{said}};
        recorded.time_ns = 1'763'898'044'000'000'000 + static_cast<std::uint64_t>(times[n].count());
        recorded.boottime_ns = 1'000'000'000 + static_cast<std::uint64_t>(times[n].count());
        writer->write(recorded, bytes);
    }
    writer->end(bytes);
    return bytes;
}

void keep_times_of_arrival(const Socket& socket) {
    const int on = 1;
    must(::setsockopt(socket.fd(), SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on) == 0, "SO_TIMESTAMPNS");
}

// The time at which the kernel received each datagram, independent of the time of the read: on loopback that is the time of
// sending.
Times times_of_arrival(const Socket& socket) {
    Times times;
    std::array<char, 2048> room;
    alignas(cmsghdr) std::array<char, 256> control;
    for (auto until = std::chrono::steady_clock::now() + patience;
         times.size() < frames && std::chrono::steady_clock::now() < until;) {
        iovec piece{room.data(), room.size()};
        msghdr message{};
        message.msg_iov = &piece;
        message.msg_iovlen = 1;
        message.msg_control = control.data();
        message.msg_controllen = control.size();
        if (::recvmsg(socket.fd(), &message, MSG_DONTWAIT) < 0) {
            std::this_thread::sleep_for(10ms);
            continue;
        }
        until = std::chrono::steady_clock::now() + patience;
        for (cmsghdr* head = CMSG_FIRSTHDR(&message); head; head = CMSG_NXTHDR(&message, head)) {
            if (head->cmsg_type != SCM_TIMESTAMPNS) continue;
            timespec time{};
            std::memcpy(&time, CMSG_DATA(head), sizeof time);
            times.push_back(std::chrono::seconds{time.tv_sec} + nanoseconds{time.tv_nsec});
        }
    }
    must(times.size() == frames, "a frame of a replay");
    return times;
}

// Returns after the last one.
void send_by_timer(const Socket& socket, const Times& times) {
    anogate::asio::io_context io;
    anogate::asio::steady_timer timer{io};
    const auto begin = std::chrono::steady_clock::now();
    std::size_t next = 0;
    const std::function<void()> wait = [&] {
        timer.expires_at(begin + times[next]);
        timer.async_wait([&](anogate::error_code) {
            socket.send(frame(0x30, target, next));
            if (++next < times.size()) wait();
        });
    };
    wait();
    io.run();
}

/// For each round, in microseconds.
struct Errors {
    std::vector<double> median, most, largest;
};

// No frame is sent before its time, so the least late one is in time.
Errors errors_of(const Times& came, const Times& times) {
    std::vector<double> late;
    for (std::size_t n = at_the_start; n < frames; ++n)
        late.push_back(std::chrono::duration<double, std::micro>(came[n] - times[n]).count());
    const double least = *std::min_element(late.begin(), late.end());
    Errors errors;
    for (auto begin = late.begin(); begin != late.end(); begin += frames_a_round) {
        std::vector<double> round{begin, begin + frames_a_round};
        for (double& error : round) error -= least;
        errors.median.push_back(quantile(round));
        errors.most.push_back(quantile(round, 0.99));
        errors.largest.push_back(quantile(round, 1));
    }
    return errors;
}

}    // namespace

void measure_replay(Run& run) {
    const Times times = recorded_times();
    const support::TempDir folder;
    const std::string file = folder.write("bench.pcapng", recording_of(times));
    const Socket by_timer;
    Socket sender;
    sender.connect(by_timer.port());
    Forwarder replay{1};
    keep_times_of_arrival(by_timer);
    keep_times_of_arrival(*replay.takers[0]);
    {
        const Undisturbed both;    // if that is permitted
        std::vector<std::string> links = replay.links_out(unpacked);
        links.push_back("replay:" + file);
        replay.gateway = std::make_unique<GatewayProcess>(run.anogated, links);
        replay.loop = std::make_unique<support::Child>([&] {
            stay_on_second_processor();
            send_by_timer(sender, times);
            return 0;
        });
    }
    Times said, sent;
    std::thread other{[&] { sent = times_of_arrival(by_timer); }};
    said = times_of_arrival(*replay.takers[0]);
    other.join();
    const Errors ours = errors_of(said, times), bare = errors_of(sent, times);
    run.table.measure("Replay at 1000 frames/s: µs behind the times of the recording, 99th percentile", ours.most, at_most(1000));
    run.table.compare("… the same, beside a timer of Asio alone", ours.most, bare.most, no_goal);
    run.table.compare("… median, beside that", ours.median, bare.median, no_goal);
    run.table.compare("… the largest of 500 frames, beside that", ours.largest, bare.largest, no_goal);
}

}    // namespace bench
