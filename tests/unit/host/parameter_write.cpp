// Writing parameters: read back, clamped, refused, undone; and frames that are never sent.
#include <host/parameter_apply.hpp>
#include <host/parameter_write.hpp>

#include <support/fake_device.hpp>

#include <gtest/gtest.h>

namespace ano::host::parameter_write_tests {
namespace {

using support::Bytes;
using support::FakeDevice;
using support::Simulation;
using State = ParameterApply::State;

struct Writes : testing::Test {
    FakeDevice fake;
    Device device{0xDC};
    DescriptionCache cache;
    Simulation simulation{device, fake, {.delay = std::chrono::milliseconds{10}}};

    Writes() {
        fake.parameters = {{0, "U8", "", {7}},
                           {8, "F32", "", {0, 0, 0, 0x3F}},
                           {10, "TEXT", "", {'a', 'b', 'c', 'd', 0, 0}},
                           {3, "I16", "", {1, 0}}};
        const auto info = fake.usual(FrameView{support::frame(0xFE, 0xDC, 0xE0, {0, 0, 0})});
        device.take(FrameView{info.at(0)}, simulation.now);
    }
    ParameterInfo info(std::uint16_t id) const {
        return {id, parameter_type(fake.parameters[id].type), fake.parameters[id].name, "", {}};
    }
    std::unique_ptr<ParameterWrite> write(ParameterInfo of, AnyValue value, WriteLimits limits = {}) {
        auto task = std::make_unique<ParameterWrite>(device, std::move(of), std::move(value), limits);
        task->start(simulation.now);
        simulation.run(*task);
        EXPECT_TRUE(task->end());
        EXPECT_FALSE(fake.crashed);
        return task;
    }
    std::size_t writes() const {
        return static_cast<std::size_t>(
            std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[3] == 0xE1; }));
    }
    std::optional<std::vector<Bytes>> nothing() const { return std::vector<Bytes>{}; }
};

TEST_F(Writes, read_the_written_value_back) {
    const auto task = write(info(3), std::int64_t{-300});
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(task->before(), AnyValue{std::int64_t{1}});
    EXPECT_EQ(task->stored(), AnyValue{std::int64_t{-300}});
    EXPECT_FALSE(task->is_clamped());
    EXPECT_EQ(fake.parameters[3].value, (Bytes{0xD4, 0xFE}));
    EXPECT_EQ(writes(), 1u);
}

TEST_F(Writes, a_value_beyond_the_stated_range_is_refused_unless_it_is_allowed) {
    fake.old = true;
    fake.parameters = {{0, "P", "", {7, 0, 0, 0}}};
    const ParameterInfo p{0, Type::i32, "P", "", ParameterInfo::Limits{-10, 100}, ParameterLayout::ranged, 1};
    for (const std::int64_t value : {-11, 101}) {
        const auto task = write(p, value);
        EXPECT_EQ(task->end()->ending, Ending::invalid);
        EXPECT_EQ(task->end()->fault.text(),
                  "P: " + std::to_string(value) +
                      " is out of range, the device states -10 to 100: a value beyond it must be allowed (force)");
    }
    EXPECT_EQ(writes(), 0u);
    EXPECT_EQ(write(p, std::int64_t{100})->end()->ending, Ending::done);
    EXPECT_EQ(write(p, std::int64_t{101}, {.beyond_range = true})->end()->ending, Ending::done);
    EXPECT_EQ(fake.parameters[0].value, (Bytes{101, 0, 0, 0}));
    ParameterInfo stateless = p;
    stateless.limits = ParameterInfo::Limits{0, 0};
    EXPECT_EQ(write(stateless, std::int64_t{50})->end()->ending, Ending::done);
}

TEST_F(Writes, do_not_report_rounding_to_f32_as_clamping) {
    const auto task = write(info(1), 0.1);
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_FALSE(task->is_clamped());
}

