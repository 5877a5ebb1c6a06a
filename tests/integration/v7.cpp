// Links with protocol=v7: a scripted device with the previous protocol version, and a V8 host with UDP.
#include <ano/hex.hpp>
#include <gateway/frame_record.hpp>
#include <support/controlled_gateway.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/running_gateway.hpp>
#include <support/tcp_peer.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/v7_vectors.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace v7_link_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using Frames = std::vector<Bytes>;

constexpr std::uint8_t host = 0xFE, imu = 0xDD, flow = 0xDE;
const std::string v7_keys = ",name=fc,protocol=v7,v7_device=0xDD,v7_params=lx";

/// The V7 frames at the beginning of `bytes`, which are removed, without the probes of the gateway.
Frames take_v7_frames(std::span<const std::uint8_t>& bytes) {
    Frames all;
    while (const auto frame = ano::v7::frame_at(bytes)) {
        if (frame->id() != 0xFB) all.emplace_back(frame->bytes().begin(), frame->bytes().end());
        bytes = bytes.subspan(frame->bytes().size());
    }
    return all;
}
/// The V7 frames in `bytes`, which must consist of whole frames.
Frames v7_frames(std::span<const std::uint8_t> bytes) {
    Frames all = take_v7_frames(bytes);
    EXPECT_TRUE(bytes.empty()) << "outside of frames";
    return all;
}

bool is_one_frame(std::span<const std::uint8_t> bytes) {
    const auto frame = ano::v7::frame_at(bytes);
    return frame && frame->bytes().size() == bytes.size();
}

/// The device's end of one kind of link.
class Wire {
public:
    virtual ~Wire() = default;
    virtual std::string link() const = 0;
    virtual void connect(RunningGateway&) {}
    virtual void write(const Bytes& bytes) = 0;
    virtual Bytes read() = 0;
};

class SerialWire final : public Wire {
public:
    std::string link() const override { return "serial:" + device.path() + ",pace=off"; }
    void write(const Bytes& bytes) override { device.write(bytes); }
    Bytes read() override { return device.read(); }

    TempDir dir;
    PtyDevice device{dir / "fc"};
};

class PtyWire final : public Wire {
public:
    std::string link() const override { return "pty:" + (dir / "fc"); }
    void connect(RunningGateway& gateway) override {
        EXPECT_TRUE(gateway.until([&] { return std::filesystem::exists(dir / "fc"); }));
        user = std::make_unique<PortUser>(dir / "fc");
    }
    void write(const Bytes& bytes) override { user->write(bytes); }
    Bytes read() override {
        const Bytes& all = user->heard();
        return {all.begin() + static_cast<std::ptrdiff_t>(std::exchange(seen, all.size())), all.end()};
    }

    TempDir dir;
    std::unique_ptr<PortUser> user;
    std::size_t seen = 0;
};

class UdpWire final : public Wire {
public:
    std::string link() const override { return "udp:" + peer.local().text() + ",bind=127.0.0.1:0"; }
    void connect(RunningGateway& gateway) override { port = gateway.port("fc"); }
    void write(const Bytes& bytes) override { peer.send(port, bytes); }
    Bytes read() override {
        Bytes all;
        for (const Bytes& datagram : peer.datagrams()) {
            EXPECT_TRUE(is_one_frame(datagram));
            all = std::move(all) + datagram;
        }
        return all;
    }

    mutable UdpPeer peer;
    std::uint16_t port = 0;
};

class TcpWire final : public Wire {
public:
    std::string link() const override { return "tcp:" + listener.address(); }
    void connect(RunningGateway& gateway) override {
        EXPECT_TRUE(gateway.until([&] { return listener.accept(peer); }));
    }
    void write(const Bytes& bytes) override { peer.send(bytes); }
    Bytes read() override {
        const Bytes& all = peer.heard();
        return {all.begin() + static_cast<std::ptrdiff_t>(std::exchange(seen, all.size())), all.end()};
    }

    TcpListener listener;
    TcpPeer peer;
    std::size_t seen = 0;
};

/// A device whose first frame makes it a peer of a listening link: one without a counterpart in V8, so that no host gets it.
const Bytes first_of_a_peer = v7_frame(0xFF, 0xFB, {1});

class UdpListenWire final : public Wire {
public:
    std::string link() const override { return "udp-listen:127.0.0.1:0"; }
    void connect(RunningGateway& gateway) override {
        EXPECT_TRUE(gateway.until_up("fc"));
        port = gateway.port("fc");
        write(first_of_a_peer);
        EXPECT_TRUE(gateway.until([&] { return gateway.link("fc").at("v7_up_no_counterpart") == 1; }));
    }
    void write(const Bytes& bytes) override { peer.send(port, bytes); }
    Bytes read() override {
        Bytes all;
        for (const Bytes& datagram : peer.datagrams()) {
            EXPECT_TRUE(is_one_frame(datagram));
            all = std::move(all) + datagram;
        }
        return all;
    }

    UdpPeer peer;
    std::uint16_t port = 0;
};

