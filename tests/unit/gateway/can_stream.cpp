#include <gateway/can_settings.hpp>
#include <gateway/can_stream.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <algorithm>

namespace can_stream_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

constexpr TimePoint start{};

CanSettings classic() { return {}; }
CanSettings with_fd() {
    CanSettings can;
    can.fd = true;
    return can;
}
CanSettings with_extended() {
    CanSettings can;
    can.extended = true;
    return can;
}
CanSettings isotp(std::uint32_t tx, std::uint32_t rx) {
    CanSettings can;
    can.framing = CanFraming::isotp;
    can.tx = tx;
    can.rx = rx;
    return can;
}

Bytes data_of(std::size_t size) {
    Bytes data(size);
    for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::uint8_t>(i + 1);
    return data;
}

// A CAN frame as on the bus.
struct OnBus {
    std::uint32_t id;
    Bytes data;
};

std::vector<OnBus> sent(CanCutter& cutter, const Bytes& frame) {
    std::vector<OnBus> bus;
    std::span<const std::uint8_t> rest = frame;
    while (!rest.empty()) {
        const auto pieces = cutter.cut({&rest, 1});
        for (const auto& piece : pieces) {
            bus.push_back({piece.id, {piece.bytes.begin(), piece.bytes.end()}});
            bus.back().data.resize(piece.size);
        }
        rest = rest.subspan(cutter.taken(pieces.size()));
    }
    return bus;
}

struct Receiver {
    explicit Receiver(const CanSettings& can, std::size_t max_data = 4096) : streams{can, max_data} {}
    void operator()(const OnBus& frame) {
        streams.receive(frame.id, frame.data, now,
                        [this](ano::FrameView f) { frames.emplace_back(f.bytes().begin(), f.bytes().end()); });
    }
    void operator()(const std::vector<OnBus>& bus) {
        for (const OnBus& frame : bus) (*this)(frame);
    }
    CanStreams streams;
    std::vector<Bytes> frames;
    TimePoint now = start;
};

TEST(CanSettings, base_is_a_multiple_of_the_range_it_spans) {
    CanSettings can = classic();
    EXPECT_EQ(fault_of(can), "");
    for (const std::uint32_t good : {0u, 0x100u, 0x700u}) {
        can.base = good;
        EXPECT_EQ(fault_of(can), "");
    }
    for (const std::uint32_t bad : {1u, 0x680u, 0x800u, 0x40000u}) {
        can.base = bad;
        EXPECT_TRUE(fault_of(can).starts_with("base is a multiple of 0x100 up to 0x700 (11-bit ids), not 0x")) << fault_of(can);
    }
    can.extended = true;
    for (const std::uint32_t good : {0u, 0x40000u, 0x0AB00000u, 0x1FFC0000u}) {
        can.base = good;
        EXPECT_EQ(fault_of(can), "");
    }
    for (const std::uint32_t bad : {0x600u, 0x20000u, 0x20000000u}) {
        can.base = bad;
        EXPECT_TRUE(fault_of(can).starts_with("base is a multiple of 0x40000 up to 0x1FFC0000 (29-bit ids), not 0x"))
            << fault_of(can);
    }
    can.base = 0x1FFF'FFFF;    // its decimal digits read as hex exceed 32 bits
    EXPECT_TRUE(fault_of(can).ends_with("not 0x1FFFFFFF")) << fault_of(can);
}

TEST(CanSettings, isotp_needs_two_different_ids_of_its_width_and_no_base) {
    EXPECT_EQ(fault_of(isotp(0x7E0, 0x7E8)), "");
    EXPECT_NE(fault_of(isotp(0x7E0, 0x7E0)), "");
    EXPECT_NE(fault_of(isotp(0x7E0, 0x800)), "");
    CanSettings can = isotp(0x7E0, 0x18DA00F1);
    can.extended = true;
    EXPECT_EQ(fault_of(can), "");
    can.base = 0;
    EXPECT_NE(fault_of(can), "");
    can = isotp(1, 2);
    can.rx.reset();
    EXPECT_NE(fault_of(can), "");
    can.framing = CanFraming::stream;
    EXPECT_EQ(fault_of(can), "tx and rx belong to framing=isotp");
}