TEST_F(Writes, multiply_a_scaled_value_and_reject_one_that_is_not_a_multiple) {
    fake.scaled = true;
    fake.parameters = {{0, "P", "", {0xE8, 3, 0, 0}}};
    ParameterInfo p{0, Type::i32, "P", "", ParameterInfo::Limits{-10, 100}, ParameterLayout::scaled, 1000};
    const auto task = write(p, 1.234);
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(task->before(), AnyValue{1.0});
    EXPECT_EQ(task->stored(), AnyValue{1.234});
    EXPECT_FALSE(task->is_clamped());
    EXPECT_EQ(fake.parameters[0].value, (Bytes{0xD2, 4, 0, 0}));
    EXPECT_EQ(write(p, std::int64_t{-3})->stored(), AnyValue{-3.0});
    EXPECT_EQ(write(p, 0.1 + 0.2)->stored(), AnyValue{0.3}) << "as programs compute it";
    const auto finer = write(p, 0.0005);
    EXPECT_EQ(finer->end()->ending, Ending::invalid);
    EXPECT_EQ(finer->end()->fault.text(), "P: 5e-04 is not a multiple of 0.001");
    EXPECT_EQ(write(p, 2'200'000.0)->end()->fault.text(), "P: 2200000 is out of range, -2147483.647 to 2147483.647");
    EXPECT_EQ(write(p, std::string{"1"})->end()->fault.text(), "P: \"1\" is not a number");
    EXPECT_EQ(writes(), 3u);
    EXPECT_EQ(nearest_value(AnyValue{0.12345}, p), AnyValue{0.123});
    EXPECT_TRUE(same_bytes(AnyValue{0.3}, AnyValue{0.1 + 0.2}, p));
}

// Its description was interpreted as a parameter of one byte.
TEST_F(Writes, a_number_is_never_written_in_another_length_than_the_device_sends) {
    fake.parameters = {{0, "U8", "", {0xB2, 0xC0, 0x81, 0}}, {5, "I32", "", {1, 0, 0, 0, 0, 0, 0, 0}}};
    const auto task = write(info(0), std::int64_t{50});
    EXPECT_EQ(task->end()->ending, Ending::invalid);
    EXPECT_EQ(task->end()->fault.text(),
              "U8: 50 would be written as 1 byte, and the device sends 4: its description does not fit its value");
    EXPECT_EQ(write(info(1), std::int64_t{2})->end()->ending, Ending::invalid);
    EXPECT_EQ(writes(), 0u);
    EXPECT_EQ(fake.parameters[0].value, (Bytes{0xB2, 0xC0, 0x81, 0}));
}

TEST_F(Writes, report_a_clamped_value_as_a_success) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{100}; };
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_TRUE(task->is_clamped());
    EXPECT_EQ(task->stored(), AnyValue{std::int64_t{100}});
    EXPECT_EQ(task->end()->fault.text(), "U8 is 100: the device limited it");
}

TEST_F(Writes, are_refused_if_the_device_acknowledges_but_stores_nothing) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{7}; };
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::refused);
    EXPECT_EQ(task->end()->fault.text(), "0xDC keeps U8 at 7");
}

TEST_F(Writes, are_refused_if_the_device_does_not_answer_the_read_back) {
    fake.instead = [&](FrameView f) { return writes() > 0 && f.id() == 0xE0 ? nothing() : std::nullopt; };
    EXPECT_EQ(write(info(0), std::int64_t{200})->end()->ending, Ending::refused);
}

TEST_F(Writes, ignore_a_late_answer_from_before_the_write) {
    bool old_once = true;
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0xE0 || writes() == 0 || !std::exchange(old_once, false)) return std::nullopt;
        return std::vector<Bytes>{fake.to_host(f, 0xE1, {0, 0, 7})};
    };
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_FALSE(task->is_clamped());
}

TEST_F(Writes, time_out_without_an_acknowledgement_and_report_the_number_of_tries) {
    fake.instead = [&](FrameView f) { return f.id() == 0xE1 ? nothing() : std::nullopt; };
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_GE(task->end()->evidence.sent, 5u);
}

TEST_F(Writes, do_not_accept_wrong_check_bytes_as_an_acknowledgement) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0xE1) return std::nullopt;
        return std::vector<Bytes>{fake.to_host(f, 0x00, {0xE1, f.checks().sum, static_cast<std::uint8_t>(f.checks().add + 1)})};
    };
    const TimePoint begin = simulation.now;
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(task->end()->fault.text(), "0xDC acknowledged with wrong check bytes (E1 31 15): write of U8, sent 1 time");
    EXPECT_LT(simulation.now - begin, std::chrono::milliseconds{300});
    EXPECT_EQ(writes(), 1u) << "it has arrived";
}

// The acknowledgement does not show which command it belongs to.
TEST_F(Writes, do_not_end_either_of_two_commands_at_a_wrong_acknowledgement) {
    struct Asks final : Asker {
        int ends = 0;
        void ended(const Ended& /*ended*/, TimePoint /*now*/) override { ++ends; }
    } asks;
    for (const std::uint8_t cid : {std::uint8_t{1}, std::uint8_t{2}}) {
        ASSERT_TRUE(device.ask({0xC0, {cid, 0, 0}, {.sends = 1, .wait = std::chrono::seconds{2}}}, asks));
        ASSERT_TRUE(device.next_frame(simulation.now));
    }
    const Bytes wrong = support::frame(0xDC, 0xFE, 0x00, {0xC0, 1, 2});
    device.take(FrameView{wrong}, simulation.now);
    EXPECT_EQ(asks.ends, 0);
}