class TcpListenWire final : public Wire {
public:
    std::string link() const override { return "tcp-listen:127.0.0.1:0"; }
    void connect(RunningGateway& gateway) override {
        EXPECT_TRUE(gateway.until_up("fc"));
        peer = TcpPeer{gateway.port("fc")};
        write(first_of_a_peer);
        EXPECT_TRUE(gateway.until([&] { return gateway.link("fc").at("v7_up_no_counterpart") == 1; }));
    }
    void write(const Bytes& bytes) override { peer.send(bytes); }
    Bytes read() override {
        const Bytes& all = peer.heard();
        return {all.begin() + static_cast<std::ptrdiff_t>(std::exchange(seen, all.size())), all.end()};
    }

    TcpPeer peer;
    std::size_t seen = 0;
};

/// A host, the gateway and a device.
class Line {
public:
    explicit Line(Wire& wire, const std::string& keys = v7_keys)
        : wire_{wire}, has_program_{keys.find("v7_role=host") != keys.npos} {
        gateway = std::make_unique<RunningGateway>(settings_of_texts({wire.link() + keys, ground.link("ground")}));
        wire.connect(*gateway);
        EXPECT_TRUE(gateway->until_up("fc") && gateway->until_up("ground"));
    }

    bool until(const std::function<bool()>& holds) { return gateway->until(holds); }
    void ask(const Bytes& frame) { EXPECT_TRUE(ground.send(gateway->port("ground"), frame)); }
    /// What the device received since the last call, at least one frame.
    Frames device_got() {
        Bytes bytes;
        Frames all;
        EXPECT_TRUE(until([&] {
            bytes = std::move(bytes) + wire_.read();
            std::span<const std::uint8_t> rest{bytes};
            all = take_v7_frames(rest);
            return !all.empty() && rest.empty();
        }));
        return all;
    }
    /// The same for the host.
    Frames host_got(std::size_t count = 1) {
        Frames all;
        EXPECT_TRUE(until([&] {
            for (Bytes& frame : ground.frames()) all.push_back(std::move(frame));
            return all.size() >= count;
        }));
        return all;
    }
    void device_acknowledges(const Bytes& v7) {
        const std::size_t end = v7.size();
        wire_.write(v7_frame(0xAF, 0x00, {v7[2], v7[end - 2], v7[end - 1]}));
    }
    std::int64_t count(const std::string& name) { return gateway->link("fc").at(name); }
    /// Nothing was sent on the wire, and nothing to `ground`: only what is sent now arrives.
    void expect_silence() {
        ask(has_program_ ? frame(imu, 0xFF, 0xF1, {7}) : frame(host, imu, 0xF1, {7}));
        EXPECT_EQ(device_got(), Frames{v7_frame(0xFF, 0xF1, {7})});
        wire_.write(v7_frame(0xFF, 0xF2, {7}));
        EXPECT_EQ(host_got(), Frames{has_program_ ? frame(host, imu, 0xF2, {7}) : frame(imu, 0xFF, 0xF2, {7})});
    }

    UdpPeer ground;
    std::unique_ptr<RunningGateway> gateway;

private:
    Wire& wire_;
    bool has_program_;    // at the other end, not a device
};

/// Other frames, such as repeated requests, may come before it.
bool comes(RunningGateway& gateway, const std::function<Frames()>& read, const Bytes& expected) {
    return gateway.until([&] {
        const Frames all = read();
        return std::find(all.begin(), all.end(), expected) != all.end();
    });
}

Bytes acknowledged(std::uint8_t source, const Bytes& request) {
    const std::size_t end = request.size();
    return frame(source, host, 0x00, {request[3], request[end - 2], request[end - 1]});
}

template <class Kind>
class V7Link : public testing::Test {
protected:
    Kind wire;
};
using Kinds = testing::Types<SerialWire, PtyWire, UdpWire, TcpWire, UdpListenWire, TcpListenWire>;
TYPED_TEST_SUITE(V7Link, Kinds);

const Bytes attitude{1, 0, 2, 0, 3, 0, 1};

TYPED_TEST(V7Link, telemetry_arrives_as_v8_also_between_garbage) {
    Line line{this->wire};
    Bytes damaged = v7_frame(0xFF, 0x03, attitude);
    damaged[5] ^= 1;
    this->wire.write(hex("00 AA 17 AA") + v7_frame(0xFF, 0x03, attitude) + damaged + hex("55 AB") +
                     v7_frame(0xAF, 0x32, {10, 0, 0, 0, 20, 0, 0, 0, 30, 0, 0, 0}) + v7_frame(0xFF, 0x7A, {1}));
    EXPECT_EQ(line.host_got(3),
              (Frames{frame(imu, 0xFF, 0x03, attitude), frame(imu, host, 0x32, {100, 0, 0, 0, 200, 0, 0, 0, 44, 1, 0, 0}),
                      frame(imu, 0xFF, 0x7A, {1})}));
    const auto first = line.count("v7_up_no_counterpart");    // of a peer, see first_of_a_peer
    EXPECT_EQ(line.gateway->count("fc", "frames_in"), 3u + static_cast<unsigned>(first)) << "frames on the wire";
    EXPECT_GE(line.gateway->count("fc", "bad_check"), 1u);
    EXPECT_GT(line.gateway->count("fc", "skipped_bytes"), 0u);
    EXPECT_EQ(line.gateway->link("fc").at("protocol"), "v7");
    EXPECT_TRUE(line.gateway->counters_add_up());
}

