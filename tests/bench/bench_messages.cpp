// Decoding by the table compared with code written by hand: a packed struct if the message is known when compiling, otherwise a
// loop over a table of offsets.
#include <benchmark/benchmark.h>
#include <ano/reading.hpp>
#include <ano/typed.hpp>

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

namespace {

using namespace ano;

struct [[gnu::packed]] Inertial {
    std::int16_t acc_x, acc_y, acc_z, gyr_x, gyr_y, gyr_z;
    std::uint8_t shock_sta;
};

// Many different frames, so that the compiler can't know their content.
std::vector<std::array<std::uint8_t, overhead + sizeof(Inertial)>> frames() {
    std::vector<std::array<std::uint8_t, overhead + sizeof(Inertial)>> all(256);
    for (std::size_t i = 0; i < all.size(); ++i) {
        std::array<std::uint8_t, sizeof(Inertial)> data{};
        for (std::size_t j = 0; j < data.size(); ++j) data[j] = static_cast<std::uint8_t>(i * 31 + j * 7);
        encode(all[i], 0xDC, 0xFE, 0x01, data);
    }
    return all;
}

void packed_struct(benchmark::State& state) {
    const auto all = frames();
    for (auto _ : state)
        for (const auto& bytes : all) {
            const FrameView frame{bytes};
            Inertial m;
            if (frame.id() != 0x01 || frame.data().size() < sizeof m) continue;
            std::memcpy(&m, frame.data().data(), sizeof m);
            const double sum = m.acc_x + m.acc_y + m.acc_z + m.gyr_x * 2000.0 / 32768 + m.gyr_y * 2000.0 / 32768 +
                               m.gyr_z * 2000.0 / 32768 + m.shock_sta;
            benchmark::DoNotOptimize(sum);
        }
    state.SetItemsProcessed(state.iterations() * 256);
}

void typed(benchmark::State& state) {
    const auto all = frames();
    for (auto _ : state)
        for (const auto& bytes : all) {
            const auto m = as<"inertial">(FrameView{bytes});
            if (!m) continue;
            const double sum = m->get<"acc_x">() + m->get<"acc_y">() + m->get<"acc_z">() + m->get<"gyr_x">() + m->get<"gyr_y">() +
                               m->get<"gyr_z">() + m->get<"shock_sta">();
            benchmark::DoNotOptimize(sum);
        }
    state.SetItemsProcessed(state.iterations() * 256);
}

// The same table as rows of offsets, as code for this purpose alone would have it.
struct Row {
    std::uint8_t offset;
    Type type;
    double wire, value;
};
struct Table {
    std::uint8_t id;
    std::uint8_t size;
    std::vector<Row> rows;
};

void walk_by_hand(benchmark::State& state) {
    const auto all = frames();
    std::vector<Table> tables(256);
    tables[1] = {1,
                 sizeof(Inertial),
                 {{0, Type::i16, 1, 1},
                  {2, Type::i16, 1, 1},
                  {4, Type::i16, 1, 1},
                  {6, Type::i16, 32768, 2000},
                  {8, Type::i16, 32768, 2000},
                  {10, Type::i16, 32768, 2000},
                  {12, Type::u8, 1, 1}}};
    benchmark::DoNotOptimize(tables.data());
    for (auto _ : state)
        for (const auto& bytes : all) {
            const FrameView frame{bytes};
            const auto data = frame.data();
            const Table& table = tables[frame.id()];
            if (data.size() < table.size) continue;
            double sum = 0;
            for (const Row& row : table.rows) {
                const std::uint8_t* at = data.data() + row.offset;
                double wire = 0;
                switch (row.type) {
                case Type::u8: wire = *at; break;
                case Type::i8: wire = static_cast<std::int8_t>(*at); break;
                case Type::u16: wire = load<std::uint16_t>(at); break;
                case Type::i16: wire = load<std::int16_t>(at); break;
                case Type::u32: wire = load<std::uint32_t>(at); break;
                case Type::i32: wire = load<std::int32_t>(at); break;
                case Type::f32: wire = static_cast<double>(load<float>(at)); break;
                default: break;
                }
                sum += wire * row.value / row.wire;
            }
            benchmark::DoNotOptimize(sum);
        }
    state.SetItemsProcessed(state.iterations() * 256);
}

void walk(benchmark::State& state) {
    const auto all = frames();
    for (auto _ : state)
        for (const auto& bytes : all) {
            const Reading reading = read(FrameView{bytes});
            double sum = 0;
            for (const Field& f : reading.fields()) sum += reading.number(f);
            benchmark::DoNotOptimize(sum);
        }
    state.SetItemsProcessed(state.iterations() * 256);
}

BENCHMARK(packed_struct);
BENCHMARK(typed);
BENCHMARK(walk_by_hand);
BENCHMARK(walk);

}    // namespace
