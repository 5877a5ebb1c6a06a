// The outbox against lists of frames kept as simply as can be. After every step nothing is unaccounted for, and what
// has left is a sequence of whole frames and at most the beginning of one.
#include <gateway/outbox.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <map>
#include <optional>

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

using ano::TimePoint;

struct Model {
    struct Frame {
        Bytes bytes;
        Treatment treatment;
        TimePoint at;
        std::uint64_t number;
        std::uint64_t turn;
    };
    using Queues = std::array<std::deque<Frame>, 3>;

    Outbox::Options options;
    bool open = false;
    bool congested = false;
    std::optional<Frame> begun;
    std::size_t partly = 0;
    Queues queues;
    std::array<std::size_t, 2> owed{};
    std::uint64_t pushed = 0;
    SendCounters counters;

    std::size_t frames() const { return queues[0].size() + queues[1].size() + queues[2].size() + begun.has_value(); }
    std::size_t bytes(std::size_t classes = 3) const {
        std::size_t sum = begun ? begun->bytes.size() : 0;
        for (std::size_t c = 0; c < classes; ++c)
            for (const Frame& frame : queues[c]) sum += frame.bytes.size();
        return sum;
    }
    void emptied() {
        if (frames() > 0) return;
        congested = false;
        owed = {};
    }
    static bool same_kind(const Bytes& a, const Bytes& b, Replaces replaces) {
        if (a[1] != b[1] || a[2] != b[2] || a[3] != b[3] || replaces == Replaces::nothing) return false;
        if (replaces == Replaces::same_id) return true;
        return a.size() > ano::overhead && b.size() > ano::overhead && a[6] == b[6];
    }

    void push(const Bytes& frame, Treatment treatment, TimePoint now) {
        ++counters.offered;
        if (!open) return void(++counters.link_down);
        if (frame.size() > ano::overhead + options.max_data) return void(++counters.too_big);
        const auto c = static_cast<std::size_t>(treatment.traffic);
        auto& queue = queues[c];
        Frame incoming{frame, treatment, now, ++pushed, pushed};
        if (congested) {
            for (auto it = queue.rbegin(); it != queue.rend(); ++it) {
                if (!same_kind(it->bytes, frame, treatment.replaces)) continue;
                if (queue.front().number > it->turn && queue.size() > 1) break;
                incoming.turn = it->turn;
                queue.erase(std::next(it).base());
                ++counters.superseded;
                break;
            }
        }
        if (!make_room(frame.size(), c)) return void(++counters.queue_full);
        queue.push_back(std::move(incoming));
    }
    bool make_room(std::size_t size, std::size_t c) {
        const std::size_t tenth = options.bytes / 10;
        const std::size_t partly_out = begun ? begun->bytes.size() : 0;
        if (size > tenth && bytes(c) > partly_out && bytes(c) + size > options.bytes) return false;
        const auto queued = [&](std::size_t from, std::size_t to) { return bytes(to) - bytes(from); };
        while (bytes() + size > options.bytes && bytes() > partly_out) {
            std::size_t loser = 3;
            if (!queues[0].empty() && queued(1, 3) + (c > 0 ? size : 0) <= tenth)
                loser = 0;
            else if (c >= 1 && !queues[1].empty() && queued(2, 3) + (c > 1 ? size : 0) <= tenth)
                loser = 1;
            else
                loser = !queues[2].empty() ? 2 : !queues[1].empty() ? 1 : 0;
            queues[loser].pop_front();
            ++counters.queue_full;
        }
        return true;
    }
    void drop_stale(TimePoint now, std::size_t c) {
        const AgeLimits& age = options.age;
        while (!queues[c].empty()) {
            const Frame& frame = queues[c].front();
            const auto limit = frame.treatment.age == AgeKind::control     ? age.control
                               : frame.treatment.age == AgeKind::telemetry ? age.telemetry
                                                                           : age.rest;
            if (now - frame.at < limit) return;
            queues[c].pop_front();
            ++counters.stale;
        }
    }
    // The class whose turn it is among `waiting`, and what that does to the debts.
    static std::size_t next(const Queues& waiting, std::array<std::size_t, 2>& debts) {
        const auto size = [&](std::size_t c) { return waiting[c].front().bytes.size(); };
        std::size_t lower = !waiting[1].empty() ? 1 : 2;
        if (!waiting[1].empty() && !waiting[2].empty() && debts[1] >= 9 * size(2)) lower = 2;
        const bool lower_waits = !waiting[lower].empty();
        std::size_t chosen = lower;
        if (!waiting[0].empty() && !(lower_waits && debts[0] >= 9 * size(lower))) chosen = 0;
        const auto pay = [&](std::size_t& debt) { debt -= std::min(debt, 9 * size(chosen)); };
        if (chosen == 0)
            debts[0] = lower_waits ? debts[0] + size(0) : 0;
        else
            pay(debts[0]);
        if (chosen == 1) debts[1] = waiting[2].empty() ? 0 : debts[1] + size(1);
        if (chosen == 2) pay(debts[1]);
        return chosen;
    }
    Frame take() {
        const std::size_t c = next(queues, owed);
        Frame frame = std::move(queues[c].front());
        queues[c].pop_front();
        return frame;
    }
    void left(const Frame& frame) {
        ++counters.frames_out;
        counters.bytes_out += frame.bytes.size();
        counters.empty_out += frame.bytes.size() == ano::overhead;
        emptied();
    }
    void close() {
        open = false;
        counters.link_down += frames();
        begun.reset();
        partly = 0;
        queues = {};
        emptied();
    }
};