TYPED_TEST(V7Link, a_command_reaches_the_device_once_and_its_acknowledgement_returns) {
    Line line{this->wire};
    const Bytes command = frame(host, imu, 0xC0, {0x10, 0, 1});
    const Bytes sent = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    line.ask(command);
    EXPECT_EQ(line.device_got(), Frames{sent});
    line.device_acknowledges(sent);
    EXPECT_EQ(line.host_got(), Frames{acknowledged(imu, command)});
    line.expect_silence();
    line.device_acknowledges(sent);
    EXPECT_TRUE(line.until([&] { return line.count("v7_up_unmatched") == 1; }));
    line.ask(command);
    EXPECT_EQ(line.device_got(), Frames{sent}) << "as often as the host sends it";
}

TYPED_TEST(V7Link, parameters_are_described_read_and_written) {
    Line line{this->wire};
    line.ask(frame(host, imu, 0xE0, {1, 0, 0}));
    EXPECT_EQ(line.host_got(), Frames{frame(imu, host, 0xE0, {1, 62, 0})});
    line.ask(frame(host, imu, 0xE0, {2, 4, 0}));
    EXPECT_EQ(line.device_got(), Frames{v7_frame(0x60, 0xE1, {151, 0})});
    this->wire.write(v7_frame(0xAF, 0xE2, {151, 0, 20, 0, 0, 0}));
    EXPECT_EQ(line.host_got(), Frames{frame(imu, host, 0xE1, {4, 0, 20, 0, 0, 0})});
    const Bytes write = frame(host, imu, 0xE1, {4, 0, 30, 0, 0, 0});
    line.ask(write);
    const Bytes written = v7_frame(0x60, 0xE2, {151, 0, 30, 0, 0, 0});
    EXPECT_EQ(line.device_got(), Frames{written});
    line.device_acknowledges(written);
    EXPECT_EQ(line.host_got(), Frames{acknowledged(imu, write)});
    line.expect_silence();
}

TYPED_TEST(V7Link, an_unanswered_question_is_repeated_three_times_in_all) {
    Line line{this->wire};
    line.ask(frame(host, imu, 0xE0, {2, 4, 0}));
    Frames all;
    for (int i = 0; i < 3; ++i)
        for (Bytes& one : line.device_got()) all.push_back(std::move(one));
    EXPECT_EQ(all, Frames(3, v7_frame(0x60, 0xE1, {151, 0})));
    EXPECT_TRUE(line.until([&] { return line.count("v7_unanswered") == 1; }));
    line.expect_silence();
}

TYPED_TEST(V7Link, nothing_that_the_device_would_take_for_its_own_measurement_is_sent_nor_the_command_that_erases_it) {
    Line line{this->wire};
    std::vector<std::uint8_t> ids{0x20, 0x21};
    for (std::uint8_t id = 1; id <= 0x0F; ++id) ids.push_back(id);
    for (const std::uint8_t id : ids)
        for (const std::uint8_t to : {imu, std::uint8_t{0xFF}}) line.ask(frame(host, to, id, Bytes(13)));
    line.ask(frame(host, imu, 0xC0, {0x01, 0x20, 0xAA}));
    line.ask(frame(host, 0xFF, 0xC0, {0x01, 0x20, 0xAA, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(line.until([&] { return line.count("v7_down_own_sensor") == 34 && line.count("v7_down_erase") == 2; }));
    EXPECT_EQ(line.gateway->count("fc", "denied_out"), 36u);
    EXPECT_EQ(line.gateway->count("fc", "frames_out"), 0u);
    line.ask(frame(host, imu, 0xC0, {0x10, 0, 2}));
    EXPECT_EQ(line.device_got(), Frames{v7_frame(0xFF, 0xE0, {0x10, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0})});
    EXPECT_TRUE(line.gateway->counters_add_up());
}

TYPED_TEST(V7Link, the_gateway_acknowledges_for_a_device_that_never_does) {
    Line line{this->wire, v7_keys + ",v7_ack=sent"};
    const Bytes command = frame(host, imu, 0xC0, {0x10, 0, 1});
    line.ask(command);
    EXPECT_EQ(line.device_got().size(), 1u);
    EXPECT_EQ(line.host_got(), Frames{acknowledged(imu, command)});
}

TEST(V7Links, frames_have_their_bytes_on_the_wire_for_a_watcher_that_asks_for_them) {
    SerialWire wire;
    UdpPeer ground;
    ControlledGateway controlled{{wire.link() + v7_keys, ground.link("ground")}};
    RunningGateway& gateway = controlled.gateway;
    ASSERT_TRUE(gateway.until_up("fc") && gateway.until_up("ground"));
    MessageClient raw{controlled, "/frames?raw&link=fc"}, usual{controlled, "/frames?link=fc"};
    MessageClient binary{controlled, "/frames?raw&link=fc&format=binary"};
    const Bytes telemetry = v7_frame(0xFF, 0x03, attitude);
    const Bytes sent = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    const auto lines = [](const MessageClient& client, const std::string& word) {
        return std::count_if(client.texts().begin(), client.texts().end(),
                             [&](const std::string& text) { return text.find(word) != std::string::npos; });
    };
    EXPECT_TRUE(gateway.until([&] { return usual.is_open() && raw.is_open() && !binary.texts().empty(); }));
    wire.write(telemetry);
    ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, imu, 0xC0, {0x10, 0, 1})));
    EXPECT_TRUE(gateway.until([&] {
        return lines(raw, "\"raw\":\"" + ano::hex(telemetry) + '"') == 1 && lines(raw, "\"raw\":\"" + ano::hex(sent) + '"') == 1;
    })) << raw.texts().size();
    EXPECT_TRUE(gateway.until([&] { return lines(usual, "\"direction\":\"out\"") == 1; }));
    EXPECT_EQ(lines(usual, "\"raw\""), 0);
    EXPECT_TRUE(gateway.until([&] {
        std::string all;
        for (const std::string& message : binary.messages()) all += message;
        std::vector<Bytes> found;
        for (std::string_view rest = all; const auto record = anogate::next_record(rest);)
            found.emplace_back(record->raw.begin(), record->raw.end());
        const auto has = [&](const Bytes& v7) { return std::find(found.begin(), found.end(), v7) != found.end(); };
        return has(telemetry) && has(sent);
    }));
}

