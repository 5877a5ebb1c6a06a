// The cost of a routing decision: a frame to one learned address, to a broadcast address, and among 60 devices on 8 channels.
#include <gateway/router.hpp>

#include <benchmark/benchmark.h>

#include <memory>

using namespace anogate;
using namespace std::chrono_literals;

namespace {

constexpr unsigned channel_count = 8;

std::unique_ptr<Router> eight_links() {
    auto router = std::make_unique<Router>(GatewaySettings{});
    for (unsigned n = 0; n < channel_count; ++n) router->open(static_cast<ChannelId>(n), router->add_link({}));
    return router;
}

void learned(benchmark::State& state) {
    const auto router = eight_links();
    TimePoint now{};
    router->route(ChannelId{0}, 0xFE, 0xFF, now);
    for (auto _ : state) {
        now += 1us;
        benchmark::DoNotOptimize(router->route(ChannelId{1}, 0xDC, 0xFE, now));
    }
}
BENCHMARK(learned);

void broadcast(benchmark::State& state) {
    const auto router = eight_links();
    TimePoint now{};
    for (auto _ : state) {
        now += 1us;
        benchmark::DoNotOptimize(router->route(ChannelId{1}, 0xDC, 0xFF, now));
    }
}
BENCHMARK(broadcast);

void sixty_devices(benchmark::State& state) {
    const auto router = eight_links();
    TimePoint now{};
    unsigned n = 0;
    for (auto _ : state) {
        now += 1us;
        const unsigned to = n++ * 7 % 60;
        const unsigned from = n % 60;
        benchmark::DoNotOptimize(router->route(static_cast<ChannelId>(from % channel_count),
                                               static_cast<std::uint8_t>(100 + from), static_cast<std::uint8_t>(100 + to), now));
    }
}
BENCHMARK(sixty_devices);

}    // namespace