constexpr Treatment treatments[] = {
    {TrafficClass::urgent, Replaces::nothing, AgeKind::rest},
    {TrafficClass::urgent, Replaces::same_id, AgeKind::control},
    {TrafficClass::telemetry, Replaces::same_id, AgeKind::telemetry},
    {TrafficClass::telemetry, Replaces::same_first_byte, AgeKind::telemetry},
    {TrafficClass::telemetry, Replaces::nothing, AgeKind::telemetry},
    {TrafficClass::bulk, Replaces::nothing, AgeKind::rest},
};

struct Trial {
    Trial(std::uint64_t seed, const Outbox::Options& options) : random{seed}, outbox{options} {
        model.options = options;
        model.open = true;
        outbox.open();
    }

    void step() {
        switch (random.below(9u)) {
            case 0:
            case 1:
            case 2: push(); break;
            case 3:
            case 4: send_part(); break;
            case 5: send_datagrams(); break;
            case 6:
                for (unsigned n = random.below(20u); n > 0; --n) push();
                break;
            case 7: now += random.of<ano::Duration>({0ms, 5ms, 90ms, 700ms}); break;
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
        for (auto& byte : data) byte = random.below<std::uint8_t>(3);
        const std::uint8_t id = random.below<std::uint8_t>(std::size(treatments));
        const Bytes frame = support::frame(random.below<std::uint8_t>(2), random.below<std::uint8_t>(2), id, data);
        const auto before = support::allocations;
        outbox.push(ano::FrameView{frame}, treatments[id], now);
        EXPECT_EQ(support::allocations, before);
        model.push(frame, treatments[id], now);
    }
    // Takes a part of what gather() gives, of any length.
    void send_part() {
        const auto given = gather();
        std::size_t total = 0;
        for (const auto& piece : given) total += piece.size();
        const std::size_t taken = random.below(total + 1);
        outbox.sent(taken);
        for (std::size_t rest = taken; rest > 0;) {
            if (!model.begun) model.begun = model.take();
            const std::size_t n = std::min(rest, model.begun->bytes.size() - model.partly);
            rest -= n;
            model.partly += n;
            if (model.partly < model.begun->bytes.size()) break;
            const Model::Frame whole = *model.begun;
            model.begun.reset();
            model.partly = 0;
            left(whole);
        }
        if (random.one_in(2)) {
            outbox.set_congested();
            model.congested = model.frames() > 0;
        }
    }
    void send_datagrams() {
        if (model.begun) return;
        for (std::size_t n = random.below(gather().size() + 1); n > 0; --n) {
            const Model::Frame frame = model.take();
            if (random.one_in(5)) {
                outbox.drop_frame(&SendCounters::send_failed);
                ++model.counters.send_failed;
                model.emptied();
            } else {
                outbox.sent_frame();
                left(frame);
            }
        }
    }
    void left(const Model::Frame& frame) {
        model.left(frame);
        auto& last = last_out[{frame.bytes[1], frame.bytes[2], frame.treatment.traffic}];
        EXPECT_GT(frame.number, last) << "order within source, destination and class";
        last = frame.number;
    }
    std::span<std::span<const std::uint8_t>> gather() {
        const std::size_t budget = random.one_in(2) ? SIZE_MAX : random.below(200u);
        const std::size_t room = 1 + random.below(pieces.size());
        const auto before = support::allocations;
        const std::size_t count = outbox.gather(std::span{pieces}.first(room), now, budget);
        EXPECT_EQ(support::allocations, before);

        std::size_t i = 0;
        std::size_t total = 0;
        const auto expect_piece = [&](const Bytes& frame, std::size_t from) {
            if (i >= count) return void(ADD_FAILURE() << "a piece is missing");
            EXPECT_TRUE(std::equal(pieces[i].begin(), pieces[i].end(),
                                   frame.begin() + static_cast<std::ptrdiff_t>(from), frame.end()))
                << "piece " << i;
            total += frame.size() - from;
            ++i;
        };
        if (model.begun) expect_piece(model.begun->bytes, model.partly);
        auto debts = model.owed;
        Model plan = model;
        while (i < room) {
            for (std::size_t c = 0; c < 3; ++c) {
                const auto before_stale = plan.counters.stale;
                plan.drop_stale(now, c);
                // What is stale at the front of what remains is stale for good.
                model.counters.stale += plan.counters.stale - before_stale;
                for (auto n = plan.counters.stale - before_stale; n > 0; --n) {
                    auto& queue = model.queues[c];
                    queue.erase(queue.end() - static_cast<std::ptrdiff_t>(plan.queues[c].size() + n));
                }
            }
            model.emptied();
            if (plan.queues[0].empty() && plan.queues[1].empty() && plan.queues[2].empty()) break;
            const std::size_t c = Model::next(plan.queues, debts);
            if (total + plan.queues[c].front().bytes.size() > budget) break;
            expect_piece(plan.queues[c].front().bytes, 0);
            plan.queues[c].pop_front();
        }
        EXPECT_EQ(count, i);
        return std::span{pieces}.first(std::min(count, i));
    }
    void check() {
        EXPECT_EQ(unaccounted(outbox.counters()), outbox.waiting());
        EXPECT_EQ(outbox.waiting(), model.frames());
        EXPECT_EQ(outbox.waiting_bytes(), model.bytes());
        EXPECT_EQ(outbox.is_open(), model.open);
        EXPECT_EQ(outbox.congested(), model.congested);
        EXPECT_EQ(outbox.counters().offered, model.counters.offered);
        for (const auto& row : send_counters)
            EXPECT_EQ(outbox.counters().*row.value, model.counters.*row.value) << row.name;
    }

    support::Random random;
    Outbox outbox;
    Model model;
    TimePoint now{};
    std::array<std::span<const std::uint8_t>, 32> pieces;
    std::map<std::tuple<std::uint8_t, std::uint8_t, TrafficClass>, std::uint64_t> last_out;
};

}    // namespace

TEST(Outbox, does_as_the_simple_one_does) {
    const Outbox::Options options[] = {
        {.bytes = 28, .max_data = 20}, {.bytes = 100, .max_data = 60}, {.bytes = 5000, .max_data = 200}};
    std::uint64_t causes = 0;
    for (std::uint64_t seed = 1; seed <= 300 && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        Trial trial{seed, options[seed % std::size(options)]};
        for (int step = 0; step < 400 && !testing::Test::HasFailure(); ++step) trial.step();
        for (std::size_t r = 0; r < std::size(send_counters); ++r)
            causes |= std::uint64_t{trial.outbox.counters().*send_counters[r].value > 0} << r;
    }
    for (std::size_t r = 0; r < std::size(send_counters); ++r) {
        const auto name = send_counters[r].name;
        if (name == "limited" || name == "denied_out" || name == "held_back") continue;    // not of what is offered here
        EXPECT_TRUE(causes >> r & 1) << name << " never came up";
    }
}