TEST(V7Links, a_device_that_uses_v8_is_named) {
    SerialWire wire;
    RunningGateway gateway{settings_of_texts({wire.link() + v7_keys})};
    ASSERT_TRUE(gateway.until_up("fc"));
    for (int n = 0; n < 20; ++n) wire.write(frame(imu, host, 0x03, Bytes(7)));
    EXPECT_TRUE(gateway.until([&] { return gateway.link("fc")["hint_id"] == "no_v7_frames"; })) << gateway.link("fc");
}

TEST(V7Links, answers_of_the_gateway_are_not_counted_as_received) {
    SerialWire wire;
    Line line{wire};
    line.ask(frame(host, imu, 0xE0, {1, 0, 0}));
    EXPECT_EQ(line.host_got().size(), 1u);
    EXPECT_EQ(line.count("v7_answered"), 1);
    EXPECT_EQ(line.gateway->count("fc", "frames_in"), 0u);
}

// A half-duplex adapter that returns what is sent, and a tapped line between an MCU and an IMU.
TEST(V7Links, a_command_that_returns_or_passes_on_the_line_reaches_no_other_device) {
    SerialWire wire;
    SerialWire other;
    UdpPeer ground;
    RunningGateway gateway{settings_of_texts(
        {wire.link() + v7_keys, other.link() + ",name=other,protocol=v7,v7_device=0xDC", ground.link("ground")})};
    ASSERT_TRUE(gateway.until_up("fc") && gateway.until_up("other") && gateway.until_up("ground"));
    const auto until = [&](const char* counter, std::int64_t count) {
        return gateway.until([&] { return gateway.link("fc").at(counter) == count; });
    };
    Bytes sent;
    ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, imu, 0xC0, {0x10, 0, 1})));
    EXPECT_TRUE(gateway.until([&] {
        sent = std::move(sent) + wire.read();
        return !sent.empty();
    }));
    wire.write(sent);
    EXPECT_TRUE(until("v7_up_echo", 1));
    EXPECT_TRUE(gateway.until([&] { return gateway.link("fc")["hint_id"] == "echo"; })) << gateway.link("fc");
    wire.write(v7_frame(0xFF, 0xE0, {0x10, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0}) + v7_frame(0x60, 0xE1, {11, 0}) +
               v7_frame(0xFF, 0x61, Bytes(22)) + v7_frame(0xFF, 0x40, Bytes(20)) + v7_frame(0xFF, 0x03, attitude));
    EXPECT_TRUE(until("v7_up_command", 3));
    EXPECT_TRUE(comes(
        gateway, [&] { return ground.frames(); }, frame(imu, 0xFF, 0x03, attitude)));
    ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, 0xDC, 0xC0, {0x10, 0, 2})));
    Bytes at_other;
    EXPECT_TRUE(gateway.until([&] { return !(at_other = std::move(at_other) + other.read()).empty(); }));
    EXPECT_EQ(at_other, v7_frame(0xFF, 0xE0, {0x10, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0})) << "nothing before it";
    EXPECT_TRUE(gateway.counters_add_up());
}