TEST_F(Writes, detect_a_stored_value_with_a_wrong_acknowledgement_by_reading_it_back) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0xE1) return std::nullopt;
        fake.usual(f);
        return std::vector<Bytes>{fake.to_host(f, 0x00, {0xE1, f.checks().sum, static_cast<std::uint8_t>(f.checks().add + 1)})};
    };
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(task->stored(), AnyValue{std::int64_t{200}});
    EXPECT_EQ(task->end()->fault.text(), "U8 is written, but was acknowledged with wrong check bytes (E1 31 15)");
    EXPECT_EQ(writes(), 1u);
    ParameterApply import{device, &cache, {{"U8", std::int64_t{9}}, {"I16", std::int64_t{2}}}};
    import.start(simulation.now);
    simulation.run(import);
    EXPECT_EQ(import.end()->ending, Ending::done) << import.end()->fault.text();
    EXPECT_TRUE(import.end()->fault.text().starts_with("U8 is written, but was acknowledged with wrong check bytes (E1 "))
        << import.end()->fault.text();
    EXPECT_TRUE(import.end()->fault.text().ends_with("), and 1 other value was too")) << import.end()->fault.text();
}

TEST_F(Writes, report_that_the_value_may_be_written_when_the_device_is_silent_afterwards) {
    fake.instead = [&](FrameView) { return writes() > 0 ? nothing() : std::nullopt; };
    const auto task = write(info(0), std::int64_t{200});
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_TRUE(task->end()->fault.text().starts_with("0xDC does not answer: write of U8, which may be done, sent "))
        << task->end()->fault.text();
}

TEST_F(Writes, an_empty_text_is_written_as_it_is) {
    for (const bool keeps_nuls : {true, false}) {
        if (!keeps_nuls) fake.parameters[2].store = [](const Bytes&) { return Bytes{}; };
        fake.parameters[2].value = {'a', 'b', 'c', 'd', 0, 0};
        const auto task = write(info(2), std::string{});
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(task->end()->fault.text(), "");
        EXPECT_FALSE(task->is_clamped());
        EXPECT_EQ(task->stored(), AnyValue{std::string{}});
        EXPECT_EQ(task->before(), AnyValue{std::string{"abcd"}});
    }
}

// Its device info is discarded when its first answer arrives.
TEST_F(Writes, identify_a_device_again_after_a_long_silence) {
    write(info(0), std::int64_t{1});
    simulation.pass(Device::away_after);
    const auto task = write(info(0), std::int64_t{2});
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(fake.parameters[0].value, Bytes{2});
}

TEST_F(Writes, nothing_is_written_to_a_device_that_became_another_one) {
    write(info(0), std::int64_t{1});
    simulation.pass(Device::away_after);
    const ParameterInfo as_before = info(0);
    fake.parameters[0].name = "OTHER";
    const std::size_t until_now = writes();
    const auto task = write(as_before, std::int64_t{2});
    EXPECT_EQ(task->end()->ending, Ending::failed);
    EXPECT_EQ(task->end()->fault.text(), "0xDC became another device in the meantime");
    EXPECT_FALSE(task->was_sent());
    EXPECT_EQ(writes(), until_now);
}

TEST_F(Writes, an_id_at_the_count_is_never_sent) {
    ParameterInfo beyond = info(3);
    beyond.id = 4;
    EXPECT_EQ(write(beyond, std::int64_t{1})->end()->ending, Ending::invalid);
    EXPECT_EQ(writes(), 0u);
    EXPECT_FALSE(fake.crashed);
}

TEST_F(Writes, no_value_is_shorter_than_its_type) {
    write(info(0), std::int64_t{1});
    write(info(1), 2.5);
    write(info(3), std::int64_t{2});
    write(info(2), std::string{});
    for (const Bytes& f : fake.heard) {
        if (f[3] != 0xE1) continue;
        const Bytes least{1, 4, 1, 2};
        EXPECT_GE(f.size() - 10, least[f[6]]) << "parameter " << int{f[6]};
    }
}

