// A ground station that a test plays, and anogate-mavlink beside a gateway with a simulated flight controller.
#pragma once
#include <mavlink/packet_parser.hpp>
#include <mavlink/station_command.hpp>
#include <mavlink/typed.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace mavlink_tests {

using namespace std::chrono_literals;
using namespace anogate::mavlink;
using support::Bytes;
using Steady = std::chrono::steady_clock;

class Station {
public:
    explicit Station(std::uint8_t system = 255) : origin_{system, 190} {}

    std::uint16_t port() const { return socket_.port(); }
    std::string place() const { return socket_.local().text(); }
    void set_program(std::uint16_t port) { program_ = port; }

    template <class D>
    void send(const D& draft) {
        Bytes bytes(max_packet);
        bytes.resize(encode(bytes, Version::v2, origin_, sequence_++, draft.row, draft.payload()));
        send_bytes(bytes);
    }
    void send_bytes(const Bytes& bytes) {
        if (program_ != 0) socket_.send(program_, bytes);
    }
    void heartbeat() { send(Draft<"HEARTBEAT">{}.set<"type">(6).set<"autopilot">(8).set<"mavlink_version">(3)); }

    /// Receives what is there, and sends a HEARTBEAT once a second.
    void turn() {
        for (const Bytes& datagram : socket_.datagrams()) {
            program_ = socket_.last_sender().port;
            ++datagrams_;
            const auto room = parser_.prepare();
            std::copy(datagram.begin(), datagram.end(), room.begin());
            parser_.commit(datagram.size());
            while (const auto packet = parser_.next()) received_.emplace_back(packet->bytes().begin(), packet->bytes().end());
        }
        if (is_silent || Steady::now() - beaten_at_ < 1s) return;
        beaten_at_ = Steady::now();
        heartbeat();
    }
    /// The next message of this kind for which `holds`, among those received after the last call for this kind.
    template <ano::Name M>
    std::optional<View<M>> until(
        const std::function<bool(const View<M>&)>& holds = [](const View<M>&) { return true; },
        const std::function<void()>& repeat = [] {}) {
        std::optional<View<M>> found;
        auto repeated_at = Steady::now();
        support::wait_until([&] {
            turn();
            std::size_t& next = next_[View<M>::row.id];
            for (; next < received_.size() && !found; ++next)
                if (const auto message = as<M>(PacketView{received_[next]}); message && holds(*message)) found = message;
            if (!found && Steady::now() - repeated_at > 1s) {
                repeated_at = Steady::now();
                repeat();
            }
            return found.has_value();
        });
        return found;
    }
    /// Sends a command until it ends.
    std::optional<int> command(Command command, std::array<float, 7> p = {}) {
        const auto send_it = [&, count = 0]() mutable {
            Draft<"COMMAND_LONG"> draft;
            draft.set<"target_system">(1).set<"target_component">(1).set<"command">(static_cast<std::uint16_t>(command));
            draft.set<"param1">(p[0])
                .set<"param2">(p[1])
                .set<"param3">(p[2])
                .set<"param4">(p[3])
                .set<"param5">(p[4])
                .set<"param6">(p[5]);
            send(draft.set<"param7">(p[6]).set<"confirmation">(count++));
        };
        turn();
        next_[id_of<"COMMAND_ACK">] = received_.size();
        auto repeat = std::make_shared<std::function<void()>>(send_it);
        (*repeat)();
        const auto ack = until<"COMMAND_ACK">(
            [&](const View<"COMMAND_ACK">& one) {
                return one.get<"command">() == static_cast<std::uint16_t>(command) && one.get<"result">() != 5;
            },
            [repeat] { (*repeat)(); });
        return ack ? std::optional{int{ack->get<"result">()}} : std::nullopt;
    }
    std::size_t datagrams() const { return datagrams_; }
    const std::vector<Bytes>& received() const { return received_; }

    bool is_silent = false;

private:
    Origin origin_;
    std::uint8_t sequence_ = 0;
    std::uint16_t program_ = 0;
    support::UdpPeer socket_;
    PacketParser parser_{Transport::reliable};
    std::vector<Bytes> received_;
    std::map<std::uint32_t, std::size_t> next_;
    std::size_t datagrams_ = 0;
    Steady::time_point beaten_at_{};
};

class Stations : public testing::Test {
protected:
    void start(const std::string& config = "{}", std::vector<std::string> more = {}) {
        gateway = std::make_unique<support::Daemon>(ANOGATED, socket, std::vector<std::string>{"sim:fc", "--log-level", "warn"});
        ASSERT_TRUE(gateway->until_answers()) << gateway->output();
        start_program(config, std::move(more));
    }
    void start_program(const std::string& config = "{}", std::vector<std::string> more = {}) {
        const std::string file = dir.write("mavlink.json", config);
        std::vector<std::string> words{"--control", socket, "--config", file};
        if (more.empty()) more = {"--udp", station.place()};
        words.insert(words.end(), more.begin(), more.end());
        program = std::make_unique<support::Process>(ANOGATE_MAVLINK, words);
    }

    support::TempDir dir;
    std::string socket = dir / "control.sock";
    Station station;
    std::unique_ptr<support::Daemon> gateway;
    std::unique_ptr<support::Process> program;
};

}    // namespace mavlink_tests
