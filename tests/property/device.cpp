// A device with any input: it answers a frame at most once, and an acknowledged value was stored, or the nearest permitted value.
#include <ano/conversation.hpp>
#include <ano/reading.hpp>
#include <ano/wire.hpp>
#include <device/device.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace device_tests {

using namespace ano::device;
using namespace std::chrono_literals;
using ano::FrameView;
using ano::Type;
using support::Bytes;
using support::Random;
using support::operator+;

namespace {

constexpr std::uint8_t host = 0xFE;
constexpr ano::TimePoint start{1000s};
constexpr std::array types{Type::u8,  Type::i8,  Type::u16, Type::i16, Type::u32, Type::i32,
                           Type::u64, Type::i64, Type::f32, Type::f64, Type::text};

Profile any_profile(Random& random) {
    Profile profile = random.of({Profile{}, Profile{}, Profile::vendor(), Profile::old()});
    profile.queue = 0;
    if (random.one_in(4)) profile.refuses_beyond_limits = true;
    return profile;
}

Bytes random_bytes(Random& random, std::size_t size) {
    Bytes result(size);
    for (auto& byte : result) byte = random.of<std::uint8_t>({0, 1, 0x7F, 0xFF, random.byte(), random.byte(), random.byte()});
    return result;
}

Value random_value(Random& random, Type type) {
    Bytes bytes = random_bytes(random, type == Type::text ? random.below(20u) : 8);
    Value value = read_value(type, bytes);
    return is_nan(value) ? Value{1.0} : value;
}

// A device with parameters of every type, whose values this object stores.
struct Thing {
    Thing(std::uint8_t id, Random& random, const Profile& profile = {}) : device{{.id = id, .name = "thing"}, profile} {
        for (std::size_t i = random.below(12u); i-- > 0;) add_parameter(random);
        for (std::size_t i = random.below(4u); i-- > 0;)
            device.commands().add({static_cast<std::uint8_t>(i), 0, 0}, "C" + std::to_string(i), "",
                                  [this](std::uint8_t) { ++runs; });
        device.waypoints().allow(random.below(6u));
        device.waypoints().resize(random.below(6u));
        if (!random.one_in(3)) device.firmware().allow({.max_size = 1000, .erase_time = random.of<ano::Duration>({0s, 1s})});
        if (random.one_in(2)) device.parameters().on_save([] { return true; });
    }
    void add_parameter(Random& random) {
        const Type type = types[random.below(types.size())];
        const std::size_t i = values.size();
        Value& value = values.emplace_back(random_value(random, type));
        Parameter row{.name = "P" + std::to_string(i), .type = type, .initial = value, .max_size = 20};
        row.get = [&value] { return value; };
        row.set = [&value](const Value& v) { return value = v, true; };
        if (type != Type::text) {
            row.min = std::min(value, random_value(random, type));
            row.max = std::max(value, random_value(random, type));
        }
        device.parameters().add(row);
    }
    std::vector<Bytes> receive(const Bytes& frame, ano::TimePoint now = start) {
        device.take(FrameView{frame}, now);
        std::vector<Bytes> answers;
        while (const auto out = device.next()) answers.emplace_back(out->frame.bytes().begin(), out->frame.bytes().end());
        return answers;
    }