TEST_F(Writes, never_send_a_value_that_does_not_fit_its_type) {
    EXPECT_EQ(write(info(0), std::int64_t{256})->end()->fault.text(), "U8: 256 is out of range, u8 is 0 to 255");
    EXPECT_EQ(write(info(0), 1.5)->end()->fault.text(), "U8: 1.5 is not whole, u8 is 0 to 255");
    EXPECT_EQ(write(info(0), std::string{"1"})->end()->fault.text(), "U8: \"1\" is not a number, u8 is 0 to 255");
    EXPECT_EQ(write(info(2), std::int64_t{1})->end()->fault.text(), "TEXT: 1 is not a text");
    EXPECT_EQ(write(info(2), std::string("a\0b", 3))->end()->ending, Ending::invalid);
    ParameterInfo odd = info(0);
    odd.type.reset();
    EXPECT_EQ(write(odd, std::int64_t{1})->end()->ending, Ending::unsupported);
    EXPECT_EQ(writes(), 0u);
}

TEST_F(Writes, a_text_is_never_longer_than_before_unless_asked) {
    EXPECT_EQ(write(info(2), std::string{"1234567"})->end()->ending, Ending::invalid);
    EXPECT_EQ(writes(), 0u);
    EXPECT_EQ(write(info(2), std::string{"123456"})->end()->ending, Ending::done);
    EXPECT_EQ(write(info(2), std::string{"1234567"}, {.longer = true})->end()->ending, Ending::done);
    EXPECT_EQ(write(info(2), std::string(30, 'x'), {.longer = true, .max_bytes = 29})->end()->ending, Ending::invalid);
}

TEST_F(Writes, a_shorter_text_leaves_nothing_of_the_old_one) {
    EXPECT_EQ(write(info(2), std::string{"x"})->end()->ending, Ending::done);
    EXPECT_EQ(fake.parameters[2].value, (Bytes{'x', 0, 0, 0, 0, 0}));
}

TEST_F(Writes, report_whether_the_value_may_be_written_when_cancelled) {
    ParameterWrite early{device, info(0), std::int64_t{1}};
    early.start(simulation.now);
    early.cancel(simulation.now);
    EXPECT_EQ(early.end()->fault.text(), "U8 was not written");
    ParameterWrite later{device, info(0), std::int64_t{1}};
    simulation.each_step = [&](TimePoint now) {
        if (writes() > 0) later.cancel(now);
    };
    later.start(simulation.now);
    simulation.run(later);
    EXPECT_EQ(later.end()->fault.text(), "U8 may have been written");
}

TEST_F(Writes, an_action_ends_with_its_acknowledgement) {
    ParameterAction save{device, Action::save};
    save.start(simulation.now);
    simulation.run(save);
    EXPECT_EQ(save.end()->ending, Ending::done);
    EXPECT_EQ(Bytes(fake.heard[0].begin() + 6, fake.heard[0].end() - 2), (Bytes{0x10, 0xAB, 0}));
    fake.deaf = true;
    ParameterAction restore{device, Action::restore_defaults};
    restore.start(simulation.now);
    EXPECT_LE(simulation.run(restore), std::chrono::seconds{12});
    EXPECT_EQ(restore.end()->fault.text(), "0xDC does not answer: restore defaults, sent 1 time") << "it may be another one";
}

TEST_F(Writes, a_save_is_sent_once_more_at_most) {
    fake.deaf = true;
    ParameterAction save{device, Action::save};
    save.start(simulation.now);
    EXPECT_LE(simulation.run(save), std::chrono::seconds{12});
    EXPECT_EQ(save.end()->fault.text(), "0xDC does not answer: save, sent 1 time") << "it may be another one";
    fake.deaf = false;
    fake.instead = [&](FrameView f) { return f.data()[0] == 0x10 ? nothing() : std::nullopt; };
    fake.heard.clear();
    ParameterAction unacknowledged{device, Action::save};
    unacknowledged.start(simulation.now);
    EXPECT_LE(simulation.run(unacknowledged), std::chrono::seconds{11});
    EXPECT_EQ(std::count_if(fake.heard.begin(), fake.heard.end(), [](const Bytes& f) { return f[6] == 0x10; }), 2);
}

TEST_F(Writes, wrong_check_bytes_end_an_action_at_once) {
    for (const Duration delay :
         {Duration{std::chrono::milliseconds{10}}, Duration{}}) {    // also an answer at the time of the question
        simulation.there.delay = simulation.back.delay = delay;
        fake.heard.clear();
        fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
            return std::vector<Bytes>{fake.to_host(f, 0x00, {f.id(), 1, 2})};
        };
        ParameterAction save{device, Action::save};
        save.start(simulation.now);
        EXPECT_LT(simulation.run(save), std::chrono::milliseconds{100});
        EXPECT_EQ(save.end()->fault.text(), "0xDC acknowledged with wrong check bytes (E0 01 02): save, sent 1 time");
        const auto is_save = [](const Bytes& f) { return f[6] == 0x10; };
        EXPECT_EQ(std::count_if(fake.heard.begin(), fake.heard.end(), is_save), 1) << "each save wears the flash";
    }
}

