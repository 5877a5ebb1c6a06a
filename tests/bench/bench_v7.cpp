// The cost of a V7 frame: the parser alone, and the translation, which should cost at most 150 ns a frame. The frames are those
// that an LX IMU sends, in its proportions (protocol-v7.md, section 3).
#include <gateway/v7_host_translation.hpp>

#include <support/bytes.hpp>
#include <support/random.hpp>
#include <support/v7_vectors.hpp>

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>

using namespace anogate;
using support::Bytes;

namespace {

struct V7Sink final : V7Output {
    void to_device(ano::v7::FrameView frame) override { benchmark::DoNotOptimize(frame); }
    void from_device(ano::FrameView frame) override { benchmark::DoNotOptimize(frame); }
};

/// `make`: a frame with this id and DATA.
template <class Make>
std::vector<Bytes> telemetry_of(Make make) {
    struct Rate {
        std::uint8_t id;
        std::size_t size;
        unsigned per_second;
    };
    constexpr Rate rates[]{{0x01, 13, 50}, {0x02, 14, 20}, {0x03, 7, 40},  {0x04, 9, 40}, {0x05, 9, 20}, {0x06, 5, 3},
                           {0x07, 6, 20},  {0x08, 8, 10},  {0x09, 4, 10},  {0x0D, 4, 3},  {0x0E, 4, 3},  {0x20, 8, 50},
                           {0x30, 23, 5},  {0x40, 20, 5},  {0x41, 14, 10}, {0xFA, 2, 383}};
    support::Random random{1};
    std::vector<Bytes> frames;
    for (const Rate& rate : rates)
        for (unsigned i = 0; i < rate.per_second; ++i) {
            Bytes data(rate.size);
            for (auto& byte : data) byte = random.byte();
            frames.push_back(make(rate.id, data));
        }
    for (std::size_t i = frames.size(); i > 1; --i) std::swap(frames[i - 1], frames[random.below(i)]);
    return frames;
}

std::vector<Bytes> telemetry() {
    return telemetry_of([](std::uint8_t id, const Bytes& data) { return support::v7_frame(0xAF, id, data); });
}

void translate_up(benchmark::State& state, const std::vector<Bytes>& frames) {
    V7Translation translation{V7Settings{.address = 0xDD}};
    V7Sink sink;
    const ano::TimePoint now{};
    for (auto _ : state)
        for (const Bytes& frame : frames) translation.up(ano::v7::FrameView{frame}, now, sink);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames.size()));
}

void v7_up(benchmark::State& state) { translate_up(state, telemetry()); }
void v7_up_inertial(benchmark::State& state) { translate_up(state, {support::v7_frame(0xAF, 0x01, Bytes(13, 7))}); }

void v7_down(benchmark::State& state) {
    V7Translation translation{V7Settings{.address = 0xDD}};
    V7Sink sink;
    const std::vector<Bytes> frames{support::frame(0xFE, 0xDD, 0x40, Bytes(20, 5)),
                                    support::frame(0xFE, 0xDD, 0x41, Bytes(14, 5)),
                                    support::frame(0xDE, 0xFF, 0x51, {1, 1, 5, 0, 6, 0, 200}),
                                    support::frame(0xDE, 0xFF, 0x34, {0, 1, 2, 0, 0}),
                                    support::frame(0xFE, 0xDD, 0xC0, {0x10, 0, 4}),
                                    support::frame(0xD2, 0xDD, 0x32, Bytes(12, 5))};
    const ano::TimePoint now{};
    for (auto _ : state)
        for (const Bytes& frame : frames) translation.down(ano::FrameView{frame}, now, sink);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames.size()));
}

// The telemetry of a V8 device to a V7 host program.
void v7_host_down(benchmark::State& state) {
    V7HostTranslation translation{V7Settings{.address = 0xDD}};
    V7Sink sink;
    const auto frames = telemetry_of([](std::uint8_t id, const Bytes& data) { return support::frame(0xDD, 0xFE, id, data); });
    const ano::TimePoint now{};
    for (auto _ : state)
        for (const Bytes& frame : frames) translation.down(ano::FrameView{frame}, now, sink);
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames.size()));
}

// A request in full: question, repetition by its host, answer.
void v7_request(benchmark::State& state) {
    V7Translation translation{V7Settings{.address = 0xDC}};
    V7Sink sink;
    const Bytes question = support::frame(0xFE, 0xDC, 0xE0, {2, 11, 0});
    const Bytes answer = support::v7_frame(0xAF, 0xE2, {11, 0, 1, 2, 3, 4});
    const ano::TimePoint now{};
    for (auto _ : state) {
        translation.down(ano::FrameView{question}, now, sink);
        translation.down(ano::FrameView{question}, now, sink);
        translation.up(ano::v7::FrameView{answer}, now, sink);
    }
    state.SetItemsProcessed(state.iterations() * 3);
}

void v7_parse(benchmark::State& state) {
    Bytes input;
    const auto frames = telemetry();
    for (const Bytes& frame : frames) input.insert(input.end(), frame.begin(), frame.end());
    ano::v7::FrameParser parser{{}};
    for (auto _ : state)
        for (std::size_t at = 0; at < input.size();) {
            const auto room = parser.prepare();
            const std::size_t n = std::min({room.size(), input.size() - at, std::size_t{4096}});
            std::memcpy(room.data(), input.data() + at, n);
            parser.commit(n, {});
            while (const auto frame = parser.next()) benchmark::DoNotOptimize(frame);
            at += n;
        }
    state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(frames.size()));
}

BENCHMARK(v7_parse);
BENCHMARK(v7_up);
BENCHMARK(v7_up_inertial);
BENCHMARK(v7_down);
BENCHMARK(v7_host_down);
BENCHMARK(v7_request);

}    // namespace
