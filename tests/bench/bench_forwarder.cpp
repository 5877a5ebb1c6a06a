// The cost of a frame from its arrival to the outboxes: to one learned address and to all, without and with an observer.
#include <gateway/forwarder.hpp>

#include <support/bytes.hpp>

#include <benchmark/benchmark.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr std::size_t in_a_batch = 32;

// Counts only.
class Counting final : public Forwarder::Observer {
public:
    void received(const Channel&, ano::FrameView, TimePoint) override { ++told; }
    void offered(const Channel&, ano::FrameView, ChannelId) override { ++told; }
    void dropped(const Channel&, ano::FrameView, ReceiveCause) override { ++told; }
    void refused(LinkId, ano::FrameView, SendCause) override { ++told; }
    std::uint64_t told = 0;
};

class Bench {
public:
    explicit Bench(unsigned links) {
        for (unsigned n = 0; n < links; ++n) {
            const LinkId link = forwarder.add_link({});
            channels.push_back(forwarder.open_channel(link, "", now));
            forwarder.link_up(link, now);
        }
    }
    void receive(std::size_t from, const support::Bytes& frame) {
        channels[from]->arrived_at = now;
        forwarder.receive(*channels[from], ano::FrameView{frame}, now);
    }
    void flush() {
        std::array<std::span<const std::uint8_t>, in_a_batch> pieces;
        while (Channel* const to = forwarder.next_to_flush())
            for (std::size_t n = to->outbox.gather(pieces, now); n > 0; --n) to->outbox.sent_frame();
    }

    Forwarder forwarder{GatewaySettings{}, 7};
    std::vector<Channel*> channels;
    TimePoint now{1h};
};

// 21 bytes each, no two equal.
std::vector<support::Bytes> frames(std::uint8_t source, std::uint8_t destination) {
    std::vector<support::Bytes> all;
    for (unsigned n = 0; n < 4096; ++n) {
        support::Bytes data(13);
        data[0] = static_cast<std::uint8_t>(n);
        data[1] = static_cast<std::uint8_t>(n >> 8);
        all.push_back(support::frame(source, destination, 0x03, data));
    }
    return all;
}

void run(benchmark::State& state, std::uint8_t destination, unsigned links, bool observed) {
    const auto bench = std::make_unique<Bench>(links);
    Counting observer;
    if (observed) bench->forwarder.add_observer(observer);
    bench->receive(0, support::frame(0xFE, 0xFF, 0xC0, {1}));
    const auto all = frames(0xDC, destination);
    std::size_t next = 0;
    for (auto _ : state) {
        bench->now += 320us;
        for (std::size_t n = 0; n < in_a_batch; ++n) bench->receive(1, all[next++ % all.size()]);
        bench->flush();
    }
    benchmark::DoNotOptimize(observer.told);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(in_a_batch));
}

void learned(benchmark::State& state) { run(state, 0xFE, 2, false); }
void learned_observed(benchmark::State& state) { run(state, 0xFE, 2, true); }
void broadcast_to_7(benchmark::State& state) { run(state, 0xFF, 8, false); }
void broadcast_to_7_observed(benchmark::State& state) { run(state, 0xFF, 8, true); }
BENCHMARK(learned);
BENCHMARK(learned_observed);
BENCHMARK(broadcast_to_7);
BENCHMARK(broadcast_to_7_observed);

}    // namespace