// An ESP32 library acknowledges questions as well.
TEST_F(Writes, ignore_an_acknowledgement_of_an_earlier_request) {
    fake.instead = [&](FrameView f) -> std::optional<std::vector<Bytes>> {
        auto answers = fake.usual(f);
        if (f.data()[0] != 0x10) answers.push_back(fake.check(f));
        return answers;
    };
    struct Asks final : Asker {
        void ended(const Ended& /*ended*/, TimePoint /*now*/) override {}
    } asks;
    ASSERT_TRUE(device.ask(question::device_info(0), asks));
    ParameterAction save{device, Action::save};
    save.start(simulation.now);
    simulation.run(save);
    EXPECT_EQ(save.end()->ending, Ending::done);
    EXPECT_EQ(fake.heard.size(), 2u) << "the save is sent once";
}

struct Applies : Writes {
    std::unique_ptr<ParameterApply> apply(std::vector<std::pair<std::string, AnyValue>> values, ApplyOptions options = {}) {
        auto task = std::make_unique<ParameterApply>(device, &cache, std::move(values), options);
        task->start(simulation.now);
        simulation.run(*task);
        EXPECT_TRUE(task->end());
        EXPECT_FALSE(fake.crashed);
        return task;
    }
    static std::vector<State> states(const ParameterApply& task) {
        std::vector<State> all;
        for (const auto& row : task.rows()) all.push_back(row.state);
        return all;
    }
};

TEST_F(Applies, writes_only_values_that_differ) {
    const auto task = apply({{"U8", std::int64_t{7}}, {"F32", 0.5}, {"TEXT", std::string{"abcd"}}, {"I16", std::int64_t{2}}});
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(states(*task), (std::vector{State::same, State::same, State::same, State::written}));
    EXPECT_EQ(writes(), 1u);
    EXPECT_EQ(task->rows()[3].before, AnyValue{std::int64_t{1}});
    EXPECT_EQ(task->rows()[3].stored, AnyValue{std::int64_t{2}});
}

TEST_F(Applies, compares_the_device_only_once_after_a_lost_write) {
    fake.make_parameters(10, 0);
    std::size_t lost = 0;
    fake.instead = [&](FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (frame.id() == 0xE1 && writes() == 3 && lost++ == 0) return std::vector<Bytes>{};
        return std::nullopt;
    };
    std::vector<std::pair<std::string, AnyValue>> values;
    for (int i = 0; i < 10; ++i) values.emplace_back("PAR_" + std::to_string(i), std::int64_t{90 + i});
    const auto task = apply(values);
    EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
    EXPECT_EQ(lost, 1u);
    const auto is_write = [](const Bytes& frame) { return frame[3] == 0xE1; };
    const auto first = std::find_if(fake.heard.begin(), fake.heard.end(), is_write);
    EXPECT_LE(std::count_if(first, fake.heard.end(), [](const Bytes& frame) { return frame[3] == 0xE0 && frame[6] == 3; }), 1);
}

TEST_F(Applies, lists_a_clamped_value_without_a_failure) {
    fake.parameters[0].store = [](const Bytes&) { return Bytes{100}; };
    const auto task = apply({{"U8", std::int64_t{200}}, {"I16", std::int64_t{2}}}, {.rollback = true});
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(states(*task), (std::vector{State::clamped, State::written}));
}

// A failure after a restart is caused by it, and the values written before are lost unless they were saved.
TEST_F(Applies, reports_a_restart_during_the_import) {
    for (const bool fails : {true, false}) {
        if (fails) fake.parameters[3].store = [](const Bytes&) { return Bytes{1, 0}; };
        else fake.parameters[3].store = nullptr;
        const std::size_t before = writes();
        simulation.each_step = [&, restarted = false](TimePoint now) mutable {
            if (writes() == before || std::exchange(restarted, true)) return;
            const auto info = fake.take(FrameView{support::frame(0xFE, 0xDC, 0xE0, {0, 0, 0})});
            device.take(FrameView{info.at(0)}, now + 2 * Device::info_doubled_within);
        };
        const auto task = apply({{"U8", std::int64_t{fails ? 9 : 10}}, {"I16", std::int64_t{2}}});
        EXPECT_EQ(task->end()->ending, fails ? Ending::refused : Ending::done);
        EXPECT_NE(task->end()->fault.text().find("restarted"), std::string::npos) << task->end()->fault.text();
        EXPECT_EQ(task->end()->fault.text().find("so what was written before that may be lost") != std::string::npos, fails);
        EXPECT_EQ(task->rows()[1].fault.text().find("restarted") != std::string::npos, fails) << task->rows()[1].fault.text();
    }
}

