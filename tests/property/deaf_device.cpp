// Devices with the vendor's parser, which stops finding frames after one flipped bit of LEN: any operation takes at most a second
// longer.
#include <host/commands.hpp>
#include <host/firmware.hpp>
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>
#include <host/waypoints.hpp>
#include <world/vendor_parser.hpp>

#include <support/fake_loader.hpp>

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <string>
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
    ano::Duration time_of_zeros() const { return time_of_bytes(210); }
    ano::Duration time_of_bytes(int bytes) const { return ano::Duration{10s} * bytes / static_cast<int>(line.baud); }

    LineFaults line;
    FakeDevice fake;
    support::FakeLoader loader;
    ano::world::VendorParser parser{};
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

// How much longer the operation may take behind a damaged header, `after` a flush. A list repeats questions whose answers wait on a
// slow line, and may flush once more for them.
ano::Duration longer(const Deaf& deaf, const NamedOperation& operation, ano::Duration after) {
    const bool is_list = operation.name == "list";
    // Immediately after the operation that flushed, the next flush is a second away, and the question for the device info follows.
    const ano::Duration identification = after == 0ms ? deaf.time_of_bytes(32) + 2 * deaf.line.delay : 0ms;
    return 1s + (is_list ? deaf.time_of_zeros() + 100ms : identification);
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
                    EXPECT_LE(with.value_or(1h) - *without, longer(clean, second, after));
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
                EXPECT_LE(with.value_or(1h) - *without, longer(clean, operation, after));
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
