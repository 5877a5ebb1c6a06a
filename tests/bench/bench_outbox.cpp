// The cost of a frame between the router and the wire: light traffic, a line that is always full, and state that is replaced.
#include <gateway/outbox.hpp>

#include <support/bytes.hpp>

#include <benchmark/benchmark.h>

#include <array>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr QueuePolicy state_of_device{TrafficClass::telemetry, Replaces::same_id, AgeKind::telemetry};

std::array<support::Bytes, 16> sixteen_kinds() {
    std::array<support::Bytes, 16> frames;
    for (std::size_t n = 0; n < frames.size(); ++n)
        frames[n] = support::frame(0xDC, 0xFE, static_cast<std::uint8_t>(n), support::Bytes(13));
    return frames;
}

// Frames are offered `offered` at a time, and at most `taken` of them are sent.
void through(benchmark::State& state) {
    const auto offered = static_cast<std::size_t>(state.range(0));
    const auto taken = static_cast<std::size_t>(state.range(1));
    const auto frames = sixteen_kinds();
    std::array<std::span<const std::uint8_t>, 64> pieces;
    Outbox outbox{{}};
    outbox.open();
    ano::TimePoint now{};
    std::size_t n = 0;
    for (auto _ : state) {
        now += 10us;
        for (std::size_t i = 0; i < offered; ++i) outbox.push(ano::FrameView{frames[n++ % frames.size()]}, state_of_device, now);
        std::size_t count = outbox.gather(std::span{pieces}.first(taken), now);
        benchmark::DoNotOptimize(pieces);
        for (; count > 0; --count) outbox.sent_frame();
        outbox.set_congested();
    }
    state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(through)->ArgNames({"offered", "taken"})->Args({1, 1})->Args({32, 32})->Args({8, 2});

// Without replacement: the queue is full, and each frame displaces the oldest.
void full(benchmark::State& state) {
    const auto frames = sixteen_kinds();
    Outbox outbox{{}};
    outbox.open();
    std::size_t n = 0;
    for (auto _ : state) outbox.push(ano::FrameView{frames[n++ % frames.size()]}, {}, {});
    state.SetItemsProcessed(state.iterations());
}
BENCHMARK(full);

// The same with eight senders on four channels, as on a port that sends all telemetry.
void of_many(benchmark::State& state) {
    const auto offered = static_cast<std::size_t>(state.range(0));
    const auto taken = static_cast<std::size_t>(state.range(1));
    std::array<support::Bytes, 8> frames;
    for (std::size_t n = 0; n < frames.size(); ++n)
        frames[n] = support::frame(static_cast<std::uint8_t>(n), 0xFE, 1, support::Bytes(13));
    std::array<std::span<const std::uint8_t>, 64> pieces;
    Outbox outbox{{}};
    outbox.open();
    std::size_t n = 0;
    for (auto _ : state) {
        for (std::size_t i = 0; i < offered; ++i, ++n)
            outbox.push(ano::FrameView{frames[n % 8]}, {TrafficClass::telemetry}, {},
                        ChannelId{static_cast<std::uint8_t>(n % 4)});
        std::size_t count = outbox.gather(std::span{pieces}.first(taken));
        benchmark::DoNotOptimize(pieces);
        for (; count > 0; --count) outbox.sent_frame();
    }
    state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(of_many)->ArgNames({"offered", "taken"})->Args({32, 32})->Args({8, 2});

}    // namespace