TEST(V7Links, a_line_with_commands_of_others_is_named) {
    SerialWire wire;
    RunningGateway gateway{settings_of_texts({wire.link() + v7_keys})};
    ASSERT_TRUE(gateway.until_up("fc"));
    wire.write(v7_frame(0xFF, 0xE0, {0x10, 0, 5, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(gateway.until([&] { return gateway.link("fc")["hint_id"] == "v7_commands"; })) << gateway.link("fc");
}

TEST(V7Links, nothing_circulates_between_two_links_that_are_connected_with_each_other) {
    const TempDir dir;
    UdpPeer ground;
    RunningGateway gateway{
        settings_of_texts({"pty:" + (dir / "line") + ",name=a,protocol=v7,v7_device=0xDD",
                           "serial:" + (dir / "line") + ",pace=off,name=b,protocol=v7,v7_device=0xDC", ground.link("ground")})};
    ASSERT_TRUE(gateway.until_up("a") && gateway.until_up("b") && gateway.until_up("ground"));
    constexpr unsigned sent = 20;
    for (std::uint8_t n = 0; n < sent; ++n) {
        ASSERT_TRUE(ground.send(gateway.port("ground"), frame(flow, n % 2 == 0 ? 0xFF : imu, 0xF1, {n, 1, 2})));
        ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, imu, 0xC0, {0x10, 0, n})));
        gateway.run_for(10ms);
    }
    const auto out = [&] { return gateway.count("a", "frames_out") + gateway.count("b", "frames_out"); };
    const auto commands = [&](const char* link) { return gateway.link(link).at("v7_up_command").get<unsigned>(); };
    EXPECT_TRUE(gateway.until([&] { return commands("b") == sent; }));
    // A command through the wire in each direction: all that was sent before has arrived.
    const auto pass = [&] {
        const unsigned at_a = commands("a"), at_b = commands("b");
        for (const std::uint8_t to : {std::uint8_t{0xDC}, imu})    // different ones, which are no echoes
            EXPECT_TRUE(ground.send(gateway.port("ground"), frame(host, to, 0xC0, {0x10, 1, to})));
        EXPECT_TRUE(gateway.until([&] { return commands("a") > at_a && commands("b") > at_b; }));
    };
    for (int n = 0; n < 3; ++n) pass();
    const auto before = out();
    EXPECT_LE(before, 5u * sent + 6) << "of each frame one on each link, and one more round";
    for (unsigned n = 1; n <= 5; ++n) {
        pass();
        EXPECT_EQ(out(), before + 2 * n) << "what circulates would pass again";
    }
    EXPECT_EQ(gateway.link("b")["hint_id"], "v7_loop") << gateway.link("b");
}

/// The wires of a link with a device and of one with a host program are connected with each other.
struct ConnectedWires {
    ConnectedWires() { EXPECT_TRUE(gateway.until_up("device") && gateway.until_up("program") && gateway.until_up("ground")); }
    void send(const Bytes& frame) { EXPECT_TRUE(ground.send(gateway.port("ground"), frame)); }
    bool until_dropped(unsigned frames) {
        return gateway.until([&] { return gateway.link("program").at("v7_up_loop") == frames; });
    }

    TempDir dir;
    UdpPeer ground;
    RunningGateway gateway{settings_of_texts(
        {"pty:" + (dir / "line") + ",name=device,protocol=v7,v7_device=0xDD",
         "serial:" + (dir / "line") + ",pace=off,name=program,protocol=v7,v7_role=host,v7_device=0xDD", ground.link("ground")})};
};

TEST(V7Links, no_command_circulates_through_a_device_link_and_a_host_link) {
    ConnectedWires wires;
    constexpr unsigned sent = 4;
    for (unsigned n = 1; n <= sent; ++n) {
        wires.send(frame(host, imu, 0xC0, {0x10, 0, n <= 2 ? std::uint8_t{2} : std::uint8_t{5}}));
        EXPECT_TRUE(wires.until_dropped(2 * n)) << "the probe, and the command";
    }
    EXPECT_EQ(wires.gateway.link("program")["hint_id"], "v7_loop") << wires.gateway.link("program");
    wires.send(frame(host, imu, 0x30, Bytes(23)));
    EXPECT_TRUE(wires.until_dropped(2 * sent + 1)) << "telemetry for the device";
    EXPECT_EQ(wires.gateway.count("device", "frames_out"), sent + 1);
    EXPECT_TRUE(wires.gateway.counters_add_up());
}

TEST(V7Links, telemetry_does_not_circulate_through_a_device_link_and_a_host_link) {
    ConnectedWires wires;
    constexpr unsigned sent = 20;
    for (std::uint8_t n = 0; n < sent; ++n) {
        wires.send(frame(imu, 0xFF, 0x03, {n, 0, 2, 0, 3, 0, 1}));
        wires.gateway.run_for(20ms);
    }
    wires.gateway.run_for(2s);    // in which the loop is found by its traffic
    const auto before = wires.gateway.count("program", "frames_out");
    wires.gateway.run_for(1s);
    EXPECT_EQ(wires.gateway.count("program", "frames_out"), before);
    EXPECT_LE(before, 50 * sent);
    EXPECT_EQ(wires.gateway.link("device")["hint_id"], "ring") << wires.gateway.link("device");
}

TEST(V7Links, commands_of_a_host_program_are_all_executed_whatever_it_and_others_repeat) {
    SerialWire device, program;
    UdpPeer ground;
    RunningGateway gateway{
        settings_of_texts({device.link() + ",name=device,protocol=v7,v7_device=0xDD",
                           program.link() + ",name=program,protocol=v7,v7_role=host,v7_device=0xDD", ground.link("ground")})};
    ASSERT_TRUE(gateway.until_up("device") && gateway.until_up("program") && gateway.until_up("ground"));
    const Bytes command = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    Bytes all;
    const auto executed = [&] {
        all = std::move(all) + device.read();
        std::span<const std::uint8_t> rest{all};
        return take_v7_frames(rest).size();
    };
    constexpr std::size_t repetitions = 50;
    for (std::size_t n = 1; n <= repetitions; ++n) {
        program.write(command);
        EXPECT_TRUE(gateway.until([&] { return executed() == 2 * n - 1; })) << n;
        ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, imu, 0xC0, {0x10, 0, 1})));
        EXPECT_TRUE(gateway.until([&] { return executed() == 2 * n; })) << n;
    }
    // Now the wires are connected.
    program.write(all);
    EXPECT_TRUE(gateway.until([&] { return gateway.link("program").at("v7_up_loop").get<std::size_t>() == 4 * repetitions; }))
        << gateway.link("program");
    ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, imu, 0xC0, {0x10, 0, 2})));
    EXPECT_TRUE(gateway.until([&] { return executed() > 2 * repetitions; }));
    EXPECT_EQ(executed(), 2 * repetitions + 1) << "what a wire held is not executed";
    EXPECT_TRUE(gateway.counters_add_up());
}

