// Ten million random frames through eight links that go up and down. Delivered frames equal the sent ones, in the order of their
// source, destination and class, without duplicates; and every offered frame is accounted for.
#include <link/serial/serial_settings.hpp>
#include <support/pty_device.hpp>
#include <support/random.hpp>
#include <support/running_gateway.hpp>
#include <support/sanitized.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <ano/parser.hpp>
#include <gateway/queue_policy.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

namespace eight_links_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using anogate::LinkSettings;

constexpr std::uint64_t frames_to_send = sanitized ? 300'000 : 10'000'000;
constexpr std::size_t frames_at_once = 60;
constexpr std::size_t rounds_between_pulls = frames_to_send / frames_at_once / 30;

constexpr std::uint8_t sources[] = {0x60, 0x70, 0x80, 0x90, 0xA0, 0xB0, 0xC0, 0xD0};
// Urgent frames, telemetry that newer frames replace, and bulk.
constexpr std::uint8_t ids[] = {0xC0, 0xE1, 0x41, 0x01, 0x03, 0x0D, 0xA0, 0xF1, 0xB5};

// DATA is a number and bytes computed from it, so that a reader can check that it is complete.
std::size_t fill(std::uint8_t* data, std::uint32_t number) {
    const std::size_t size = 4 + number * 2654435761u % 29;
    std::memcpy(data, &number, 4);
    for (std::size_t i = 4; i < size; ++i) data[i] = static_cast<std::uint8_t>(number * 31 + i * (number & 1 ? 0xAB : 1));
    return size;
}

// One end of a link: a device at a pty, or a peer of a UDP link.
struct End {
    std::unique_ptr<PtyDevice> device;
    std::unique_ptr<UdpPeer> peer;
    std::unique_ptr<ano::FrameParser> parser = std::make_unique<ano::FrameParser>(ano::FrameParser::Options{});
    std::uint8_t source = 0;
    std::uint16_t port = 0;    // of the gateway
    Bytes unsent{};
};

class EightLinks : public testing::Test {
protected:
    static constexpr std::size_t count = 8;
    EightLinks() {
        std::vector<LinkSettings> links;
        for (std::size_t i = 0; i < count; ++i) {
            End& end = ends[i];
            end.source = sources[i];
            const std::string name = "link" + std::to_string(i);
            if (i % 2 == 0) {
                end.device = std::make_unique<PtyDevice>(dir / name);
                links.push_back(serial(name, end.device->path()));
                links.back().as<anogate::SerialSettings>().pace = anogate::Pace::off;
            } else {
                end.peer = std::make_unique<UdpPeer>();
                links.push_back(udp(name, end.peer->local().text()));
            }
            links.back().queue = 256 * 1024;
        }
        daemon = std::make_unique<RunningGateway>(settings_of(std::move(links)));
        for (std::size_t i = 0; i < count; ++i) EXPECT_TRUE(daemon->until_up("link" + std::to_string(i)));
    }

