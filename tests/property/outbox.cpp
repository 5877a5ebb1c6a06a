// The outbox compared with lists of frames in the simplest form. After every step every frame is accounted for, and the sent
// bytes are a sequence of whole frames and at most the beginning of one.
#include <gateway/outbox.hpp>

#include <support/allocations.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <map>
#include <optional>
#include <vector>

namespace outbox_tests {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;

namespace {

using ano::TimePoint;

struct Frame {
    ChannelId from;
    Bytes bytes;
    QueuePolicy policy;
    TimePoint at;
    std::uint64_t number;
    std::uint64_t turn;
};

template <class Frames>
std::size_t bytes_of(const Frames& frames) {
    std::size_t sum = 0;
    for (const Frame& frame : frames) sum += frame.bytes.size();
    return sum;
}

// Elements in the order of their turns, cyclically; the first is next.
template <class Member>
std::size_t longest(const std::vector<Member>& ring) {
    std::size_t most = 0;
    for (std::size_t i = 1; i < ring.size(); ++i)
        if (ring[i].bytes() > ring[most].bytes()) most = i;
    return most;
}

struct Sender {
    std::uint8_t source;
    long balance;
    std::deque<Frame> sticks, rest;
    bool overtook = false;

    std::size_t bytes() const { return bytes_of(sticks) + bytes_of(rest); }
    std::deque<Frame>& line(const QueuePolicy& policy) { return policy.age == AgeKind::control ? sticks : rest; }
    std::deque<Frame>& next() { return sticks.empty() || (overtook && !rest.empty()) ? rest : sticks; }
    std::deque<Frame>& oldest() {
        return rest.empty() || (!sticks.empty() && sticks.front().number < rest.front().number) ? sticks : rest;
    }
};

struct Place {
    ChannelId from;
    long balance;
    std::vector<Sender> senders;

    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Sender& sender : senders) sum += sender.bytes();
        return sum;
    }
};

struct ClassQueue {
    long quantum;
    std::vector<Place> places;
    bool shared = false;

    std::size_t bytes() const {
        std::size_t sum = 0;
        for (const Place& place : places) sum += place.bytes();
        return sum;
    }
    std::size_t count() const {
        std::size_t sum = 0;
        for (const Place& place : places)
            for (const Sender& sender : place.senders) sum += sender.sticks.size() + sender.rest.size();
        return sum;
    }
    Sender* find(ChannelId from, std::uint8_t source) {
        for (Place& place : places)
            for (Sender& sender : place.senders)
                if (place.from == from && sender.source == source) return &sender;
        return nullptr;
    }
    void push(Frame frame) {
        const ChannelId from = frame.from;
        const std::uint8_t source = frame.bytes[1];
        if (!find(from, source)) {
            shared = !places.empty();
            auto place = std::find_if(places.begin(), places.end(), [&](const Place& p) { return p.from == from; });
            if (place == places.end()) place = places.insert(places.begin(), Place{from, quantum, {}});
            place->senders.push_back({source, quantum, {}, {}});
        }
        find(from, source)->line(frame.policy).push_back(std::move(frame));
    }
    template <class Member>
    Member& in_turn(std::vector<Member>& ring) {
        for (;;) {
            Member& first = ring.front();
            if (first.balance > 0 && first.bytes() > 0) return first;
            const bool stays = first.balance <= 0;
            if (stays) {
                first.balance += quantum;
                std::rotate(ring.begin(), ring.begin() + 1, ring.end());
            } else {
                ring.erase(ring.begin());
            }
        }
    }
    Sender& sender_in_turn() { return in_turn(in_turn(places).senders); }
    const Frame* next() { return bytes() > 0 ? &sender_in_turn().next().front() : nullptr; }
    Frame take() {
        Sender& sender = sender_in_turn();
        auto& line = sender.next();
        sender.overtook = &line == &sender.sticks && !sender.rest.empty();
        Frame frame = std::move(line.front());
        line.pop_front();
        if (shared) {
            sender.balance -= static_cast<long>(frame.bytes.size());
            places.front().balance -= static_cast<long>(frame.bytes.size());
        }
        tidy();
        return frame;
    }
    // A sender with nothing waiting has no turn; a channel keeps its turn.
    void tidy() {
        for (Place& place : places) std::erase_if(place.senders, [](const Sender& s) { return s.bytes() == 0; });
        if (bytes() > 0) return;
        places.clear();
        shared = false;
    }
    // Removes the frame with this number.
    void erase(std::uint64_t number) {
        for (Place& place : places)
            for (Sender& sender : place.senders)
                for (auto* line : {&sender.sticks, &sender.rest})
                    std::erase_if(*line, [&](const Frame& f) { return f.number == number; });
        tidy();
    }
    std::uint64_t next_evicted() {
        Place& place = places[longest(places)];
        return place.senders[longest(place.senders)].oldest().front().number;
    }
};

struct Model {
    using Queues = std::array<ClassQueue, 3>;

