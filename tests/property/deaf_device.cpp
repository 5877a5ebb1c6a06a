// Devices with the vendor's parser, which stops finding frames after one flipped bit of LEN: any operation takes at most a second
// longer.
#include <host/commands.hpp>
#include <host/firmware.hpp>
#include <host/parameter_apply.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>
#include <host/waypoints.hpp>
#include <world/vendor_parser.hpp>

#include <support/fake_loader.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace deaf_device_tests {
namespace {

using namespace std::chrono_literals;
using namespace ano::host;
using support::Bytes;
using support::FakeDevice;
using support::LineFaults;
using support::Simulation;

// A question for the parameter count with a damaged LEN: the parser waits for 187 more bytes.
const Bytes bad_header{0xAB, 0xFE, 0xDC, 0xE0, 190, 0x00, 1, 0, 0, 0x6E, 0x60};

struct Deaf {
    explicit Deaf(unsigned baud) : line{.delay = 1ms, .baud = baud} {
        fake.make_parameters(20);
        fake.commands.push_back({{1, 2, 3}, {}, "go", ""});
        fake.instead = [this](ano::FrameView frame) { return loader.take(fake, frame); };
        simulation.parse = [this](const Bytes& bytes) {
            std::vector<Bytes> frames;
            parser.feed(bytes, [&](ano::Bytes frame) { frames.emplace_back(frame.begin(), frame.end()); });
            return frames;
        };
        simulation.be_uart();
    }
    // The time of the zero bytes that flush a parser.
    ano::Duration time_of_zeros() const { return ano::Duration{10s} * 210 / static_cast<int>(line.baud); }

    LineFaults line;
    FakeDevice fake;
    support::FakeLoader loader;
    ano::world::VendorParser parser{};
    DescriptionCache cache;
    Device device{0xDC};
    Simulation simulation{device, fake, line};
};

using Begin = std::function<std::unique_ptr<Task>(Deaf&)>;

struct NamedOperation {
    std::string name;
    Begin begin;
};

template <class T, class... Arguments>
Begin begin(Arguments... arguments) {
    return [=](Deaf& deaf) {
        auto task = std::make_unique<T>(deaf.device, arguments...);
        task->start(deaf.simulation.now);
        return task;
    };
}

std::vector<NamedOperation> operations() {
    FirmwareImage image;
    static const Bytes bytes(1000, 7);
    image.bytes = bytes;
    image.crc = ano::crc16_of(bytes);
    return {{"list",
             [](Deaf& deaf) {
                 auto task = std::make_unique<Parameters>(deaf.device);
                 task->read_all(deaf.simulation.now);
                 return task;
             }},
            {"call", begin<CommandCall>(CommandInfo{0, {1, 2, 3}, {}, false, "go", ""}, std::vector<AnyValue>{})},
            {"save", begin<ParameterAction>(Action::save)},
            {"set", begin<ParameterWrite>(ParameterInfo{.id = 1, .type = ano::Type::i8, .name = "PAR_1", .info = {}},
                                          AnyValue{std::int64_t{5}})},
            {"waypoint", begin<WaypointsPut>(std::vector<Waypoint>(2))},
            {"flash", begin<Firmware>(image)}};
}

struct Count final : Task {
    using Task::Task;
    void start(ano::TimePoint now) { ask(question::parameter_count(0), now); }
    void ended(const Ended& ended, ano::TimePoint now) override {
        finish({ended.outcome == Outcome::answered ? Ending::done : Ending::timeout, {}, {}}, now);
    }
};

// Asks the device several times, one question at a time, so that its parameter count is known.
void know_count(Deaf& deaf) {
    for (int i = 0; i < 5; ++i) {
        Count count{deaf.device};
        count.start(deaf.simulation.now);
        deaf.simulation.run(count);
    }
    ASSERT_TRUE(deaf.device.parameter_count());
    const auto info = deaf.fake.usual(ano::FrameView{support::frame(0xFE, 0xDC, 0xE0, {0, 0, 0})});
    deaf.device.take(ano::FrameView{info.at(0)}, deaf.simulation.now);
    ASSERT_TRUE(deaf.device.info());
}

bool is_command(const NamedOperation& operation) { return operation.name == "call"; }

// Reads the value of a parameter whose description is known, then writes another one.
struct KnownWrite final : Task {
    explicit KnownWrite(Deaf& deaf) : Task{deaf.device}, read{deaf.device, &deaf.cache} {}
    void start(ano::TimePoint now) {
        read.compare_anyway();
        read.on_end([this](ano::TimePoint then) { write_value(then); });
        read.read_named({"PAR_1"}, now);
    }
    void write_value(ano::TimePoint now) {
        if (read.end()->ending != Ending::done) return finish_as(read, now);
        write = std::make_unique<ParameterWrite>(device(), read.descriptions()[1], AnyValue{std::int64_t{5}});
        write->set_before(read.bytes(1), read.doubts());
        write->on_end([this](ano::TimePoint then) { finish_as(*write, then); });
        write->start(now);
    }
    void ended(const Ended&, ano::TimePoint) override {}

