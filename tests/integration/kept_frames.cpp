// The most recent frames, in memory.
#include <recording/kept_frames.hpp>
#include <support/running_gateway.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>

namespace kept_frames_tests {
namespace {

using namespace anogate;
using namespace std::chrono_literals;

TEST(FrameMemory, counts_the_memory_of_the_names_of_ever_new_peers) {
    const std::string long_name(60, 'x');
    std::vector<std::string> links{"udp-listen:127.0.0.1:0,name=ground"};
    for (int i = 0; i < 20; ++i) links.push_back("udp:127.0.0.1:9,bind=127.0.0.1:0,name=" + long_name + std::to_string(i));
    support::RunningGateway gateway{support::settings_of_texts(links)};
    ASSERT_TRUE(gateway.until_up("ground"));
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(gateway.until_up(long_name + std::to_string(i)));
    FrameWatch watch{gateway.gateway()};
    FrameMemory memory{gateway.gateway(), watch, {}, 60s};
    constexpr std::uint64_t strangers = 50;
    for (std::uint64_t i = 1; i <= strangers; ++i) {
        support::UdpPeer stranger;
        stranger.send(gateway.port("ground"), support::frame(0xDC, 0x01, 0x03, {1, 2, 3, 4, 5, 6, 0}));
        ASSERT_TRUE(gateway.until([&] { return gateway.count("ground", "frames_in") == i; }));
    }
    ASSERT_TRUE(gateway.until([&] { return memory.figures().frames >= strangers; }));
    EXPECT_GT(memory.figures().bytes, strangers * 20 * (3 * sizeof(std::string) + long_name.size()));
}

/// The memory of received frames; its batches end only on request.
class FrameMemoryOfOneLink : public testing::Test {
protected:
    FrameMemoryOfOneLink() {
        EXPECT_TRUE(gateway.until_up("ground"));
        filter.batch = 1h;
        filter.directions = {true, false, false};
        memory.emplace(gateway.gateway(), watch, filter, 60s);
    }
    /// The gateway receives one more frame.
    bool receives(std::uint8_t id) {
        ++heard_;
        peer_.send(gateway.port("ground"), support::frame(0xDC, 0x01, id, {1, 2, 3, 4, 5, 6, 0}));
        return gateway.until([&] { return gateway.count("ground", "frames_in") == heard_; });
    }

    support::RunningGateway gateway{support::settings_of_texts({"udp-listen:127.0.0.1:0,name=ground"})};
    FrameWatch watch{gateway.gateway()};
    FrameFilterSettings filter;
    std::optional<FrameMemory> memory;

private:
    support::UdpPeer peer_;
    std::uint64_t heard_ = 0;
};

TEST_F(FrameMemoryOfOneLink, contains_the_last_frame_at_once) {
    for (std::uint64_t n = 1; n <= 2; ++n) {
        ASSERT_TRUE(receives(0x03));
        EXPECT_EQ(memory->frames().frames(), n);
    }
}

// Thousands of frames are compressed together: to read them in one step would block the gateway.
TEST_F(FrameMemoryOfOneLink, is_written_as_a_recording_in_steps_of_a_hundred_frames) {
    for (int n = 0; n < 250; ++n) ASSERT_TRUE(receives(0x03));
    for (const RecordingFormat format : {RecordingFormat::pcapng, RecordingFormat::mcap}) {
        KeptFramesWriting writing{memory->frames(), format};
        std::string made;
        int steps = 1;
        while (writing.next(made)) ++steps;
        EXPECT_EQ(steps, 3) << text(format);
        EXPECT_FALSE(made.empty());
    }
}

TEST_F(FrameMemoryOfOneLink, keeps_stored_frames_when_the_time_span_or_the_filter_changes) {
    ASSERT_TRUE(receives(0x03));
    memory->change(filter, 120s);
    EXPECT_EQ(memory->figures().span, 120s);
    EXPECT_EQ(memory->frames().frames(), 1u);
    ASSERT_TRUE(receives(0x03));
    filter.ids.reset();
    filter.ids.set(0x04);
    memory->change(filter, 120s);
    EXPECT_EQ(memory->figures().frames, 2u);
    ASSERT_TRUE(receives(0x03));
    ASSERT_TRUE(receives(0x04));
    EXPECT_EQ(memory->frames().frames(), 3u) << "two of before, and the one of after that is to be kept";
    memory->change(filter, 0s);
    EXPECT_EQ(memory->frames().frames(), 0u) << "none is that young";
}

}    // namespace
}    // namespace kept_frames_tests