    Device device;
    std::deque<Value> values;
    int runs = 0;
};

// A frame of the message table, mostly with a valid layout, and with meaningful numbers in it.
Bytes random_frame(Random& random, std::uint8_t from, std::uint8_t to) {
    const ano::Message& row = ano::messages[random.below(ano::messages.size())];
    const std::uint8_t id = random.one_in(2)
                                ? row.id
                                : random.of<std::uint8_t>({0xE0, 0xE0, 0xE1, 0xC0, 0xC1, 0x60, 0x61, 0xF0, 0xF0, 0x00});
    std::size_t size = ano::layouts_of(id)[random.below(ano::layouts_of(id).size())].fixed_size + random.below(12u);
    if (random.one_in(8)) size = random.below(300u);
    Bytes data = random_bytes(random, size);
    for (std::size_t i = 0; i < std::min<std::size_t>(data.size(), 3); ++i)
        if (!random.one_in(4)) data[i] = random.of<std::uint8_t>({0, 0, 1, 2, 3, 5, 0x10, 0x20, 0xAA, 0xAB, 0xFF, 0x12, 0x10});
    return support::frame(from, to, id, data);
}

TEST(Device, stores_each_acknowledged_value_or_the_nearest_allowed_one) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        Random random{seed};
        Profile profile;
        profile.refuses_beyond_limits = random.one_in(2);
        Thing thing{0x21, random, profile};
        for (int i = 0; i < 40 && !thing.values.empty(); ++i) {
            const std::size_t id = random.below(thing.values.size());
            const Parameter& row = thing.device.parameters()[id];
            const Bytes value = random_bytes(random, random.below(24u));
            const Value before = thing.values[id];
            const Bytes write = support::frame(host, 0x21, 0xE1, Bytes{static_cast<std::uint8_t>(id), 0} + value);
            const bool acknowledged = !thing.receive(write).empty();
            const Value& after = thing.values[id];
            const bool whole = ano::is_whole_value(value.size(), row.type);
            if (!acknowledged) {
                ASSERT_EQ(after, before) << "seed " << seed;
                ASSERT_TRUE(!whole || is_nan(read_value(row.type, value)) || profile.refuses_beyond_limits) << "seed " << seed;
                continue;
            }
            ASSERT_TRUE(whole) << "seed " << seed;
            const Value wanted = read_value(row.type, value);
            if (row.type == Type::text) {
                ASSERT_EQ(after, Value{std::get<std::string>(wanted).substr(0, row.max_size)}) << "seed " << seed;
            } else {
                ASSERT_EQ(after, std::clamp(wanted, *row.min, *row.max)) << "seed " << seed;
            }
            if (profile.refuses_beyond_limits) {
                ASSERT_EQ(after, wanted) << "seed " << seed;
            }
            Bytes told;
            append_value(told, row.type, after);
            const auto read = thing.receive(support::frame(host, 0x21, 0xE0, {2, static_cast<std::uint8_t>(id), 0}));
            ASSERT_EQ(read,
                      (std::vector<Bytes>{support::frame(0x21, host, 0xE1, Bytes{static_cast<std::uint8_t>(id), 0} + told)}));
        }
    }
}

TEST(Device, returns_a_waypoint_as_it_was_written) {
    for (std::uint64_t seed = 0; seed < support::trials(2000); ++seed) {
        Random random{seed};
        Device device{{.id = 0x21}};
        device.waypoints().allow(1);
        const Bytes waypoint = Bytes{0} + random_bytes(random, 23);
        const Bytes write = support::frame(host, 0x21, 0x61, waypoint);
        const Bytes read = support::frame(host, 0x21, 0x60, {0});
        device.take(FrameView{write}, start);
        device.take(FrameView{read}, start);
        ASSERT_TRUE(device.next());
        const auto told = device.next();
        ASSERT_TRUE(told);
        ASSERT_TRUE(std::equal(waypoint.begin(), waypoint.end() - 2, told->frame.data().begin(), told->frame.data().end()));
    }
}

// For any input: at most one answer, to the sender of the request, and no growth of memory.
TEST(Device, answers_every_frame_at_most_once) {
    for (std::uint64_t seed = 0; seed < support::trials(200); ++seed) {
        Random random{seed};
        Thing thing{0x21, random, any_profile(random)};
        ano::TimePoint now = start;
        std::size_t late = 0;
        for (int i = 0; i < 200; ++i) {
            const auto from = random.of<std::uint8_t>({host, host, host, 0x05, 0xD2, 0x21, 0x00, 0xFF});
            const auto to = random.of<std::uint8_t>({0x21, 0x21, 0x21, 0xFF, 0x22, 0x00});
            const Bytes frame = random_frame(random, from, to);
            now += 10ms;
            const auto allocated = support::allocations;
            thing.device.run(now);
            while (thing.device.next()) ++late;
            const auto answers = thing.receive(frame, now);
            ASSERT_LE(support::allocations - allocated, 60u) << "seed " << seed;
            ASSERT_LE(answers.size(), 1u) << "seed " << seed;
            const bool may_be_answered = from != 0 && from != 0xFF && from != 0x21 && (to == 0x21 || to == 0xFF);
            if (!may_be_answered || frame[3] == 0x00 || frame[3] == 0xE3) {
                ASSERT_TRUE(answers.empty()) << "seed " << seed;
            }
            for (const Bytes& answer : answers) {
                ASSERT_TRUE(ano::frame_at(answer)) << "seed " << seed;
                ASSERT_EQ(answer[1], 0x21) << "seed " << seed;
                ASSERT_EQ(answer[2], from) << "seed " << seed;
                ASSERT_LE(answer.size(), ano::overhead + max_sent) << "seed " << seed;
                if (answer[3] == 0x00) {
                    ASSERT_TRUE(ano::may_be_acknowledged(frame[3])) << "seed " << seed;
                }
            }
        }
        const Counters& c = thing.device.counters();
        ASSERT_EQ(c.not_ours + c.from_nobody + c.too_long + c.queue_full + c.crashed + c.unanswered + c.unknown + c.malformed +
                      c.refused + c.answered,
                  200u)
            << "every frame is in one counter; seed " << seed;
        ASSERT_LE(late, 200u);
    }
}

