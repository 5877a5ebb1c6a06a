// Properties of wrapping and unwrapping with random frames, and the seeds of the fuzz target with many mutations.
#include <support/bytes.hpp>
#include <support/files.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <fuzz/unwrap.cpp>

namespace tunnel_tests {

namespace {

using support::Bytes;
using support::Random;

Bytes random_frame(Random& random, std::size_t most) {
    Bytes data(random.below(most + 1));
    for (auto& byte : data) byte = random.one_in(4) ? ano::head : random.byte();
    const std::uint8_t id = random.one_in(3) ? random.of<std::uint8_t>({ip_tunnel, ip_tunnel_short}) : random.byte();
    return support::frame(random.byte(), random.byte(), id, data);
}

TEST(Tunnel, wraps_frames_into_parts_that_fit_and_unwraps_them_unchanged) {
    for (std::uint64_t seed = 0; seed < support::trials(3000); ++seed) {
        Random random{seed};
        TunnelSettings settings;
        auto& rule = settings.wrap.emplace_back();
        rule.from = {sender, 32};
        rule.id = random.of<std::uint8_t>({ip_tunnel, ip_tunnel_short});
        rule.source = random.byte();
        rule.to = random.byte();
        Tunnel tunnel{settings, 0, {[](const IpAddress&) { return std::optional{us}; }, [](std::uint16_t) { return false; }}};
        const std::size_t max_data = 60 + random.below(400u);
        const std::size_t room = max_data - tunnel_head_size(rule.id);
        const auto port = static_cast<std::uint16_t>(random.below(65536));

        std::vector<Bytes> frames, expected, got;
        for (unsigned i = random.below(30u); i > 0; --i) frames.push_back(random_frame(random, 120));
        for (const Bytes& f : frames)
            if (f.size() <= room) expected.push_back(f);
        const Tunnel::OnFrame on_frame = [&](ano::FrameView f) {
            ASSERT_TRUE(ano::frame_at(f.bytes(), max_data)) << "whole, good, and within max_data";
            ASSERT_EQ(f.source(), rule.source);
            ASSERT_EQ(f.destination(), rule.to);
            const auto content = unwrap(f, sender);
            ASSERT_EQ(content->head, (TunnelHead{sender, us, port}));
            InnerFrames inner{content->inner};
            while (const auto one = inner.next()) got.emplace_back(one->bytes().begin(), one->bytes().end());
            ASSERT_TRUE(inner.good());
        };
        ASSERT_TRUE(tunnel.begin_wrap(0, max_data, {sender, port}));
        for (const Bytes& f : frames) tunnel.add_to_wrap(*ano::frame_at(f), on_frame);
        tunnel.end_wrap(on_frame);
        ASSERT_EQ(got, expected) << "seed " << seed;
        ASSERT_EQ(tunnel.counters().tunnel_too_big, frames.size() - expected.size()) << "seed " << seed;
    }
}

TEST(Tunnel, never_unwraps_a_frame_twice) {
    for (std::uint64_t seed = 0; seed < support::trials(2000); ++seed) {
        Random random{seed};
        Bytes inner = random_frame(random, 20), outer = inner;
        for (unsigned depth = 2 + random.below(20u); depth > 0; --depth) {
            inner = outer;
            const bool whole = random.one_in(2) || depth == 1;
            Bytes head = whole ? Bytes{1, 2, 3, 4, 192, 168, 0, 5, 0, 0} : Bytes{1, 5, 0, 0};
            head.insert(head.end(), inner.begin(), inner.end());
            outer = support::frame(0xDC, random.byte(), whole ? ip_tunnel : ip_tunnel_short, head);
        }
        Tunnel tunnel = make_tunnel(Deliver::frames);
        std::vector<Bytes> got;
        tunnel.in(*ano::frame_at(outer), sender, [&](ano::FrameView f) { got.emplace_back(f.bytes().begin(), f.bytes().end()); });
        ASSERT_EQ(got, std::vector<Bytes>{inner}) << "seed " << seed;
        ASSERT_EQ(tunnel.counters().unwrapped, 1u);
    }
}

TEST(UnwrapCorpus, keeps_all_invariants) {
    std::size_t seeds = 0;
    for (const auto& entry : std::filesystem::directory_iterator{support::source_file("tests/fuzz/corpus/unwrap")}) {
        const std::string text = support::file_text(entry.path());
        const Bytes seed{text.begin(), text.end()};
        LLVMFuzzerTestOneInput(seed.data(), seed.size());
        Random random{++seeds};
        for (std::uint64_t i = 0; i < support::trials(seed.size() > 1000 ? 20 : 2000); ++i) {
            Bytes changed = seed;
            for (unsigned n = 1 + random.below(3u); n > 0 && !changed.empty(); --n) {
                const std::size_t at = random.below(changed.size());
                if (random.one_in(3)) changed.resize(at);
                else changed[at] = random.one_in(3) ? ano::head : random.byte();
            }
            LLVMFuzzerTestOneInput(changed.data(), changed.size());
        }
    }
    EXPECT_GE(seeds, 19u);
}

}    // namespace
}    // namespace tunnel_tests
