// The outbox against a list of frames kept as simply as can be. After every step nothing is unaccounted for, and what
// has left is a sequence of whole frames and at most the beginning of one.
#include <gateway/outbox.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <array>
#include <deque>

using namespace anogate;
using support::Bytes;

namespace {

struct Model {
    Outbox::Options options;
    bool open = false;
    std::deque<Bytes> waiting;
    std::size_t begun = 0;    // bytes of the first that have left
    SendCounters counters;

    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Bytes& frame : waiting) sum += frame.size();
        return sum;
    }
    void push(const Bytes& frame) {
        ++counters.offered;
        if (!open) {
            ++counters.link_down;
        } else if (frame.size() > ano::overhead + options.max_data) {
            ++counters.too_big;
        } else {
            const std::ptrdiff_t kept = begun > 0 ? 1 : 0;
            while (bytes() + frame.size() > options.bytes && waiting.size() > static_cast<std::size_t>(kept)) {
                waiting.erase(waiting.begin() + kept);
                ++counters.queue_full;
            }
            waiting.push_back(frame);
        }
    }
    void left() {
        ++counters.frames_out;
        counters.bytes_out += waiting.front().size();
        counters.empty_out += waiting.front().size() == ano::overhead;
        waiting.pop_front();
        begun = 0;
    }
    void close() {
        open = false;
        counters.link_down += waiting.size();
        waiting.clear();
        begun = 0;
    }
};

struct Trial {
    Trial(std::uint64_t seed, const Outbox::Options& options)
        : random{seed}, outbox{options}, model{.options = options, .waiting = {}, .counters = {}} {}

    void step() {
        switch (random.below(8u)) {
            case 0:
            case 1:
            case 2: push(); break;
            case 3:
            case 4: send_part(); break;
            case 5: send_datagrams(); break;
            case 6:
                for (unsigned n = random.below(20u); n > 0; --n) push();
                break;
            default:
                if (!random.one_in(8)) break;
                model.open ? (outbox.close(), model.close()) : (outbox.open(), void(model.open = true));
        }
        check();
    }

    void push() {
        const std::size_t most = model.options.max_data;
        const std::size_t size = random.one_in(20)   ? most + 1
                                 : random.one_in(10) ? most
                                                     : random.below(std::min<std::size_t>(most, 40));
        Bytes data(size);
        for (auto& byte : data) byte = random.byte();
        const Bytes frame = support::frame(random.byte(), random.byte(), random.byte(), data);
        const auto before = support::allocations;
        outbox.push(ano::FrameView{frame});
        EXPECT_EQ(support::allocations, before);
        model.push(frame);
    }
    // Takes a part of what gather() gives, of any length.
    void send_part() {
        const std::size_t count = gather();
        std::size_t given = 0;
        for (std::size_t i = 0; i < count; ++i) given += pieces[i].size();
        const std::size_t taken = random.below(given + 1);
        std::size_t rest = taken;
        for (std::size_t i = 0; i < count && rest > 0; ++i) {
            const std::size_t n = std::min(rest, pieces[i].size());
            rest -= n;
            model.begun += n;
            if (model.begun == model.waiting.front().size()) model.left();
        }
        outbox.sent(taken);
    }
    void send_datagrams() {
        if (model.begun > 0) return;
        for (std::size_t n = random.below(gather() + 1); n > 0; --n) {
            if (random.one_in(5)) {
                outbox.drop_frame(&SendCounters::send_failed);
                ++model.counters.send_failed;
                model.waiting.pop_front();
            } else {
                outbox.sent_frame();
                model.left();
            }
        }
    }
    std::size_t gather() {
        const std::size_t count = outbox.gather(std::span{pieces}.first(1 + random.below(pieces.size())));
        for (std::size_t i = 0; i < count; ++i) {
            const auto expected = std::span{model.waiting[i]}.subspan(i == 0 ? model.begun : 0);
            EXPECT_TRUE(std::equal(pieces[i].begin(), pieces[i].end(), expected.begin(), expected.end()))
                << "piece " << i;
        }
        return count;
    }
    void check() {
        EXPECT_EQ(unaccounted(outbox.counters()), outbox.waiting());
        EXPECT_EQ(outbox.waiting(), model.waiting.size());
        EXPECT_EQ(outbox.waiting_bytes(), model.bytes());
        EXPECT_EQ(outbox.is_open(), model.open);
        EXPECT_EQ(outbox.empty(), model.waiting.empty());
        EXPECT_EQ(outbox.counters().offered, model.counters.offered);
        for (const auto& row : send_counters)
            EXPECT_EQ(outbox.counters().*row.value, model.counters.*row.value) << row.name;
    }

    support::Random random;
    Outbox outbox;
    Model model;
    std::array<std::span<const std::uint8_t>, 32> pieces;
};

}    // namespace

TEST(Outbox, does_as_the_simple_one_does) {
    const Outbox::Options options[] = {
        {.bytes = 28, .max_data = 20}, {.bytes = 100, .max_data = 60}, {.bytes = 5000, .max_data = 200}};
    for (std::uint64_t seed = 1; seed <= 150 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        Trial trial{seed, options[seed % std::size(options)]};
        for (int step = 0; step < 500 && !testing::Test::HasFailure(); ++step) trial.step();
    }
}