// A device that two links of a group lead to, both silent.
TEST(V7Links, a_command_to_a_silent_group_is_sent_on_one_link) {
    SerialWire one, two;
    UdpPeer ground;
    const std::string keys = ",protocol=v7,v7_device=0xDD,group=imu";
    RunningGateway gateway{
        settings_of_texts({one.link() + ",name=one" + keys, two.link() + ",name=two" + keys, ground.link("ground")})};
    ASSERT_TRUE(gateway.until_up("one") && gateway.until_up("two") && gateway.until_up("ground"));
    for (const std::uint8_t to : {imu, std::uint8_t{0xFF}})
        ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, to, 0xC0, {0x10, 0, 1})));
    Bytes all;
    const auto read = [&] {
        all = std::move(all) + one.read() + two.read();
        return v7_frames(all).size();
    };
    EXPECT_TRUE(gateway.until([&] { return read() >= 2; }));
    ASSERT_TRUE(ground.send(gateway.port("ground"), frame(host, imu, 0xC0, {0x10, 0, 2})));
    EXPECT_TRUE(gateway.until([&] { return read() >= 3; }));
    EXPECT_EQ(read(), 3u) << "what a second link sent would have been sent before";
}

TEST(V7Links, a_device_plugged_in_again_has_no_requests_of_before) {
    SerialWire wire;
    Line line{wire};
    const Bytes command = frame(host, imu, 0xC0, {0x10, 0, 1});
    const Bytes sent = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    line.ask(command);
    EXPECT_EQ(line.device_got(), Frames{sent});
    for (std::uint8_t i = 4; i < 8; ++i) line.ask(frame(host, imu, 0xE0, {2, i, 0}));
    EXPECT_EQ(line.device_got(), Frames{v7_frame(0x60, 0xE1, {151, 0})}) << "the others wait";
    const Bytes telemetry = v7_frame(0xFF, 0x03, attitude);
    wire.write({telemetry.begin(), telemetry.begin() + 6});
    EXPECT_TRUE(line.until([&] { return line.gateway->count("fc", "bytes_in") == 6; }));
    wire.device.unplug();
    EXPECT_TRUE(line.gateway->until_waiting("fc"));
    wire.device.plug();
    EXPECT_TRUE(line.gateway->until_up("fc"));
    wire.write({telemetry.begin() + 6, telemetry.end()});
    line.device_acknowledges(sent);
    EXPECT_TRUE(line.until([&] { return line.count("v7_up_unmatched") == 1; }));
    line.expect_silence();
    line.ask(frame(host, imu, 0xE0, {2, 5, 0}));
    EXPECT_EQ(line.device_got(), Frames{v7_frame(0x60, 0xE1, {152, 0})});
    wire.write(telemetry);
    EXPECT_EQ(line.host_got(), Frames{frame(imu, 0xFF, 0x03, attitude)});
}

// --- v7_role=host: the wire leads to a V7 host program, and `ground` is a V8 device

const std::string host_keys = ",name=fc,protocol=v7,v7_role=host,v7_device=0xDD,v7_params=lx";