TEST(CanFdSize, is_the_smallest_legal_one) {
    const std::size_t legal[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
    for (std::size_t bytes = 0; bytes <= 64; ++bytes)
        EXPECT_EQ(can_fd_size(bytes), *std::lower_bound(std::begin(legal), std::end(legal), bytes));
}

TEST(CanIds, of_11_bits_are_base_and_source) {
    const CanIds ids{classic()};
    EXPECT_EQ(ids.of(support::frame(0xDC, 0xFE, 0x03)), 0x6DCu);
    EXPECT_EQ(ids.source(0x600), 0x00);
    EXPECT_EQ(ids.source(0x6FF), 0xFF);
    EXPECT_FALSE(ids.source(0x5FF));
    EXPECT_FALSE(ids.source(0x700));
}

TEST(CanIds, of_29_bits_are_base_class_source_and_destination) {
    const CanIds ids{with_extended()};
    EXPECT_EQ(ids.of(support::frame(0xFE, 0xDC, 0xC0)), 0x0AB0FEDCu);
    EXPECT_EQ(ids.of(support::frame(0xDC, 0xFF, 0x03)), 0x0AB1DCFFu);
    EXPECT_EQ(ids.of(support::frame(0xDF, 0xFE, 0xB0)), 0x0AB2DFFEu);
    EXPECT_EQ(ids.source(0x0AB2DFFE), 0xDF);
    EXPECT_FALSE(ids.source(0x0AB30000));    // there is no class 3
    EXPECT_FALSE(ids.source(0x0AAFFFFF));
}

TEST(CanIds, class_follows_the_protocol_text) {
    const CanIds ids{with_extended()};
    const auto class_of = [&](std::uint8_t id) { return (ids.of(support::frame(1, 2, id)) >> 16) - 0x0AB0; };
    for (const std::uint8_t id : Bytes{0x00, 0x40, 0x41, 0x60, 0x61, 0xC0, 0xC1, 0xC2, 0xE0, 0xE1, 0xE2, 0xE3, 0xF0})
        EXPECT_EQ(class_of(id), 0u) << int{id};
    for (const std::uint8_t id : Bytes{0x01, 0x0F, 0x20, 0x21, 0x30, 0x35, 0x51, 0xA0, 0xA1})
        EXPECT_EQ(class_of(id), 1u) << int{id};
    for (const std::uint8_t id : Bytes{0x10, 0x36, 0x42, 0xB0, 0xB1, 0xB2, 0xF1, 0xFA, 0xFB, 0xFF})
        EXPECT_EQ(class_of(id), 2u) << int{id};
}

TEST(CanIds, filters_let_exactly_our_ids_through) {
    for (const bool extended : {false, true}) {
        CanSettings can;
        can.extended = extended;
        const CanIds ids{can};
        const std::uint32_t first = extended ? 0x0AAFFF00 : 0, last = extended ? 0x0AB40100 : 0x7FF;
        for (std::uint32_t id = first; id <= last; ++id) {
            const auto filters = ids.filters();
            const bool through = std::any_of(filters.begin(), filters.end(),
                                             [id](auto f) { return (id & f.mask) == (f.id & f.mask); });
            ASSERT_EQ(through, ids.source(id).has_value()) << id;
        }
    }
}

TEST(CanCutter, a_classic_frame_holds_up_to_8_bytes_and_none_is_padded) {
    CanCutter cutter{classic()};
    const auto bus = sent(cutter, support::frame(0xDC, 0xFE, 0x03, data_of(3)));
    ASSERT_EQ(bus.size(), 2u);
    EXPECT_EQ(bus[0].id, 0x6DCu);
    EXPECT_EQ(bus[0].data, (Bytes{0xAB, 0xDC, 0xFE, 0x03, 0x03, 0x00, 0x01, 0x02}));
    EXPECT_EQ(bus[1].id, 0x6DCu);
    EXPECT_EQ(bus[1].data.size(), 3u);
}

TEST(CanCutter, a_frame_begins_a_new_can_frame) {
    CanCutter cutter{classic()};
    const Bytes a = support::frame(1, 2, 3, data_of(1)), b = support::frame(4, 5, 6);
    const std::span<const std::uint8_t> both[] = {a, b};
    const auto pieces = cutter.cut(both);
    ASSERT_EQ(pieces.size(), 3u);
    EXPECT_EQ(pieces[1].bytes.size(), 1u);
    EXPECT_EQ(pieces[2].bytes[0], ano::head);
    EXPECT_EQ(pieces[2].id, 0x604u);
}

TEST(CanCutter, with_fd_the_last_piece_is_padded_to_a_legal_size) {
    CanCutter cutter{with_fd()};
    const Bytes frame = support::frame(1, 2, 3, data_of(64 + 9 - 8));
    const auto bus = sent(cutter, frame);
    ASSERT_EQ(bus.size(), 2u);
    EXPECT_EQ(bus[0].data.size(), 64u);
    EXPECT_EQ(bus[1].data.size(), 12u);
    EXPECT_EQ(Bytes(bus[1].data.begin() + 9, bus[1].data.end()), Bytes(3, 0x00));
}

TEST(CanCutter, the_rest_of_a_frame_keeps_its_id) {
    CanCutter cutter{with_extended()};
    const Bytes a = support::frame(0xFE, 0xDC, 0xC0, data_of(11)), b = support::frame(1, 2, 3);
    std::span<const std::uint8_t> waiting[] = {a, b};
    ASSERT_EQ(cutter.cut(waiting).size(), 4u);
    EXPECT_EQ(cutter.taken(1), 8u);
    waiting[0] = waiting[0].subspan(8);
    const auto pieces = cutter.cut(waiting);
    ASSERT_EQ(pieces.size(), 3u);
    EXPECT_EQ(pieces[0].id, 0x0AB0FEDCu);
    EXPECT_EQ(pieces[2].id, 0x0AB10102u);
    EXPECT_EQ(cutter.taken(3), a.size() - 8 + b.size());
    EXPECT_EQ(cutter.cut({waiting + 1, 1})[0].id, 0x0AB10102u);
}

TEST(CanCutter, the_id_of_an_abandoned_frame_is_not_used_for_the_next_frame) {
    CanCutter cutter{classic()};
    const Bytes a = support::frame(0xFE, 0xDC, 0xC0, data_of(11)), b = support::frame(1, 2, 3);
    const std::span<const std::uint8_t> first[] = {a}, second[] = {b};
    cutter.cut(first);
    cutter.taken(1);
    cutter.reset();
    EXPECT_EQ(cutter.cut(second)[0].id, 0x601u);
}

TEST(CanStreams, padding_is_skipped_uncounted_even_after_a_zero_checksum) {
    CanCutter cutter{with_fd()};
    Receiver receiver{with_fd()};
    std::size_t bytes = 0;
    for (std::size_t size = 0; size < 300; ++size) {
        const Bytes frame = support::frame(7, 8, 3, Bytes(size, 0x00));
        bytes += frame.size();
        receiver(sent(cutter, frame));
        ASSERT_EQ(receiver.frames.size(), size + 1);
        EXPECT_EQ(receiver.frames.back(), frame);
    }
    const ReceiveCounters counters = receiver.streams.received();
    EXPECT_EQ(counters.bytes_in, bytes);
    EXPECT_EQ(counters.skipped_bytes, 0u);
    EXPECT_EQ(counters.frames_in, 300u);
}

TEST(CanStreams, streams_of_different_senders_never_mix) {
    CanCutter cutter{classic()};
    Receiver receiver{classic()};
    std::vector<std::vector<OnBus>> senders;
    for (std::uint8_t s = 1; s <= 20; ++s) senders.push_back(sent(cutter, support::frame(s, 0xFE, 3, data_of(s + 20u))));
    for (std::size_t turn = 0; receiver.frames.size() < 20 && turn < 100; ++turn)
        for (const auto& bus : senders)
            if (turn < bus.size()) receiver(bus[turn]);
    EXPECT_EQ(receiver.frames.size(), 20u);
    EXPECT_EQ(receiver.streams.received().skipped_bytes, 0u);
}

TEST(CanStreams, a_lost_can_frame_damages_only_one_frame) {
    for (std::size_t lost = 0; lost < 4; ++lost) {
        CanCutter cutter{classic()};
        Receiver receiver{classic()};
        const Bytes frame = support::frame(0xDC, 0xFE, 3, data_of(17));
        for (int i = 0; i < 5; ++i) {
            auto bus = sent(cutter, frame);
            ASSERT_EQ(bus.size(), 4u);
            if (i == 2) bus.erase(bus.begin() + static_cast<std::ptrdiff_t>(lost));
            receiver(bus);
        }
        EXPECT_EQ(receiver.frames.size(), 4u) << lost;
    }
}

TEST(CanStreams, a_frame_whose_source_differs_from_its_can_id_is_refused_and_counted) {
    Receiver receiver{classic()};
    const Bytes frame = support::frame(0xDC, 0xFE, 3);
    receiver({0x6DD, frame});
    receiver({0x6DC, frame});
    EXPECT_EQ(receiver.frames.size(), 1u);
    EXPECT_EQ(receiver.streams.wrong_source(), 1u);
    EXPECT_EQ(receiver.streams.received().denied_in, 1u);
}

TEST(CanStreams, noise_with_new_ids_opens_no_stream_and_evicts_none) {
    CanCutter cutter{with_extended()};
    Receiver receiver{with_extended()};
    const auto bus = sent(cutter, support::frame(0xDC, 0xFE, 3, data_of(17)));
    receiver(bus[0]);
    for (std::uint32_t id = 0x0AB00000; id < 0x0AB30000; ++id)
        if (id != bus[0].id) receiver({id, {0x00, 0xAB, 0xAB, 1}});
    EXPECT_EQ(receiver.streams.size(), 1u);
    for (std::size_t i = 1; i < bus.size(); ++i) receiver(bus[i]);
    EXPECT_EQ(receiver.frames.size(), 1u);
    const ReceiveCounters counters = receiver.streams.received();
    EXPECT_EQ(counters.bytes_in, 25u + 4u * 0x2FFFFu);
    EXPECT_EQ(counters.skipped_bytes, 4u * 0x2FFFFu);
}

TEST(CanStreams, the_longest_unused_id_is_evicted) {
    Receiver receiver{with_extended()};
    const Bytes half{0xAB, 1, 2, 3, 4, 0, 0, 0};
    for (std::uint32_t i = 0; i < 1000; ++i) {
        receiver({0x0AB00000 + i, half});
        receiver({0x0AB1DCFE, support::frame(0xDC, 0xFE, 3)});
    }
    EXPECT_EQ(receiver.streams.size(), CanStreams::max_streams);
    EXPECT_EQ(receiver.frames.size(), 1000u);
    const ReceiveCounters counters = receiver.streams.received();
    EXPECT_EQ(counters.expired, 1000u - 255u);
}

TEST(CanStreams, an_id_that_continues_is_not_evicted_as_the_longest_unused) {
    CanCutter cutter{with_extended()};
    Receiver receiver{with_extended()};
    const auto first = sent(cutter, support::frame(1, 1, 0xF1, data_of(17)));
    const auto second = sent(cutter, support::frame(1, 2, 0xF1, data_of(17)));
    receiver(first[0]);
    receiver(second[0]);
    const std::uint32_t others = CanIds::default_extended_base + 0x1000;
    for (std::uint32_t i = 2; i < CanStreams::max_streams; ++i) receiver({others + i, {0xAB, 1, 2, 3, 4, 0, 0, 0}});
    receiver(first[1]);
    receiver({others, {0xAB, 1, 2, 3, 4, 0, 0, 0}});    // one too many
    receiver({first.begin() + 2, first.end()});
    receiver({second.begin() + 1, second.end()});
    EXPECT_EQ(receiver.frames, std::vector<Bytes>{support::frame(1, 1, 0xF1, data_of(17))});
}

TEST(CanStreams, an_id_outside_the_range_opens_no_stream) {
    Receiver receiver{classic()};
    const Bytes frame = support::frame(0xDC, 0xFE, 3);
    receiver({0x5DC, frame});
    receiver({0x7DC, frame});
    EXPECT_EQ(receiver.streams.size(), 0u);
    EXPECT_EQ(receiver.streams.received().skipped_bytes, 2 * frame.size());
}

TEST(CanStreams, an_unfinished_frame_expires_and_the_next_frame_is_returned) {
    Receiver receiver{classic()};
    EXPECT_FALSE(receiver.streams.deadline());
    receiver({0x6DC, {0xAB, 0xDC, 0xFE, 3, 200, 0, 1, 2}});
    receiver({0x6DC, support::frame(0xDC, 0xFE, 4)});
    EXPECT_TRUE(receiver.frames.empty());
    ASSERT_TRUE(receiver.streams.deadline());
    receiver.streams.expire(*receiver.streams.deadline(),
                            [&](ano::FrameView f) { receiver.frames.emplace_back(f.bytes().begin(), f.bytes().end()); });
    EXPECT_EQ(receiver.frames.size(), 1u);
    EXPECT_FALSE(receiver.streams.deadline());
}

TEST(CanStreams, the_deadline_is_the_earliest_of_several_nodes) {
    Receiver receiver{classic()};
    const auto begin = [&](std::uint32_t id, std::uint8_t source) {
        receiver({id, {0xAB, source, 0xFE, 3, 200, 0, 1, 2}});
        receiver({id, support::frame(source, 0xFE, 4)});
    };
    begin(0x6DC, 0xDC);
    const auto first = receiver.streams.deadline();
    ASSERT_TRUE(first);
    receiver.now += std::chrono::milliseconds{10};
    begin(0x6DE, 0xDE);
    EXPECT_EQ(receiver.streams.deadline(), first);
    const auto take = [&](ano::FrameView f) { receiver.frames.emplace_back(f.bytes().begin(), f.bytes().end()); };
    receiver.streams.expire(*first, take);
    EXPECT_EQ(receiver.frames, std::vector<Bytes>{support::frame(0xDC, 0xFE, 4)});
    ASSERT_TRUE(receiver.streams.deadline());
    EXPECT_EQ(*receiver.streams.deadline(), *first + std::chrono::milliseconds{10});
}

}    // namespace
}    // namespace can_stream_tests