// The same if frames wait, and are dropped when too many wait.
TEST(Device, answers_waiting_frames_at_most_once) {
    for (std::uint64_t seed = 0; seed < support::trials(100); ++seed) {
        Random random{seed};
        Thing thing{0x21, random, random.of({Profile::vendor(), Profile::old()})};
        ano::TimePoint now = start;
        std::size_t answers = 0;
        const auto drain = [&] {
            while (thing.device.next()) ++answers;
        };
        for (int i = 0; i < 300; ++i) {
            now += random.of<ano::Duration>({0us, 0us, 100us, 800us, 3ms});
            const Bytes frame = random_frame(random, host, 0x21);
            thing.device.take(FrameView{frame}, now);
            drain();
        }
        while (const auto due = thing.device.due()) thing.device.run(*due);
        drain();
        const Counters& c = thing.device.counters();
        ASSERT_EQ(c.too_long + c.queue_full + c.crashed + c.unanswered + c.unknown + c.malformed + c.refused + c.answered, 300u);
        ASSERT_EQ(answers, c.answered - c.answers_lost) << "seed " << seed;
    }
}

// Two devices receive each other's frames: no frame of one starts an exchange.
TEST(Device, causes_no_storm_with_another_device) {
    for (std::uint64_t seed = 0; seed < support::trials(3000); ++seed) {
        Random random{seed};
        Thing a{0x21, random, any_profile(random)}, b{random.of<std::uint8_t>({0x22, 0xD2, 0xDC}), random, any_profile(random)};
        const std::uint8_t other = b.device.info().id;
        std::deque<Bytes> line;
        // As if one device had sent a request to the other.
        line.push_back(random.one_in(2) ? random_frame(random, other, 0x21) : random_frame(random, 0x21, other));
        std::size_t heard = 0;
        while (!line.empty()) {
            ASSERT_LE(++heard, 4u) << "seed " << seed;
            const Bytes frame = line.front();
            line.pop_front();
            for (Thing* thing : {&a, &b})
                for (Bytes& answer : thing->receive(frame)) line.push_back(std::move(answer));
        }
    }
}

// Frames that are late, lost, repeated, in any order: the image is accepted if and only if every part arrived, and then equals
// the sent one.
TEST(Device, installs_an_image_only_if_it_is_complete) {
    for (std::uint64_t seed = 0; seed < support::trials(300); ++seed) {
        Random random{seed};
        Bytes image = random_bytes(random, 1 + random.below(300u));
        const auto part = 1 + random.below(40u);
        const std::size_t parts = (image.size() + part - 1) / part;
        Bytes installed;
        Device device{{.id = 0x21}};
        device.firmware().allow({.max_size = 300, .install = [&](const Image& whole) {
                                     installed.assign(whole.bytes.begin(), whole.bytes.end());
                                     return true;
                                 }});
        const auto send = [&](const Bytes& data) {
            const Bytes frame = support::frame(host, 0x21, 0xF0, data);
            device.take(FrameView{frame}, start);
            const auto out = device.next();
            return out ? ano::load<std::uint16_t>(out->frame.data().data() + 1) : std::uint16_t{0};
        };
        Bytes info(20);
        info[0] = 1;
        ano::store(info.data() + 1, static_cast<std::uint32_t>(image.size()));
        ano::store(info.data() + 5, static_cast<std::uint16_t>(part));
        ano::store(info.data() + 7, ano::crc16_of(image));
        ASSERT_EQ(send(info), 0x0102);
        ASSERT_EQ(send({0, 0x10, 0x01}), 0x0112);
        std::vector<bool> arrived(parts);
        for (std::size_t i = 0; i < 4 * parts; ++i) {
            const std::size_t number = random.below(parts);
            const auto begin = image.begin() + static_cast<std::ptrdiff_t>(number * part);
            const auto end = number + 1 == parts ? image.end() : begin + static_cast<std::ptrdiff_t>(part);
            ASSERT_EQ(
                send(Bytes{0x10, static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8)} + Bytes(begin, end)),
                0x1002);
            arrived[number] = true;
        }
        const bool whole = std::find(arrived.begin(), arrived.end(), false) == arrived.end();
        ASSERT_EQ(send({0, 0x10, 0x10}), whole ? 0x1012 : 0x1011) << "seed " << seed;
        ASSERT_EQ(installed, whole ? image : Bytes{}) << "seed " << seed;
    }
}

}    // namespace
}    // namespace device_tests
