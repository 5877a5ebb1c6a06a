// Random frames of random senders, cut, mixed, and reassembled: all arrive, complete, in each sender's order.
#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <deque>
#include <map>

namespace can_stream_tests {

using namespace anogate;
using support::Bytes;

namespace {

// A bus that accepts a few CAN frames now and then; each sender is one gateway.
class Bus {
public:
    Bus(const CanSettings& can, support::Random& random) : random_{random}, cutter_{can}, streams_{can, 4096} {}

    void send(Bytes frame) {
        const auto key = std::pair{frame[1], std::pair{frame[2], frame[3]}};
        expected_[key].push_back(frame);
        waiting_.push_back(std::move(frame));
    }
    void take() {
        std::vector<std::span<const std::uint8_t>> frames(waiting_.begin(), waiting_.end());
        if (frames.empty()) return;
        frames[0] = frames[0].subspan(sent_);
        const auto pieces = cutter_.cut(frames);
        const std::size_t n = random_.below(pieces.size() + 1);
        for (std::size_t i = 0; i < n; ++i) deliver(pieces[i]);
        sent_ += cutter_.taken(n);
        while (!waiting_.empty() && sent_ >= waiting_.front().size()) {
            sent_ -= waiting_.front().size();
            waiting_.pop_front();
        }
    }
    bool empty() const { return waiting_.empty(); }
    std::size_t missing() const {
        std::size_t n = 0;
        for (const auto& [key, frames] : expected_) n += frames.size();
        return n;
    }
    ReceiveCounters received() const { return streams_.received(); }

private:
    void deliver(const CanCutter::Piece& piece) {
        ASSERT_LE(piece.bytes.size(), piece.size);
        Bytes data(piece.bytes.begin(), piece.bytes.end());
        data.resize(piece.size);
        streams_.receive(piece.id, data, {}, [this](ano::FrameView frame) {
            auto& queue = expected_[{frame.source(), {frame.destination(), frame.id()}}];
            ASSERT_FALSE(queue.empty());
            EXPECT_EQ(queue.front(), Bytes(frame.bytes().begin(), frame.bytes().end()));
            queue.pop_front();
        });
    }

    support::Random& random_;
    CanCutter cutter_;
    CanStreams streams_;
    std::deque<Bytes> waiting_;
    std::size_t sent_ = 0;
    std::map<std::pair<std::uint8_t, std::pair<std::uint8_t, std::uint8_t>>, std::deque<Bytes>> expected_;
};

TEST(CanStream, every_frame_arrives_whole_and_in_order) {
    for (std::uint64_t seed = 0; seed < support::trials(40); ++seed) {
        support::Random random{seed};
        CanSettings can;
        can.fd = random.one_in(2);
        can.extended = random.one_in(2);
        Bus bus{can, random};
        std::uint64_t bytes = 0;
        for (int i = 0; i < 300; ++i) {
            Bytes data(random.below(random.one_in(10) ? 4097u : 40u));
            for (auto& byte : data) byte = random.of<std::uint8_t>({0x00, 0xAB, 0xFF, random.byte()});
            const auto source = static_cast<std::uint8_t>(random.below(20));
            bus.send(
                support::frame(source, random.of<std::uint8_t>({0xFE, 0xFF}), random.of<std::uint8_t>({0x03, 0xC0, 0xB0}), data));
            bytes += ano::overhead + data.size();
            bus.take();
        }
        while (!bus.empty()) bus.take();
        EXPECT_EQ(bus.missing(), 0u) << "seed " << seed;
        EXPECT_EQ(bus.received().bytes_in, bytes) << "seed " << seed;
        EXPECT_EQ(bus.received().skipped_bytes, 0u) << "seed " << seed;
    }
}

TEST(CanStream, a_bus_that_loses_and_alters_delivers_nothing_that_was_not_sent) {
    for (std::uint64_t seed = 0; seed < support::trials(40); ++seed) {
        support::Random random{seed};
        CanSettings can;
        can.fd = random.one_in(2);
        can.extended = random.one_in(2);
        CanCutter cutter{can};
        CanStreams streams{can, 256};
        std::uint64_t put_in = 0, got_out = 0;
        for (int i = 0; i < 500; ++i) {
            const auto source = static_cast<std::uint8_t>(1 + random.below(20));
            const Bytes frame = support::frame(source, 0xFE, 0x03, Bytes(random.below(60u), source));
            const std::span<const std::uint8_t> waiting = frame;
            bool altered = false;    // one byte at most: two changes may cancel out in the checks
            for (const auto& piece : cutter.cut({&waiting, 1})) {
                if (random.one_in(20)) continue;
                Bytes data(piece.bytes.begin(), piece.bytes.end());
                data.resize(piece.size);
                if (!altered && random.one_in(20)) {
                    data[random.below(data.size())] ^= static_cast<std::uint8_t>(1 << random.below(8));
                    altered = true;
                }
                put_in += data.size();
                streams.receive(piece.id, data, {}, [&](ano::FrameView f) {
                    got_out += f.bytes().size();
                    ASSERT_EQ(Bytes(f.data().begin(), f.data().end()), Bytes(f.data().size(), f.source()));
                });
            }
            cutter.reset();
        }
        streams.finish([&](ano::FrameView f) { got_out += f.bytes().size(); });
        const ReceiveCounters counters = streams.received();
        EXPECT_GT(got_out, 0u);
        EXPECT_LE(counters.bytes_in, put_in);    // without padding
        EXPECT_EQ(counters.bytes_in, got_out + counters.skipped_bytes) << "seed " << seed;
    }
}

}    // namespace
}    // namespace can_stream_tests