    Parameters read;
    std::unique_ptr<ParameterWrite> write;
};

Begin begin_read(std::vector<std::string> names) {
    return [=](Deaf& deaf) {
        auto task = std::make_unique<Parameters>(deaf.device, &deaf.cache);
        if (names.empty()) task->read_all(deaf.simulation.now);
        else task->read_named(names, deaf.simulation.now);
        return task;
    };
}

NamedOperation known_list() { return {"known list", begin_read({})}; }

// Those of a device whose descriptions are known.
std::vector<NamedOperation> known_operations() {
    return {known_list(),
            {"get", begin_read({"PAR_1"})},
            {"get of three", begin_read({"PAR_1", "PAR_2", "PAR_3"})},
            {"known set",
             [](Deaf& deaf) {
                 auto task = std::make_unique<KnownWrite>(deaf);
                 task->start(deaf.simulation.now);
                 return task;
             }},
            {"set of three", [](Deaf& deaf) {
                 auto task = std::make_unique<ParameterApply>(
                     deaf.device, &deaf.cache,
                     std::vector<std::pair<std::string, AnyValue>>{
                         {"PAR_0", std::int64_t{5}}, {"PAR_1", std::int64_t{5}}, {"PAR_2", std::int64_t{5}}},
                     ApplyOptions{.also_the_same = true});
                 task->start(deaf.simulation.now);
                 return task;
             }}};
}

// How long the operation takes; std::nullopt: it fails.
std::optional<ano::Duration> time_of(Deaf& deaf, const NamedOperation& operation, bool disturbed, ano::Duration after = 1500ms) {
    deaf.simulation.pass(after);
    if (disturbed) deaf.simulation.disturb(bad_header);
    const auto task = operation.begin(deaf);
    const ano::Duration took = deaf.simulation.run(*task);
    if (!task->end() || task->end()->ending != Ending::done) return std::nullopt;
    return took;
}

TEST(DeafDevice, an_operation_takes_at_most_a_second_longer_after_a_damaged_header) {
    for (const unsigned baud : {9600u, 57600u, 115200u, 500000u})
        for (const NamedOperation& operation : operations()) {
            SCOPED_TRACE(operation.name + " at " + std::to_string(baud));
            Deaf clean{baud}, disturbed{baud};
            know_count(clean);
            know_count(disturbed);
            const auto without = time_of(clean, operation, false), with = time_of(disturbed, operation, true);
            ASSERT_TRUE(without);
            ASSERT_TRUE(with);
            RecordProperty(operation.name + "_" + std::to_string(baud) + "_ms",
                           std::to_string((*with - *without) / std::chrono::milliseconds{1}));
            EXPECT_LE(*with - *without, 1s);
            EXPECT_GT(disturbed.simulation.zeros_there, 0u);
        }
}

// The answers of a list occupy the line for a long time, and the list may have used the flush of this second. A command does not
// wait for the next one.
TEST(DeafDevice, an_operation_right_after_a_list_takes_at_most_a_second_longer_too) {
    for (const unsigned baud : {9600u, 19200u, 57600u, 115200u})
        for (const NamedOperation& operation : operations()) {
            SCOPED_TRACE(operation.name + " at " + std::to_string(baud));
            Deaf clean{baud}, disturbed{baud};
            for (Deaf* const deaf : {&clean, &disturbed}) {
                know_count(*deaf);
                ASSERT_TRUE(time_of(*deaf, operations().front(), deaf == &disturbed));
            }
            const bool is_heard = !is_command(operation);
            const auto without = time_of(clean, operation, false, 0s), with = time_of(disturbed, operation, is_heard, 0s);
            ASSERT_TRUE(without);
            ASSERT_TRUE(with);
            RecordProperty(operation.name + "_" + std::to_string(baud) + "_ms",
                           std::to_string((*with - *without) / std::chrono::milliseconds{1}));
            EXPECT_LE(*with - *without, 1s);
        }
}

// The previous command may be TAKE_OFF, and this one LAND.
TEST(DeafDevice, a_call_never_waits_for_a_flush) {
    for (const unsigned baud : {9600u, 57600u, 115200u, 500000u})
        for (const NamedOperation& before : operations())
            for (ano::Duration after{}; after < 1s; after += 50ms) {
                if (before.name == "flash") continue;    // takes many seconds
                SCOPED_TRACE(std::to_string(after / 1ms) + " ms after " + before.name + " at " + std::to_string(baud));
                Deaf deaf{baud};
                know_count(deaf);
                ASSERT_TRUE(time_of(deaf, before, false));
                const auto took = time_of(deaf, operations()[1], false, after);
                ASSERT_TRUE(took);
                EXPECT_LE(*took, deaf.time_of_zeros() + 60ms);
            }
}

// The flush of the first operation delays that of the second.
TEST(DeafDevice, both_of_two_consecutive_operations_succeed_after_a_damaged_header_each) {
    std::vector<NamedOperation> all = operations();
    all.pop_back();    // an upgrade takes many seconds
    all.push_back({"count", begin<Count>()});
    all.push_back(
        {"repeated call", begin<CommandCall>(CommandInfo{0, {1, 2, 3}, {}, false, "go", ""}, std::vector<AnyValue>{}, true)});
    for (const unsigned baud : {9600u, 57600u, 115200u, 500000u})
        for (const NamedOperation& first : all)
            for (const NamedOperation& second : all)
                for (ano::Duration after{}; after <= 1100ms; after += 50ms) {
                    if (is_command(second) && after < 1s) continue;    // it does not wait for the flush, and is lost
                    SCOPED_TRACE(second.name + ' ' + std::to_string(after / 1ms) + " ms after " + first.name + " at " +
                                 std::to_string(baud));
                    Deaf clean{baud}, disturbed{baud};
                    for (Deaf* const deaf : {&clean, &disturbed}) {
                        know_count(*deaf);
                        ASSERT_TRUE(time_of(*deaf, first, deaf == &disturbed));
                    }
                    const auto without = time_of(clean, second, false, after), with = time_of(disturbed, second, true, after);
                    ASSERT_TRUE(without);
                    EXPECT_TRUE(with);
                    EXPECT_LE(with.value_or(1h) - *without, 1s);
                }
}

// How much longer `second` takes if a damaged header precedes both operations; std::nullopt: it fails.
std::optional<ano::Duration> prolonged_by(unsigned baud, ano::Duration telemetry_every, const NamedOperation& first,
                                          const NamedOperation& second, ano::Duration after) {
    std::optional<ano::Duration> took[2];
    for (const bool disturbed : {false, true}) {
        Deaf deaf{baud};
        deaf.simulation.telemetry_every = telemetry_every;
        if (!time_of(deaf, known_list(), false) || !time_of(deaf, first, disturbed)) return std::nullopt;
        took[disturbed] = time_of(deaf, second, disturbed, after);
        if (!took[disturbed]) return std::nullopt;
    }
    return *took[true] - *took[false];
}

// Several questions are lost at once; one flush serves all of them. Telemetry occupies half or 70 % of the slowest line, so
// that answers take long, and some arrive after the next equal question.
TEST(DeafDevice, every_operation_of_a_session_takes_at_most_a_second_longer_at_any_time_after_another) {
    std::vector<NamedOperation> all = operations();
    for (NamedOperation& operation : known_operations()) all.push_back(std::move(operation));
    for (const unsigned baud : {9600u, 19200u, 57600u, 115200u})
        for (const ano::Duration telemetry_every : {0ms, 70ms, 50ms})
            for (const std::size_t first : {0u, 1u, 3u})
                for (const NamedOperation& second : all) {
                    ano::Duration longest{};
                    for (ano::Duration after{}; after <= 1100ms; after += 125ms) {
                        if (is_command(second) && after < 1s) continue;    // it does not wait for the flush, and is lost
                        SCOPED_TRACE(second.name + ' ' + std::to_string(after / 1ms) + " ms after " + all[first].name + " at " +
                                     std::to_string(baud));
                        const auto prolonged = prolonged_by(baud, telemetry_every, all[first], second, after);
                        ASSERT_TRUE(prolonged);
                        EXPECT_LE(*prolonged, 1s);
                        longest = std::max(longest, *prolonged);
                    }
                    RecordProperty(second.name + " after " + all[first].name + " at " + std::to_string(baud) + ", telemetry " +
                                       std::to_string(telemetry_every / 1ms) + " ms",
                                   std::to_string(longest / 1ms));
                }
}

TEST(DeafDevice, all_operations_of_a_session_succeed_with_a_damaged_header_before_each) {
    Deaf deaf{115200};
    know_count(deaf);
    for (const NamedOperation& operation : operations()) EXPECT_TRUE(time_of(deaf, operation, true)) << operation.name;
    std::size_t calls = 0;
    for (const Bytes& frame : deaf.fake.heard) calls += frame[3] == 0xC0;
    EXPECT_EQ(calls, 1u);
}

// It is asked for its device info before the first frame that acts. The zero bytes of a flush for another device of the line have
// just left.
TEST(DeafDevice, one_that_was_never_asked_takes_at_most_a_second_longer_too) {
    for (const unsigned baud : {9600u, 19200u, 57600u, 115200u, 500000u})
        for (const NamedOperation& operation : operations())
            for (ano::Duration after{}; after <= 1100ms; after += 50ms) {
                if (is_command(operation) && after < 1s) continue;    // it does not wait for the flush, and is lost
                SCOPED_TRACE(operation.name + ' ' + std::to_string(after / 1ms) + " ms after a flush at " + std::to_string(baud));
                Deaf clean{baud}, disturbed{baud};
                disturbed.simulation.flush_for_another();
                const auto without = time_of(clean, operation, false, clean.time_of_zeros() + after),
                           with = time_of(disturbed, operation, true, clean.time_of_zeros() + after);
                ASSERT_TRUE(without);
                EXPECT_TRUE(with);
                EXPECT_LE(with.value_or(1h) - *without, 1s);
            }
}

TEST(DeafDevice, where_nothing_is_lost_no_zero_byte_is_sent) {
    Deaf deaf{0};
    know_count(deaf);
    const auto task = operations().front().begin(deaf);
    deaf.simulation.run(*task);
    EXPECT_EQ(deaf.simulation.zeros_there, 0u);
}

}    // namespace
}    // namespace deaf_device_tests