// The device saves nothing on its own: after a restart it has the previous values.
struct Restarts : Applies {
    std::vector<FakeDevice::Parameter> saved;
    unsigned restarts = 0, max_restarts = 1;
    std::size_t at_write = 4;

    Restarts() {
        fake.parameters.clear();
        fake.make_parameters(10, 0);
        saved = fake.parameters;
        // So fast that there is no sign: directly after the value is read back.
        fake.instead = [this](FrameView frame) -> std::optional<std::vector<Bytes>> {
            auto answers = fake.usual(frame);
            const bool reads_back = frame.id() == 0xE0 && frame.data()[0] == 2;
            if (reads_back && writes() >= at_write && restarts < max_restarts) {
                ++restarts;
                fake.parameters = saved;
            }
            return answers;
        };
    }
    std::unique_ptr<ParameterApply> apply_all(ApplyOptions options = {}) {
        std::vector<std::pair<std::string, AnyValue>> values;
        for (int i = 0; i < 8; ++i) values.emplace_back("PAR_" + std::to_string(i), std::int64_t{90 + i});
        return apply(values, options);
    }
    int new_values() const {
        int number = 0;
        for (int i = 0; i < 8; ++i) {
            const auto& parameter = fake.parameters[static_cast<std::size_t>(i)];
            number += parameter.value[0] == 90 + i && parameter.value.back() == (parameter.value.size() == 1 ? 90 + i : 0);
        }
        return number;
    }
};

TEST_F(Restarts, without_any_sign_cause_lost_values_to_be_written_again) {
    for (const bool rollback : {false, true}) {
        fake.parameters = saved;
        restarts = 0;
        at_write = writes() + 4;
        const auto task = apply_all({.rollback = rollback, .goes_on = !rollback});
        EXPECT_EQ(restarts, 1u);
        EXPECT_EQ(task->end()->ending, Ending::done) << task->end()->fault.text();
        EXPECT_EQ(task->end()->fault.text(),
                  "the device has probably restarted in the meantime: 4 values were lost and written again");
        EXPECT_EQ(states(*task), std::vector<State>(8, State::written));
        EXPECT_EQ(new_values(), 8);
    }
}

TEST_F(Restarts, that_lose_values_again_are_reported_and_rolled_back) {
    max_restarts = 100;
    const auto task = apply_all({.goes_on = true});
    EXPECT_NE(task->end()->ending, Ending::done);
    std::size_t written = 0;
    for (const auto& row : task->rows()) written += row.state == State::written;
    EXPECT_LE(written, static_cast<std::size_t>(new_values())) << task->end()->fault.text();
    fake.parameters = saved;
    at_write = writes() + 4;
    const auto undone = apply_all({.rollback = true});
    EXPECT_NE(undone->end()->ending, Ending::done);
    EXPECT_EQ(new_values(), 0);
}

TEST_F(Restarts, are_excluded_with_one_request_per_value_in_the_last_pass) {
    max_restarts = 0;
    const auto task = apply_all();
    EXPECT_EQ(task->end()->fault.text(), "");
    EXPECT_EQ(writes(), 8u);
    const std::size_t before = fake.heard.size();
    EXPECT_EQ(apply({{"PAR_0", std::int64_t{3}}})->end()->ending, Ending::done);
    EXPECT_LE(fake.heard.size() - before, 6u) << "one value alone is not read back a second time";
}

TEST_F(Applies, writes_nothing_if_one_value_is_invalid) {
    EXPECT_EQ(apply({{"I16", std::int64_t{2}}, {"NONE", 1.0}})->end()->fault.text(), "unknown parameter NONE");
    EXPECT_EQ(apply({{"I16", std::int64_t{2}}, {"U8", std::int64_t{-1}}})->end()->fault.text(),
              "U8: -1 is out of range, u8 is 0 to 255");
    fake.parameters.push_back({0, "U8", "", {1}});
    EXPECT_EQ(apply({{"I16", std::int64_t{2}}, {"U8", std::int64_t{1}}})->end()->fault.text(),
              "several parameters have the name U8");
    EXPECT_EQ(writes(), 0u);
}