TYPED_TEST(V7Link, a_v7_host_program_sees_commands_and_sets_a_v8_device) {
    Line line{this->wire, host_keys};
    const auto device_gets = [&](const Bytes& v8) {
        return comes(
            *line.gateway, [&] { return line.ground.frames(); }, v8);
    };
    line.ask(frame(0xDC, 0xFF, 0x03, attitude));
    line.ask(frame(imu, 0xFF, 0x03, attitude));
    EXPECT_EQ(line.device_got(), Frames{v7_frame(0xFF, 0x03, attitude)});
    EXPECT_EQ(line.count("v7_down_other_device"), 1);

    const Bytes command = v7_frame(0xFF, 0xE0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    const Bytes command_in_v8 = frame(host, imu, 0xC0, {0x10, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0});
    const Bytes acknowledgement = v7_frame(0xAF, 0x00, {0xE0, command[command.size() - 2], command.back()});
    Bytes acknowledgements;
    for (std::int64_t late = 1; late < 20 && acknowledgements.empty(); ++late) {    // more than a second after the command
        this->wire.write(command);
        EXPECT_EQ(line.host_got(), Frames{command_in_v8});
        line.ask(acknowledged(imu, command_in_v8));
        EXPECT_TRUE(line.until([&] {
            acknowledgements = std::move(acknowledgements) + this->wire.read();
            return acknowledgements.size() >= acknowledgement.size() || line.count("v7_down_unmatched") == late;
        }));
    }
    EXPECT_EQ(acknowledgements, acknowledgement);
    line.expect_silence();

    const Bytes read = v7_frame(0x60, 0xE1, {151, 0});
    Bytes description(23);
    description[0] = 4;
    description[2] = 2;    // u16
    const Bytes answer = v7_frame(0xAF, 0xE2, {151, 0, 20, 1, 0, 0});
    std::int64_t unanswered = 0;
    Bytes answers;
    this->wire.write(read);
    EXPECT_TRUE(line.until([&] {
        for (const Bytes& question : line.ground.frames()) {
            if (question == frame(host, imu, 0xE0, {3, 4, 0})) line.ask(frame(imu, host, 0xE2, description));
            if (question == frame(host, imu, 0xE0, {2, 4, 0})) line.ask(frame(imu, host, 0xE1, {4, 0, 20, 1}));
        }
        const std::int64_t given_up = line.count("v7_unanswered");
        if (given_up > std::exchange(unanswered, given_up)) this->wire.write(read);
        answers = std::move(answers) + this->wire.read();
        return answers.size() >= answer.size();
    }));
    EXPECT_EQ(v7_frames(answers).front(), answer);
    this->wire.write(v7_frame(0x60, 0xE2, {151, 0, 30, 1, 0, 0}));
    EXPECT_TRUE(device_gets(frame(host, imu, 0xE1, {4, 0, 30, 1})));
    EXPECT_TRUE(line.gateway->counters_add_up());
}

TEST(V7Links, a_v7_host_program_uses_a_v7_device_through_v8) {
    TcpListener listener;
    RunningGateway gateway{settings_of_texts({"sim:lx,name=lx", "tcp:" + listener.address() + host_keys})};
    TcpPeer peer;
    ASSERT_TRUE(gateway.until([&] { return listener.accept(peer); }));
    const auto gets = [&](const std::function<bool(const ano::v7::FrameView&)>& is_it) {
        return gateway.until([&] {
            std::span<const std::uint8_t> rest{peer.heard()};
            while (const auto frame = ano::v7::frame_at(rest)) {
                if (is_it(*frame)) return true;
                rest = rest.subspan(frame->bytes().size());
            }
            return false;
        });
    };
    EXPECT_TRUE(gets([](const auto& f) { return f.id() == 0x04 && f.data().size() == 9; }));
    EXPECT_TRUE(gets([](const auto& f) { return f.id() == 0x02 && f.data().size() == 14; }));
    const Bytes command = v7_frame(0xFF, 0xE0, {0x01, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0});
    peer.send(command);
    EXPECT_TRUE(gets([&](const auto& f) {
        return f.id() == 0x00 && f.data()[0] == 0xE0 && f.data()[1] == command[command.size() - 2] &&
               f.data()[2] == command.back();
    }));
    const Bytes write = v7_frame(0x60, 0xE2, {151, 0, 77, 0, 0, 0});
    peer.send(write);
    EXPECT_TRUE(gets([&](const auto& f) {
        return f.id() == 0x00 && f.data()[0] == 0xE2 && f.data()[1] == write[write.size() - 2] && f.data()[2] == write.back();
    }));
    peer.send(v7_frame(0x60, 0xE1, {151, 0}));
    EXPECT_TRUE(gets([](const auto& f) { return f.id() == 0xE2 && f.data()[0] == 151 && f.data()[2] == 77; }));
}

// One gateway is the V7 device of another, which has no table of its parameters.
TEST(V7Links, anoctl_reads_and_writes_parameters_by_number) {
    const TempDir dir;
    const std::string unit_socket = dir / "unit.sock", socket = dir / "control.sock";
    Daemon unit{ANOGATED, unit_socket, {"sim:lx,name=lx", "tcp-listen:127.0.0.1:0" + host_keys}};
    ASSERT_TRUE(unit.until_up("fc"));
    Daemon daemon{
        ANOGATED, socket, {"tcp:127.0.0.1:" + std::to_string(unit.port("fc")) + ",name=imu,protocol=v7,v7_device=0xDD"}};
    ASSERT_TRUE(daemon.until([&](const nlohmann::json&) { return daemon.count("imu", "frames_in") > 0; }));
    const auto ran = [&](const std::string& words) {
        Shell shell{ANOCTL " param " + words + " --device 0xDD --yes --control " + socket + " 2>&1"};
        const int exit = shell.wait();
        return std::pair{exit, shell.output()};
    };
    EXPECT_EQ(ran("set 151 77"), (std::pair{0, std::string{"151=77\n"}}));
    EXPECT_EQ(ran("get 151"), (std::pair{0, std::string{"151=77\n"}}));
    EXPECT_EQ(ran("set 151=78 152=5"), (std::pair{0, std::string{"151=78\n152=5\n"}}));
    EXPECT_EQ(ran("get 152 151"), (std::pair{0, std::string{"152=5\n151=78\n"}}));
    const auto [exit, words] = ran("get 9999");
    EXPECT_EQ(exit, 1);
    EXPECT_NE(words.find("'9999'"), std::string::npos) << words;
    EXPECT_NE(ran("set 9999 1").first, 0);
    EXPECT_EQ(ran("list").first, 0);
}

TEST(V7Links, anoctl_reports_at_once_what_the_rules_of_v7_refuse) {
    const TempDir dir;
    const std::string socket = dir / "control.sock", table = dir.write("table.csv", "152, ACC, 1000, f32\n");
    PtyDevice device{dir / "fc"};
    Daemon daemon{ANOGATED, socket, {"serial:" + device.path() + ",name=fc,protocol=v7,v7_device=0xDD,v7_params=" + table}};
    ASSERT_TRUE(daemon.until([&](const nlohmann::json&) {
        device.write(v7_frame(0xAF, 0x06, {0, 0, 0, 0, 0}));
        return daemon.count("fc", "frames_in") > 0;
    }));
    const auto refused = [&](const std::string& words) {
        Shell shell{ANOCTL " " + words + " --device 0xDD --yes --control " + socket + " 2>&1"};
        EXPECT_EQ(shell.wait(), 1) << words;
        return shell.output();
    };
    const std::string rules = "anoctl: not sent: refused by the rules of V7 of the link 'fc': ";
    EXPECT_EQ(refused("command call --cid 1,32,170"), rules + "the command that erases its firmware\n");
    EXPECT_EQ(refused("command call --cid 16,0,5 u64:1 u8:1"),
              rules + "more DATA than v7_max, or in a command more than 11 bytes\n");
    const Bytes command{ano::v7::head, 0xFF, 0xE0}, &heard = device.heard();
    EXPECT_EQ(std::search(heard.begin(), heard.end(), command.begin(), command.end()), heard.end());
    Shell send{ANOCTL " send command cid0=1 cid1=32 cid2=170 --to 0xDD --control " + socket + " 2>&1"};
    EXPECT_EQ(send.wait(), 1);
    EXPECT_EQ(send.output(), "anoctl: not sent: fc: refused by the rules of V7: the command that erases its firmware\n");
}

/// Peers of a listening link, and a host.
struct Peers {
    explicit Peers(const std::string& keys)
        : gateway{settings_of_texts({"udp-listen:127.0.0.1:0" + v7_keys + keys, ground.link("ground")})} {
        EXPECT_TRUE(gateway.until_up("fc") && gateway.until_up("ground"));
    }
    std::size_t channels() { return gateway.link("fc").at("channels").size(); }
    bool until_heard(std::int64_t frames) {
        return gateway.until([&] { return gateway.link("fc").at("v7_up") >= frames; });
    }

    UdpPeer ground;
    RunningGateway gateway;
};

TEST(V7Listener, has_one_state_for_each_peer) {
    Peers all{""};
    UdpPeer a, b;
    const std::uint16_t port = all.gateway.port("fc");
    a.send(port, v7_frame(0xAF, 0x02, Bytes{0, 0, 0, 0, 0, 0, 100, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_TRUE(all.until_heard(1));
    const Bytes altitude{1, 0, 0, 0, 2, 0, 0, 0, 1};
    b.send(port, v7_frame(0xAF, 0x05, altitude));
    EXPECT_TRUE(all.until_heard(2));
    a.send(port, v7_frame(0xAF, 0x05, altitude));
    EXPECT_TRUE(all.until_heard(3));
    Frames got;
    EXPECT_TRUE(all.gateway.until([&] {
        for (Bytes& frame : all.ground.frames())
            if (frame[3] == 0x05) got.push_back(std::move(frame));
        return got.size() == 2;
    }));
    EXPECT_EQ(got, (Frames{frame(imu, host, 0x05, altitude), frame(imu, host, 0x05, {100, 0, 0, 0, 2, 0, 0, 0, 1, 0, 0, 0, 1})}))
        << "the barometer of one peer does not complete the altitude of the other";
}

TEST(V7Listener, forgets_the_state_of_a_peer_that_left_and_keeps_its_counts) {
    Peers all{",peer_timeout=1s,max_peers=2"};
    const std::uint16_t port = all.gateway.port("fc");
    {
        UdpPeer gone;
        gone.send(port, v7_frame(0xAF, 0x03, attitude));
        EXPECT_TRUE(all.until_heard(1));
        EXPECT_EQ(all.channels(), 1u);
    }
    EXPECT_TRUE(all.gateway.until([&] { return all.channels() == 0; }));
    EXPECT_EQ(all.gateway.link("fc").at("v7_up"), 1);
    UdpPeer a, b, c;
    for (UdpPeer* peer : {&a, &b, &c}) peer->send(port, v7_frame(0xAF, 0x03, attitude));
    EXPECT_TRUE(all.until_heard(3));
    EXPECT_LE(all.channels(), 2u) << "max_peers";
    EXPECT_TRUE(all.gateway.counters_add_up());
}

TEST(V7Listener, accepts_no_sender_of_v8_frames) {
    Peers all{""};
    UdpPeer stranger;
    stranger.send(all.gateway.port("fc"), frame(0xDC, 0xFE, 0x03, attitude));
    EXPECT_TRUE(all.gateway.until([&] { return all.gateway.count("fc", "skipped_bytes") > 0; }));
    EXPECT_EQ(all.channels(), 0u);
}

}    // namespace
}    // namespace v7_link_tests