    Bytes random_frames(End& from, std::size_t frames) {
        Bytes bytes;
        std::uint8_t data[64];
        for (std::size_t i = 0; i < frames; ++i) {
            if (random.one_in(50)) bytes.insert(bytes.end(), 1 + random.below(std::size_t{9}), 0xAB);    // noise
            const std::uint8_t destination = random.one_in(8) ? 0xFF : sources[random.below(count)];
            const std::uint8_t id = ids[random.below(std::size(ids))];
            const std::size_t size = fill(data, next_number++);
            const std::size_t at = bytes.size();
            bytes.resize(at + ano::overhead + size);
            ano::encode(std::span{bytes}.subspan(at), from.source, destination, id, std::span{data, size});
        }
        sent += frames;
        return bytes;
    }
    void send(End& from) {
        if (from.peer) {
            from.peer->send(from.port, random_frames(from, frames_at_once));
            return;
        }
        if (from.unsent.empty()) from.unsent = random_frames(from, frames_at_once);
        from.unsent.erase(from.unsent.begin(),
                          from.unsent.begin() + static_cast<std::ptrdiff_t>(from.device->write(from.unsent)));
    }
    void receive(End& at) {
        if (at.device) {
            for (Bytes some = at.device->read(); !some.empty(); some = at.device->read()) parse(at, some);
        } else {
            for (const Bytes& datagram : at.peer->datagrams()) parse(at, datagram);
        }
    }
    void parse(End& at, std::span<const std::uint8_t> bytes) {
        while (!bytes.empty()) {
            const auto room = at.parser->prepare();
            const std::size_t n = std::min(room.size(), bytes.size());
            std::memcpy(room.data(), bytes.data(), n);
            at.parser->commit(n, anogate::Clock::now());
            bytes = bytes.subspan(n);
            while (const auto frame = at.parser->next()) delivered(at, *frame);
        }
    }
    void delivered(const End& at, ano::FrameView frame) {
        ++received;
        if (std::find(std::begin(sources), std::end(sources), frame.source()) == std::end(sources)) {
            ++by_chance;
            return;
        }
        std::uint32_t number = 0;
        std::uint8_t data[64];
        if (frame.data().size() >= 4) std::memcpy(&number, frame.data().data(), 4);
        const std::size_t size = fill(data, number);
        const bool whole = frame.data().size() == size && std::memcmp(frame.data().data(), data, size) == 0;
        ASSERT_TRUE(whole) << "altered on the way";
        const bool sticks = frame.id() == 0x40 || frame.id() == 0x41;    // only these overtake other frames of the same sender
        const auto traffic = sticks ? anogate::traffic_classes : static_cast<std::size_t>(anogate::policy_of(frame.id()).traffic);
        const std::size_t receiver = static_cast<std::size_t>(&at - ends);
        std::uint32_t& last = last_number[receiver][frame.source()][frame.destination()][traffic];
        ASSERT_LT(last, number) << "twice, or behind a younger one";
        last = number;
    }
    void pull_and_plug(End& end) {
        if (!end.device) return;
        if (end.device->fd() >= 0) {
            end.device->unplug();
            end.unsent.clear();
            end.parser->finish();
            while (end.parser->next()) {}
        } else {
            end.device->plug();
        }
    }

    const TempDir dir;
    Random random{20};
    End ends[count];
    std::unique_ptr<RunningGateway> daemon;
    std::uint32_t next_number = 1;
    std::uint64_t sent = 0, received = 0;
    std::uint64_t by_chance = 0;    // frames made of noise: both checks are right by chance in one of 65,536 cases
    std::uint32_t last_number[count][256][256][anogate::traffic_classes + 1]{};
};

TEST_F(EightLinks, forward_ten_million_random_frames_while_links_go_up_and_down) {
    std::uint64_t rounds = 0;
    std::uint64_t pulled = 0;
    while (sent < frames_to_send) {
        End& talker = ends[random.below(count)];
        if (!talker.device || talker.device->fd() >= 0) send(talker);
        if (random.one_in(rounds_between_pulls)) {
            pull_and_plug(ends[random.below(count)]);
            ++pulled;
        }
        daemon->io().restart();
        daemon->io().poll();
        for (End& end : ends)
            if (!random.one_in(4)) receive(end);    // readers are sometimes late
        if (HasFatalFailure()) return;
        if (++rounds % 10'000 == 0 && !daemon->counters_add_up()) FAIL() << "after " << rounds << " rounds";
    }
    EXPECT_GT(pulled, 10u);
    for (End& end : ends)
        if (end.device && end.device->fd() < 0) end.device->plug();
    ASSERT_TRUE(daemon->until([&] {
        for (End& end : ends) receive(end);
        for (std::size_t i = 0; i < count; ++i)
            if (daemon->count("link" + std::to_string(i), "waiting") != 0) return false;
        return true;
    }));
    EXPECT_TRUE(daemon->counters_add_up());
    EXPECT_LE(by_chance, sent / 100'000);
    EXPECT_GT(received, sent / 10) << "or nothing was tested";    // ports are reopened by the clock, not by the number of frames
    RecordProperty("received", std::to_string(received));
}

}    // namespace
}    // namespace eight_links_tests