TEST_F(Applies, reports_every_invalid_value_before_the_first_write) {
    const auto task = apply({{"TEXT", std::string{"1234567"}},
                             {"I16", std::int64_t{2}},
                             {"NONE", 1.0},
                             {"U8", std::int64_t{256}},
                             {"F32", std::string{"x"}}});
    EXPECT_EQ(task->end()->ending, Ending::invalid);
    EXPECT_EQ(task->end()->fault.text(), "4 of 5 parameters can't be written: TEXT, NONE, U8, F32");
    EXPECT_EQ(states(*task), (std::vector{State::failed, State::waiting, State::failed, State::failed, State::failed}));
    EXPECT_EQ(task->rows()[0].fault.text(),
              "TEXT: \"1234567\" is longer than the 6 bytes that the device has: a longer one must be allowed (longer)");
    EXPECT_EQ(task->rows()[2].fault.text(), "unknown parameter NONE");
    EXPECT_EQ(task->rows()[3].fault.text(), "U8: 256 is out of range, u8 is 0 to 255");
    EXPECT_EQ(task->rows()[4].fault.text(), "F32: \"x\" is not a number, f32 is -3.4e38 to 3.4e38");
    EXPECT_EQ(writes(), 0u);
    EXPECT_EQ(apply({{"TEXT", std::string{"1234567"}}}, {.text = {.longer = true}})->end()->ending, Ending::done);
}

TEST_F(Applies, lists_the_differences_in_a_dry_run) {
    const auto task = apply({{"U8", std::int64_t{7}}, {"I16", std::int64_t{2}}}, {.dry_run = true});
    EXPECT_EQ(task->end()->ending, Ending::done);
    EXPECT_EQ(states(*task), (std::vector{State::same, State::waiting}));
    EXPECT_EQ(writes(), 0u);
}

TEST_F(Applies, ends_at_the_first_failure) {
    fake.parameters[1].store = [](const Bytes&) { return Bytes{0, 0, 0, 0x3F}; };
    const auto task = apply({{"U8", std::int64_t{9}}, {"F32", 2.0}, {"I16", std::int64_t{2}}});
    EXPECT_EQ(task->end()->ending, Ending::refused);
    EXPECT_EQ(states(*task), (std::vector{State::written, State::failed, State::waiting}));
    EXPECT_EQ(fake.parameters[0].value, Bytes{9});
}

TEST_F(Applies, continues_after_a_refused_value_if_allowed) {
    fake.parameters[1].store = [](const Bytes&) { return Bytes{0, 0, 0, 0x3F}; };
    fake.instead = [&](FrameView f) { return f.id() == 0xE1 && f.data()[0] == 0 ? nothing() : std::nullopt; };    // read-only
    const auto task = apply({{"U8", std::int64_t{9}}, {"F32", 2.0}, {"I16", std::int64_t{2}}}, {.goes_on = true});
    EXPECT_EQ(states(*task), (std::vector{State::failed, State::failed, State::written}));
    EXPECT_EQ(task->end()->ending, Ending::timeout) << "as the first";
    EXPECT_EQ(task->end()->fault.text(), "2 of 3 parameters were not written: U8, F32");
    EXPECT_EQ(fake.parameters[3].value, (Bytes{2, 0}));
    fake.instead = nullptr;
    const auto one = apply({{"U8", std::int64_t{10}}, {"F32", 3.0}}, {.goes_on = true});
    EXPECT_EQ(one->end()->fault.text(), "0xDC keeps F32 at 0.5");
    EXPECT_EQ(fake.parameters[0].value, Bytes{10});
    const auto all = apply({{"F32", 2.0}, {"U8", std::int64_t{11}}}, {.rollback = true, .goes_on = true});
    EXPECT_EQ(states(*all), (std::vector{State::failed, State::waiting}));
}

TEST_F(Applies, ends_when_the_device_no_longer_answers_even_if_it_may_continue_after_failures) {
    fake.instead = [&](FrameView) { return writes() > 0 ? nothing() : std::nullopt; };
    const auto task = apply({{"U8", std::int64_t{9}}, {"F32", 2.0}, {"I16", std::int64_t{2}}}, {.goes_on = true});
    EXPECT_EQ(states(*task), (std::vector{State::failed, State::waiting, State::waiting}));
    EXPECT_EQ(writes(), task->end()->evidence.sent);
}

TEST_F(Applies, rollback_undoes_all_when_one_fails) {
    fake.instead = [&](FrameView f) { return f.id() == 0xE1 && f.data()[0] == 1 ? nothing() : std::nullopt; };
    const auto task = apply({{"U8", std::int64_t{9}}, {"TEXT", std::string{"new"}}, {"F32", 2.0}, {"I16", std::int64_t{2}}},
                            {.rollback = true});
    EXPECT_EQ(task->end()->ending, Ending::timeout);
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
    EXPECT_EQ(fake.parameters[2].value[0], 'a');
    EXPECT_EQ(fake.parameters[3].value, (Bytes{1, 0}));
    EXPECT_EQ(task->rows()[3].state, State::waiting);
    EXPECT_EQ(task->rows()[2].state, State::failed) << "it was read back, and is as it was";
}