    Outbox::Options options;
    bool open = false;
    bool congested = false;
    std::optional<Frame> begun;
    std::size_t partly = 0;
    Queues queues{{{8, {}}, {32, {}}, {256, {}}}};
    std::array<std::size_t, 3> due{};
    std::uint64_t pushed = 0;
    SendCounters counters;

    std::size_t frames() const { return queues[0].count() + queues[1].count() + queues[2].count() + begun.has_value(); }
    std::size_t bytes(std::size_t classes = 3) const {
        std::size_t sum = begun ? begun->bytes.size() : 0;
        for (std::size_t c = 0; c < classes; ++c) sum += queues[c].bytes();
        return sum;
    }
    void emptied(bool by_leaving) {
        if (frames() > 0) return;
        congested = false;
        if (by_leaving) due = {};
    }
    static bool same_kind(const Bytes& a, const Bytes& b, Replaces replaces) {
        if (a[1] != b[1] || a[2] != b[2] || a[3] != b[3] || replaces == Replaces::nothing) return false;
        if (replaces == Replaces::same_id) return true;
        return a.size() > ano::overhead && b.size() > ano::overhead && a[6] == b[6];
    }

    void push(const Bytes& frame, QueuePolicy policy, TimePoint now, ChannelId from) {
        ++counters.offered;
        if (!open) return void(++counters.link_down);
        if (frame.size() > ano::overhead + options.max_data) return void(++counters.too_big);
        const auto c = static_cast<std::size_t>(policy.traffic);
        Frame incoming{from, frame, policy, now, ++pushed, pushed};
        if (Sender* sender = queues[c].find(from, frame[1]); sender && congested) {
            const auto& line = sender->line(policy);
            for (auto it = line.rbegin(); it != line.rend(); ++it) {
                if (!same_kind(it->bytes, frame, policy.replaces)) continue;
                if (line.front().number > it->turn && line.size() > 1) break;
                incoming.turn = it->turn;
                queues[c].erase(it->number);
                ++counters.superseded;
                break;
            }
        }
        if (!make_room(frame.size(), c)) return void(++counters.queue_full);
        queues[c].push(std::move(incoming));
    }
    void set_congested() {
        if (std::exchange(congested, frames() > 0) || !congested) return;
        for (ClassQueue& queue : queues)
            for (Place& place : queue.places)
                for (Sender& sender : place.senders) supersede(sender.sticks);
    }
    void supersede(std::deque<Frame>& sticks) {
        for (std::size_t i = 0; i < sticks.size();) {
            const Frame older = sticks[i];
            const auto newer = std::find_if(
                sticks.begin() + static_cast<std::ptrdiff_t>(i) + 1, sticks.end(),
                [&](const Frame& f) { return same_kind(f.bytes, older.bytes, older.policy.replaces); });
            if (newer == sticks.end()) {
                ++i;
                continue;
            }
            newer->turn = std::min(newer->turn, older.turn);
            sticks.erase(sticks.begin() + static_cast<std::ptrdiff_t>(i));
            ++counters.superseded;
        }
    }
    bool make_room(std::size_t size, std::size_t c) {
        const std::size_t tenth = options.bytes / 10, quarter = options.bytes / 4;
        const std::size_t partly_out = begun ? begun->bytes.size() : 0;
        if (bytes() + size <= options.bytes) return true;
        const bool entitled = queues[c].bytes() + size <= (queues[c].count() == 0 ? quarter : tenth);
        if (!entitled && bytes(c) > partly_out && bytes(c) + size > options.bytes) return false;
        while (bytes() + size > options.bytes && bytes() > partly_out) {
            std::optional<std::size_t> loser, lowest;
            for (std::size_t k = 0; k < 3; ++k) {
                if (queues[k].count() == 0) continue;
                lowest = k;
                const bool has_more = queues[k].bytes() > (queues[k].count() == 1 ? quarter : tenth);
                if (k == c ? !entitled : has_more && (entitled || k > c)) loser = k;
            }
            auto& queue = queues[loser.value_or(lowest.value_or(0))];
            queue.erase(queue.next_evicted());
            ++counters.queue_full;
        }
        return true;
    }
    bool stale(const Frame& frame, TimePoint now) const {
        const AgeLimits& age = options.age;
        const auto limit = frame.policy.age == AgeKind::control     ? age.control
                           : frame.policy.age == AgeKind::telemetry ? age.telemetry
                                                                    : age.rest;
        return now - frame.at >= limit;
    }
    // Drops the next frames that are stale, and returns their numbers.
    std::vector<std::uint64_t> drop_stale(TimePoint now, std::size_t c) {
        std::vector<std::uint64_t> dropped;
        while (const Frame* next = queues[c].next()) {
            if (!stale(*next, now)) break;
            dropped.push_back(next->number);
            queues[c].erase(dropped.back());
        }
        return dropped;
    }
    // The class whose turn it is; 3: none.
    std::size_t next() {
        std::array<std::size_t, 3> sizes{};
        for (std::size_t c = 0; c < 3; ++c)
            if (const Frame* frame = queues[c].next()) sizes[c] = frame->bytes.size();
        const std::size_t highest = sizes[0] ? 0 : sizes[1] ? 1 : sizes[2] ? 2 : 3;
        for (std::size_t c = highest + 1; c < 3; ++c)
            if (sizes[c] && due[c] >= 9 * sizes[c]) return c;
        return highest;
    }
    Frame take() {
        const std::size_t c = next();
        Frame frame = queues[c].take();
        const std::size_t size = frame.bytes.size();
        due[c] -= std::min(due[c], 9 * size);
        for (std::size_t other = 0; other < 3; ++other)
            if (other != c && queues[other].count() > 0) due[other] += size;
        return frame;
    }
    void left(const Frame& frame) {
        ++counters.frames_out;
        counters.bytes_out += frame.bytes.size();
        counters.empty_out += frame.bytes.size() == ano::overhead;
        emptied(true);
    }
    void close() {
        open = false;
        counters.link_down += frames();
        begun.reset();
        partly = 0;
        for (ClassQueue& queue : queues) queue = {queue.quantum, {}};
        emptied(true);
    }
};

