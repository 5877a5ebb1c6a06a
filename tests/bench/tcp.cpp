// TCP links: the cost of a frame, the delay of an urgent one on a slow line, and the cost of absent peers.
#include "forwarder.hpp"
#include "goals.hpp"

#include <ano/parser.hpp>
#include <daemon/command_line.hpp>
#include <log/log_line.hpp>
#include <runtime/gateway.hpp>
#include <support/namespaces.hpp>
#include <support/tcp_peer.hpp>
#include <sys/asio.hpp>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <ctime>
#include <map>
#include <utility>
#include <variant>
#include <vector>

#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

namespace bench {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

/// Offers frames to a TCP port as fast as possible, until it is destroyed.
class TcpFlood {
public:
    explicit TcpFlood(std::uint16_t port) : peer_{port} {
        thread_ = std::thread{[this] {
            std::vector<std::uint8_t> many;
            for (std::uint64_t n = 0; n < 512; ++n)
                for (const std::uint8_t byte : frame(0x30, target, n)) many.push_back(byte);
            for (std::size_t at = 0; !stop_;) {
                const ssize_t taken = ::send(peer_.fd(), many.data() + at, many.size() - at, MSG_NOSIGNAL);
                if (taken > 0) at = (at + static_cast<std::size_t>(taken)) % many.size();
                else ::usleep(200);
            }
        }};
    }
    ~TcpFlood() {
        stop_ = true;
        thread_.join();
    }

private:
    support::TcpPeer peer_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

/// The minimum of a router that sends each message of a TCP connection as a datagram, like mavlink-router: it reads, checks and
/// sends each frame. It has no routing table and no second endpoint.
Forwarder bare_router_from_tcp() {
    Forwarder forwarder{1};
    support::TcpListener in;
    Socket out;
    out.connect(forwarder.takers[0]->port());
    std::uint64_t* const frames = forwarder.loop_frames = shared_word();
    forwarder.loop = std::make_unique<support::Child>([&] {
        stay_on_second_processor();
        support::TcpPeer peer;
        ano::FrameParser parser{{}};
        for (;;) {
            if (!peer || peer.is_closed()) {
                while (!in.accept(peer)) ::usleep(200);
                parser.finish();
            }
            pollfd ready{peer.fd(), POLLIN, 0};
            ::poll(&ready, 1, 100);
            const auto room = parser.prepare();
            const ssize_t n = ::recv(peer.fd(), room.data(), room.size(), MSG_DONTWAIT);
            if (n <= 0) continue;
            parser.commit(static_cast<std::size_t>(n), {});
            while (const auto one = parser.next()) {
                if (::send(out.fd(), one->bytes().data(), one->bytes().size(), 0) > 0) ++*frames;
            }
        }
        return 0;
    });
    forwarder.port = in.port();
    return forwarder;
}

double frames_a_cpu_second(const Forwarder& forwarder) {
    std::this_thread::sleep_for(50ms);
    const std::uint64_t frames_before = forwarder.frames();
    const double cpu_before = cpu_seconds(forwarder.pid());
    std::this_thread::sleep_for(300ms);
    const double cpu = cpu_seconds(forwarder.pid()) - cpu_before;
    return static_cast<double>(forwarder.frames() - frames_before) / cpu;
}

// A line of 2 Mbit/s between two namespaces, with cubic at the sending end.
struct SlowWire {
    support::Namespace here, there;
    SlowWire() {
        here.join(there, "w0", "10.9.0.1/24", "10.9.0.2/24");
        here.ip("route change 10.9.0.0/24 dev w0 src 10.9.0.1 congctl cubic");    // a namespace may refuse it as its default
        const support::Inside inside{here};
        must(std::system("tc qdisc add dev w0 root tbf rate 2mbit burst 4kb latency 400ms") == 0, "tc");
    }
};

constexpr int rounds = 5;
constexpr int urgent_a_round = 60;

/// Milliseconds from sending an urgent frame to its arrival, one every 50 ms, behind frames of `size` bytes, with at least twice
/// the capacity of the line.
std::vector<double> ages_of_urgent(const Socket& host, support::TcpPeer& device, ano::FrameParser& parser, std::size_t size) {
    std::map<std::uint64_t, steady_clock::time_point> sent;
    std::vector<double> ages;
    const auto read = [&] {
        for (;;) {
            const auto room = parser.prepare();
            const ssize_t n = ::recv(device.fd(), room.data(), room.size(), MSG_DONTWAIT);
            if (n <= 0) return;
            parser.commit(static_cast<std::size_t>(n), {});
            while (const auto frame = parser.next()) {
                if (frame->id() != 0xC0) continue;
                std::uint64_t number = 0;
                std::memcpy(&number, frame->data().data(), sizeof number);
                if (const auto found = sent.find(number); found != sent.end())
                    ages.push_back(std::chrono::duration<double, std::milli>(steady_clock::now() - found->second).count());
            }
        }
    };
    auto next = steady_clock::now();
    constexpr std::size_t least_a_turn = 500;    // bytes per millisecond; the line has 250
    const std::vector<std::uint8_t> bulk(size);
    std::vector<std::uint8_t> flood(bulk.size() + ano::overhead);
    ano::encode(flood, 0x30, target, 0xF1, bulk);
    for (std::uint64_t turn = 0; turn < 50 * urgent_a_round; ++turn) {
        for (std::size_t bytes = 0; bytes < least_a_turn; bytes += size) host.send(flood);
        if (turn % 50 == 0) {
            sent[turn] = steady_clock::now();
            host.send(frame(0xFE, target, turn, 0xC0));
        }
        while (steady_clock::now() < next) {
            read();
            ::usleep(100);    // leaves the processor to the kernel, which delivers the packets
        }
        next += 1ms;
    }
    const auto until = steady_clock::now() + 1s;
    while (ages.size() < urgent_a_round && steady_clock::now() < until) read();
    return ages;
}

void measure_urgent_behind(Run& run, std::size_t size) {
    const std::string what = "TCP at 2 Mbit/s, cubic: age of an urgent frame behind a flood of " + std::to_string(size) +
                             " bytes each, 99th percentile, ms";
    if (const std::string why = support::no_namespaces(); !why.empty()) return run.table.skip(what, why);
    const Undisturbed undisturbed;
    std::vector<double> late, middle;
    for (int round = 0; round < rounds; ++round) {
        const SlowWire wire;    // a new connection: its first seconds count as well
        const support::Inside inside{wire.here};
        const GatewayProcess gateway{run.anogated,
                                     {"tcp-listen:10.9.0.1:9000,name=bridge,max_data=2000",
                                      "udp-listen:127.0.0.1:0,name=in,max_data=2000", "--route", "0x42=bridge"}};
        support::TcpPeer device;
        {
            const support::Inside far{wire.there};
            device = support::TcpPeer{"10.9.0.1:9000"};
        }
        must(static_cast<bool>(device), "connect");
        Socket host;
        host.connect(gateway.port("in"));
        ano::FrameParser parser{{.max_data = 2000}};
        const std::vector<double> ages = ages_of_urgent(host, device, parser, size);
        must(ages.size() + 2 >= urgent_a_round, "urgent frames were lost");
        late.push_back(quantile(ages, 0.99));
        middle.push_back(quantile(ages));
    }
    run.table.measure(what, late, at_most(60));
    run.table.measure("… median", middle, no_goal);
}

}    // namespace

void measure_tcp(Run& run) {
    Forwarder ours{1};
    std::vector<std::string> links = ours.links_out("");
    links.push_back("tcp-listen:127.0.0.1:0,name=in");
    ours.gateway = std::make_unique<GatewayProcess>(run.anogated, links);
    const Forwarder beside = bare_router_from_tcp();
    std::vector<int> taken_at = ours.taken_at();
    for (const int fd : beside.taken_at()) taken_at.push_back(fd);
    const Sink sink{taken_at};
    std::vector<double> our_rates, their_rates;
    for (int i = 0; i < 8; ++i) {
        {
            const TcpFlood flood{ours.gateway->port("in")};
            our_rates.push_back(frames_a_cpu_second(ours));
        }
        const TcpFlood flood{beside.port};
        their_rates.push_back(frames_a_cpu_second(beside));
    }
    run.table.compare("TCP to UDP, packed: frames a CPU second, beside a bare loop that sends a datagram a frame", our_rates,
                      their_rates, at_least(5));
}

void measure_tcp_urgent(Run& run) {
    constexpr std::size_t sizes[]{200, 500, 1000, 1900};
    for (const std::size_t size : sizes) measure_urgent_behind(run, size);
}

namespace {

double processor_ms_of_this_thread() {
    timespec t{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) / 1e6;
}

/// The most processor time, in ms, that a gateway in this thread spends on one event, the first connections included. Other
/// programs do not count, whatever they take.
double longest_event(std::vector<std::string> links, std::chrono::milliseconds time) {
    links.insert(links.begin(), {"anogated", "--control", "none"});
    std::vector<const char*> words;
    for (const std::string& link : links) words.push_back(link.c_str());
    auto line = anogate::parse_command_line(static_cast<int>(words.size()), words.data());
    must(std::holds_alternative<anogate::CommandLine>(line), "links");
    anogate::set_log_level("error");
    anogate::asio::io_context io{1};
    anogate::Gateway gateway{io, std::get<anogate::CommandLine>(std::move(line)).settings};
    gateway.start();
    double longest = 0;
    for (const auto end = steady_clock::now() + time; steady_clock::now() < end;) {
        const double before = processor_ms_of_this_thread();
        io.run_one_for(10ms);
        longest = std::max(longest, processor_ms_of_this_thread() - before);
    }
    bool is_stopped = false;
    gateway.stop({}, [&] { is_stopped = true; });
    while (!is_stopped) io.run_one_for(10ms);
    return longest;
}

}    // namespace

// Half of them refuse connections, and half do not answer.
void measure_dead_peers(Run& run) {
    const std::string what = "Ten TCP peers that are not there: % of a core";
    if (const std::string why = support::no_namespaces(); !why.empty()) return run.table.skip(what, why);
    const support::Namespace here, there;
    here.join(there, "w0", "10.9.0.1/24", "10.9.0.2/24");
    const support::Inside inside{here};
    std::vector<std::string> links;
    for (int i = 0; i < 5; ++i) {
        links.push_back("tcp:127.0.0.1:" + std::to_string(100 + i) + ",name=refuses-" + std::to_string(i));
        links.push_back("tcp:10.9.0.9:" + std::to_string(100 + i) + ",name=silent-" + std::to_string(i));
    }
    {
        const GatewayProcess gateway{run.anogated, links};
        std::this_thread::sleep_for(5s);
        run.table.measure(what, percent_of_a_core(gateway.pid()), at_most(0.5));
    }
    const std::vector<std::string> traffic{"sim:fc,hz=100", "udp:127.0.0.1:9,bind=127.0.0.1:0"};
    links.insert(links.end(), traffic.begin(), traffic.end());
    links.push_back("tcp:name.invalid:23");
    std::vector<double> ours, beside;
    for (int round = 0; round < rounds; ++round) {
        ours.push_back(longest_event(links, 3s));
        beside.push_back(longest_event(traffic, 3s));
    }
    run.table.measure("… longest event of a loop with them, a name that does not exist and telemetry: ms of processor time", ours,
                      at_most(5));
    run.table.measure("… of the same loop with the telemetry alone", beside, no_goal);
}

}    // namespace bench