TEST_F(Applies, rolls_back_before_it_ends_when_cancelled_with_rollback) {
    ParameterApply task{device, &cache, {{"U8", std::int64_t{9}}, {"I16", std::int64_t{2}}}, {.rollback = true}};
    simulation.each_step = [&, cancelled = false](TimePoint now) mutable {
        if (writes() == 2 && !std::exchange(cancelled, true)) task.cancel(now);
    };
    task.start(simulation.now);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::cancelled);
    EXPECT_EQ(states(task), (std::vector{State::undone, State::undone}));
    EXPECT_EQ(fake.parameters[0].value, Bytes{7});
    EXPECT_EQ(fake.parameters[3].value, (Bytes{1, 0}));
}

TEST_F(Applies, reports_the_values_not_rolled_back_when_cancelled_twice) {
    ParameterApply task{device, &cache, {{"U8", std::int64_t{9}}, {"F32", 2.0}, {"I16", std::int64_t{2}}}, {.rollback = true}};
    simulation.each_step = [&](TimePoint now) {
        if (writes() >= 2) task.cancel(now);
    };
    task.start(simulation.now);
    simulation.run(task);
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->fault.text(), "cancelled while it was undone");
    EXPECT_EQ(states(task), (std::vector{State::not_undone, State::not_undone, State::waiting}));
}

TEST_F(Applies, ends_together_with_the_rollback_when_the_device_is_dead) {
    fake.instead = [&](FrameView) { return writes() >= 2 ? nothing() : std::nullopt; };
    ParameterApply task{device, &cache, {{"U8", std::int64_t{9}}, {"F32", 2.0}, {"I16", std::int64_t{2}}}, {.rollback = true}};
    task.start(simulation.now);
    EXPECT_LT(simulation.run(task), std::chrono::seconds{30});
    ASSERT_TRUE(task.end());
    EXPECT_EQ(task.end()->ending, Ending::timeout);
    EXPECT_EQ(states(task), (std::vector{State::not_undone, State::not_undone, State::waiting}));
}

// Another device is connected in place of the one that was written to, while that is away or while the values are undone: at the
// `at`th write.
struct BecomesAnother : Applies {
    std::unique_ptr<ParameterApply> apply_all(std::size_t at, bool rollback, bool says_it) {
        const std::size_t first = writes();
        fake.instead = [=, this, done = false](FrameView f) mutable -> std::optional<std::vector<Bytes>> {
            if (f.id() == 0xE1 && writes() - first == at && !std::exchange(done, true)) {
                for (auto& parameter : fake.parameters) parameter.name = "NEW_" + parameter.name;
                if (says_it) fake.version += 1;
                device.link_was_down();
                is_another = fake.parameters;
                return nothing();
            }
            const bool refuses = !done && at > 3 && f.id() == 0xE1 && f.data()[0] == 1 && f.data()[1] == 0;
            return refuses ? std::optional{nothing()} : std::nullopt;
        };
        return apply({{"U8", std::int64_t{9}}, {"I16", std::int64_t{2}}, {"TEXT", std::string{"new"}}, {"F32", 2.0}},
                     {.rollback = rollback});
    }
    decltype(fake.parameters) is_another;
};

TEST_F(BecomesAnother, device_and_receives_no_further_values) {
    for (const bool rollback : {true, false})
        for (const bool says_it : {true, false})
            for (const std::size_t at : {1u, 2u, 3u}) {
                const auto had = fake.parameters;
                const auto task = apply_all(at, rollback, says_it);
                EXPECT_NE(task->end()->ending, Ending::done);
                EXPECT_TRUE(task->is_of_another()) << at << ' ' << task->end()->fault.text();
                EXPECT_EQ(task->end()->fault.text().find("0xDC became another device in the meantime"), 0u)
                    << task->end()->fault.text();
                ASSERT_EQ(is_another.size(), fake.parameters.size());
                for (std::size_t i = 0; i < is_another.size(); ++i)
                    EXPECT_EQ(fake.parameters[i].value, is_another[i].value) << at;
                fake.parameters = had;
                fake.instead = nullptr;
                device.link_was_down();
                cache = {};
            }
}

}    // namespace
}    // namespace ano::host::parameter_write_tests