constexpr QueuePolicy policies[] = {
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
        const std::uint8_t id = random.below<std::uint8_t>(std::size(policies));
        const Bytes frame = support::frame(random.below<std::uint8_t>(2), random.below<std::uint8_t>(2), id, data);
        const ChannelId from = random.one_in(4) ? ourselves : static_cast<ChannelId>(random.below<std::uint8_t>(4));
        const auto before = support::allocations;
        outbox.push(ano::FrameView{frame}, policies[id], now, from);
        EXPECT_EQ(support::allocations, before);
        model.push(frame, policies[id], now, from);
    }
    // Sends a part, of any length, of the bytes from gather().
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
            const Frame whole = *model.begun;
            model.begun.reset();
            model.partly = 0;
            left(whole);
        }
        if (random.one_in(2)) {
            outbox.set_congested();
            model.set_congested();
        }
    }
    void send_datagrams() {
        if (model.begun) return;
        for (std::size_t n = random.below(gather().size() + 1); n > 0; --n) {
            const Frame frame = model.take();
            if (random.one_in(5)) {
                outbox.drop_frame(&SendCounters::send_failed);
                ++model.counters.send_failed;
                model.emptied(true);
            } else {
                outbox.sent_frame();
                left(frame);
            }
        }
    }
    void left(const Frame& frame) {
        model.left(frame);
        auto& last = last_out[{frame.from, frame.bytes[1], frame.policy.traffic, frame.policy.age == AgeKind::control}];
        EXPECT_GT(frame.number, last) << "order within channel, source and class, but for sticks";
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
            EXPECT_TRUE(
                std::equal(pieces[i].begin(), pieces[i].end(), frame.begin() + static_cast<std::ptrdiff_t>(from), frame.end()))
                << "piece " << i;
            total += frame.size() - from;
            ++i;
        };
        if (model.begun) expect_piece(model.begun->bytes, model.partly);
        Model plan = model;
        while (i < room) {
            for (std::size_t c = 0; c < 3; ++c)
                for (const auto number : plan.drop_stale(now, c)) {
                    model.queues[c].erase(number);
                    ++model.counters.stale;
                }
            model.emptied(false);
            const std::size_t c = plan.next();
            if (c == 3) break;
            if (total + plan.queues[c].next()->bytes.size() > budget) break;
            expect_piece(plan.take().bytes, 0);
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
        for (const auto& row : send_counters) EXPECT_EQ(outbox.counters().*row.value, model.counters.*row.value) << row.name;
    }

    support::Random random;
    Outbox outbox;
    Model model;
    TimePoint now{};
    std::array<std::span<const std::uint8_t>, 32> pieces;
    std::map<std::tuple<ChannelId, std::uint8_t, TrafficClass, bool>, std::uint64_t> last_out;
};

TEST(Outbox, behaves_like_the_simple_reference_implementation) {
    const Outbox::Options options[] = {
        {.bytes = 28, .max_data = 20}, {.bytes = 100, .max_data = 60}, {.bytes = 5000, .max_data = 200}};
    std::uint64_t causes = 0;
    for (std::uint64_t seed = 1; seed <= support::trials(120) && !testing::Test::HasFailure(); ++seed) {
        SCOPED_TRACE(testing::Message() << "seed " << seed);
        Trial trial{seed, options[seed % std::size(options)]};
        for (int step = 0; step < 400 && !testing::Test::HasFailure(); ++step) trial.step();
        for (std::size_t r = 0; r < std::size(send_counters); ++r)
            causes |= std::uint64_t{trial.outbox.counters().*send_counters[r].value > 0} << r;
    }
    for (std::size_t r = 0; r < std::size(send_counters); ++r) {
        const auto name = send_counters[r].name;
        if (name == "limited" || name == "denied_out" || name == "held_back" || name == "flush_bytes")
            continue;    // does not count offered frames
        EXPECT_TRUE(causes >> r & 1) << name << " never came up";
    }
}

}    // namespace
}    // namespace outbox_tests
