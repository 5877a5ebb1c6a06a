#include <gtest/gtest.h>
#include <device/device.hpp>

#include <stdexcept>
#include <string>

#include <support/vendor_frames.hpp>

#include "talk.hpp"

namespace device_tests {
namespace {

using ano::FrameView;
using ano::device::Device;
using ano::device::Info;
using ano::device::Profile;
using namespace std::chrono_literals;
using namespace talk;
using support::frame;
using support::operator+;

const Info thermometer{.id = self, .name = "Thermometer", .hw_ver = 3, .sw_ver = 0x0102, .bl_ver = 7, .pt_ver = 810};
const Bytes who_are_you{0, 0, 0};

TEST(Device, reports_its_device_information) {
    Device device{thermometer};
    EXPECT_EQ(answer(device, ask(0xE0, who_are_you)),
              expected_reply(0xE3, Bytes{self, 3, 0, 2, 1, 7, 0, 0x2A, 3} + bytes("Thermometer")));
}

TEST(Device, answers_like_a_vendor_device) {
    Device mcu{{.id = 0xDB, .name = "AnoMCU"}};
    EXPECT_EQ(answer(mcu, support::vendor::who_are_you), support::vendor::i_am_an_mcu);
    std::uint8_t value = 5;
    mcu.parameters().add("FIRST", value);
    EXPECT_EQ(answer(mcu, support::vendor::write_parameter), support::vendor::written);
    EXPECT_EQ(value, 0xFA);
}

TEST(Device, answers_a_broadcast_with_its_address) {
    Device device{thermometer};
    const Bytes reply = answer(device, frame(0xD2, everybody, 0xE0, who_are_you));
    ASSERT_FALSE(reply.empty());
    EXPECT_EQ(reply[1], self);
    EXPECT_EQ(reply[2], 0xD2) << "to the one who asked";
    std::uint8_t value = 0;
    device.parameters().add("V", value);
    const Bytes write = frame(0x05, everybody, 0xE1, {0, 0, 9});
    EXPECT_EQ(answer(device, write), acknowledges(write));
}

TEST(Device, does_not_answer_frames_for_other_devices) {
    Device device{thermometer};
    EXPECT_EQ(answer(device, frame(host, 0x22, 0xE0, who_are_you)), silence);
    EXPECT_EQ(answer(device, frame(host, 0x00, 0xE0, who_are_you)), silence);
    EXPECT_EQ(device.counters().not_ours, 2u);
}

TEST(Device, never_answers_requests_from_address_zero_broadcast_or_itself) {
    Device device{thermometer};
    for (const std::uint8_t from : {std::uint8_t{0x00}, everybody, self})
        for (const std::uint8_t to : {self, everybody})
            EXPECT_TRUE(all_answers(device, frame(from, to, 0xE0, who_are_you)).empty());
    EXPECT_EQ(device.counters().from_nobody, 6u);
}

TEST(Device, never_answers_an_acknowledgement_or_telemetry) {
    Device device{thermometer};
    for (const std::uint8_t id : Bytes{0x00, 0x01, 0x06, 0x40, 0x41, 0xA0, 0xE2, 0xE3, 0xF1, 0xFB, 0x77})
        EXPECT_EQ(answer(device, ask(id, Bytes(22))), silence) << int{id};
    EXPECT_EQ(device.counters().unanswered, 11u);
}

TEST(Device, does_not_answer_a_request_that_is_too_short_or_unknown) {
    Device device{thermometer};
    EXPECT_EQ(answer(device, ask(0xE0, {})), silence);
    EXPECT_EQ(answer(device, ask(0xE0, {0, 0})), silence);
    EXPECT_EQ(answer(device, ask(0xE0, {0x10, 0xAA})), silence);
    EXPECT_EQ(device.counters().malformed, 3u);
    EXPECT_EQ(answer(device, ask(0xE0, {7, 0, 0})), silence);
    EXPECT_EQ(device.counters().unknown, 1u);
    EXPECT_NE(answer(device, ask(0xE0, {0, 0, 0, 9, 9})), silence) << "longer is legal";
}

TEST(Device, answers_on_the_link_of_the_request) {
    Device device{thermometer};
    const Bytes question = ask(0xE0, who_are_you);
    device.take(FrameView{question}, start, 7);
    device.take(FrameView{question}, start, 3);
    EXPECT_EQ(device.next()->link, 7u);
    EXPECT_EQ(device.next()->link, 3u);
    EXPECT_FALSE(device.next());
}

TEST(Device, drops_and_counts_responses_when_its_queue_is_full) {
    Device device{thermometer};
    const Bytes question = ask(0xE0, who_are_you);
    for (std::size_t i = 0; i < ano::device::Outgoing::max_frames + 5; ++i) device.take(FrameView{question}, start);
    EXPECT_EQ(heard(device).size(), ano::device::Outgoing::max_frames);
    EXPECT_EQ(device.counters().answers_lost, 5u);
    EXPECT_NE(answer(device, question), silence) << "and goes on";
}

TEST(Device, sends_messages_of_the_user) {
    Device device{thermometer};
    ano::Draft<"euler"> euler;
    ASSERT_TRUE(euler.set<"rol">(1.0));
    ASSERT_TRUE(device.send(euler, host));
    const auto out = device.next();
    ASSERT_TRUE(out);
    EXPECT_EQ(out->link, ano::device::every_link);
    EXPECT_EQ(heard(device).size(), 0u);
    const Bytes rows(ano::device::max_sent, 1);
    ano::Draft<"image"> image;
    ASSERT_TRUE(image.set<"pixels">(ano::Bytes{rows}));
    EXPECT_FALSE(device.send(image, host)) << "longer than any device in the field takes";
    EXPECT_FALSE(device.next());
}

TEST(Device, accepts_only_a_valid_device_address) {
    for (const std::uint8_t id : Bytes{0, 254, 255}) EXPECT_THROW((Device{{.id = id, .name = "x"}}), std::invalid_argument);
    EXPECT_NO_THROW((Device{{.id = 253, .name = std::string(20, 'n')}}));
    EXPECT_THROW((Device{{.id = 1, .name = std::string(21, 'n')}}), std::invalid_argument);
}

}    // namespace
}    // namespace device_tests
