// The device's side of the protocol, only as complete as tests need it, and the line to it in simulated time.
#pragma once
#include <ano/typed.hpp>
#include <ano/values.hpp>
#include <ano/wire.hpp>
#include <host/task.hpp>
#include <support/bytes.hpp>
#include <support/random.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace support {

using namespace std::chrono_literals;
using ano::Duration;
using ano::TimePoint;

/// Answers as specified in the protocol text. A question or a write at or beyond the count of parameters crashes it, like vendor
/// firmware.
class FakeDevice {
public:
    struct Parameter {
        std::uint8_t type;
        std::string name, info;
        Bytes value;
        std::function<Bytes(Bytes)> store = nullptr;    // the value that it stores for a written one; null: the same
        std::int32_t min = -10, max = 100, mul = 0;     // for an older device
    };
    struct Command {
        std::array<std::uint8_t, 3> cid;
        Bytes types;
        std::string name, info;
    };

    std::uint8_t address = 0xDC;
    std::optional<std::uint8_t> port{};    // a second address at which it receives
    std::string name = "fake";
    std::uint16_t version = 100, hardware = 100;
    std::vector<Parameter> parameters;
    std::optional<std::uint16_t> reported_count;    // the count that it reports; std::nullopt: the true one
    std::vector<Command> commands;
    std::vector<Bytes> waypoints;
    bool old = false;       // describes parameters by min and max; every value is an i32
    bool scaled = false;    // describes parameters by min, max and mul
    bool crashed = false;
    bool deaf = false;
    std::vector<Bytes> heard;                                                    // all received frames
    std::function<std::optional<std::vector<Bytes>>(ano::FrameView)> instead;    // std::nullopt: the usual answers

    /// Appends n parameters of all numeric types in rotation, each with `text` bytes of information after its name.
    void make_parameters(std::size_t n, std::size_t text = 30) {
        for (std::size_t i = 0; i < n; ++i) {
            const auto type = static_cast<std::uint8_t>(i % 10);
            Bytes value;
            while (value.size() < ano::width(*ano::parameter_type(type)))
                value.push_back(static_cast<std::uint8_t>(i + value.size()));
            parameters.push_back({type, "PAR_" + std::to_string(i), std::string(text, 'x'), value});
        }
    }

    /// The answers to a frame, in order.
    std::vector<Bytes> take(ano::FrameView frame) {
        if (frame.destination() != address && frame.destination() != 0xFF && frame.destination() != port) return {};
        heard.emplace_back(frame.bytes().begin(), frame.bytes().end());
        if (crashed || deaf) return {};
        if (instead)
            if (auto answers = instead(frame)) return *answers;
        return usual(frame);
    }

    std::vector<Bytes> usual(ano::FrameView frame) {
        switch (frame.id()) {
        case 0x60: return waypoint_asked(frame);
        case 0x61: return waypoint_written(frame);
        case 0xC0: return called(frame);
        case 0xC1: return command_asked(frame);
        case 0xE0: return asked(frame);
        case 0xE1: return written(frame);
        default: return {};
        }
    }

    Bytes to_host(ano::FrameView frame, std::uint8_t id, const Bytes& data) const {
        return support::frame(address, frame.source(), id, data);
    }
    Bytes check(ano::FrameView frame) const { return to_host(frame, 0x00, {frame.id(), frame.checks().sum, frame.checks().add}); }

private:
    static std::uint16_t number(ano::FrameView frame, std::size_t at) {
        return ano::load<std::uint16_t>(frame.data().data() + at);
    }
    static Bytes u16(std::size_t n) { return {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)}; }
    static Bytes i32(std::int32_t n) {
        Bytes bytes(4);
        ano::store(bytes.data(), n);
        return bytes;
    }
    static Bytes text(const std::string& text, std::size_t size = 0) {
        Bytes bytes(text.begin(), text.end());
        if (size != 0) bytes.resize(size);
        return bytes;
    }

    std::vector<Bytes> asked(ano::FrameView frame) {
        const std::uint16_t val = number(frame, 1);
        switch (frame.data()[0]) {
        case 0: return {to_host(frame, 0xE3, Bytes{address} + u16(hardware) + u16(version) + u16(0) + u16(800) + text(name))};
        case 1:
            return {to_host(frame, 0xE0, Bytes{1} + u16(reported_count.value_or(static_cast<std::uint16_t>(parameters.size()))))};
        case 0x10: return {check(frame)};
        default: break;
        }
        if (val >= parameters.size()) {
            crashed = true;
            return {};
        }
        const Parameter& p = parameters[val];
        if (frame.data()[0] == 2) return {to_host(frame, 0xE1, u16(val) + p.value)};
        if (old || scaled)
            return {
                to_host(frame, 0xE2,
                        u16(val) + i32(p.min) + i32(p.max) + (scaled ? i32(p.mul) : Bytes{}) + text(p.name, 20) + text(p.info))};
        return {to_host(frame, 0xE2, u16(val) + Bytes{p.type} + text(p.name, 20) + text(p.info))};
    }

    // If a value is shorter than its type, the check bytes are copied as well, as devices in the field do.
    std::vector<Bytes> written(ano::FrameView frame) {
        const std::uint16_t id = number(frame, 0);
        if (id >= parameters.size()) {
            crashed = true;
            return {};
        }
        Parameter& p = parameters[id];
        const auto type = old || scaled ? ano::Type::i32 : *ano::parameter_type(p.type);
        const std::size_t size = type == ano::Type::text ? frame.data().size() - 2 : ano::width(type);
        const auto* first = frame.data().data() + 2;
        Bytes value(first, first + size);
        p.value = p.store ? p.store(value) : value;
        return {check(frame)};
    }

    std::vector<Bytes> command_asked(ano::FrameView frame) {
        if (frame.data()[0] == 0) return {to_host(frame, 0xC1, Bytes{0} + u16(commands.size()) + (old ? Bytes{0, 0} : Bytes{}))};
        const std::uint16_t val = number(frame, 1);
        if (val >= commands.size()) return {};
        const Command& c = commands[val];
        Bytes types = c.types;
        types.resize(8);
        return {to_host(frame, 0xC2, u16(val) + Bytes(c.cid.begin(), c.cid.end()) + types + text(c.name, 20) + text(c.info))};
    }
    std::vector<Bytes> called(ano::FrameView frame) {
        for (const Command& c : commands)
            if (std::equal(c.cid.begin(), c.cid.end(), frame.data().begin())) return {check(frame)};
        return {};
    }

    std::vector<Bytes> waypoint_asked(ano::FrameView frame) {
        const std::uint8_t num = frame.data()[0];
        if (num == 0xFF) return {to_host(frame, 0x60, {static_cast<std::uint8_t>(waypoints.size())})};
        if (num >= waypoints.size()) return {};
        return {to_host(frame, 0x61, waypoints[num])};
    }
    std::vector<Bytes> waypoint_written(ano::FrameView frame) {
        const std::uint8_t num = frame.data()[0];
        while (num >= waypoints.size()) waypoints.push_back(Bytes{static_cast<std::uint8_t>(waypoints.size())} + Bytes(21));
        waypoints[num].assign(frame.data().begin(), frame.data().end());
        return {check(frame)};
    }
};

/// The effect of a line on frames in one direction.
struct LineFaults {
    Duration delay{};
    Duration jitter{};    // random additional delay: frames overtake each other
    double loss = 0;      // probability, 0 to 1
    double duplicate = 0;
    unsigned baud = 0;         // for the duration of bytes, 10 bits each; 0: no duration
    double byte_errors = 0;    // probability, 0 to 1; a frame with an error is lost
};

/// A host's side of one device, the device, and the line between them, in simulated time.
class Simulation {
public:
    explicit Simulation(ano::host::Device& host_side, FakeDevice& fake, LineFaults faults = {}, std::uint64_t seed = 1)
        : device{host_side}, there{faults}, back{faults}, fake_{fake}, random_{seed} {}

    ano::host::Device& device;
    LineFaults there, back;
    TimePoint now = TimePoint{} + 1h;
    std::size_t most_on_their_way = 0;
    std::size_t frames_there = 0, bytes_there = 0, frames_back = 0, bytes_back = 0;
    std::map<ano::host::Taken, int> taken;
    std::function<void(TimePoint)> each_step;    // optional
    std::function<std::vector<Bytes>(const Bytes&)>
        parse;                  // the device's parser: bytes in, frames out; none: it finds every frame
    bool blocks = false;        // the device receives nothing while its answer is on the line
    unsigned queue_rate = 0;    // bytes/s at which the host's queue is sent; 0: at once
    std::size_t zeros_there = 0;
    Duration telemetry_every{};    // between the device's frames to all, of 34 bytes each; 0: it sends none

    /// Makes the line a UART: before a request that the device may not receive, zero bytes are sent, at most once per second.
    void be_uart() {
        device.on_maybe_deaf([this](ano::FrameView) -> ano::Flush {
            if (now < free_there_) return {};
            if (now < flush_again_at_) return {.later = flush_again_at_ - now};
            flush_again_at_ = now + 1s;
            const Bytes zeros(206);
            zeros_there += zeros.size();
            on_line(there, free_there_, {true, zeros});
            return {.sent = true, .busy = free_there_ - now};
        });
    }
    /// The zero bytes were sent now, for another device of this line: the next ones may be sent in a second.
    void flush_for_another() { flush_again_at_ = now + 1s; }
    /// The device sends `bytes` in `time`, whatever else it does.
    void answer_later(const Bytes& bytes, Duration time) { events_.emplace(now + time, Event{false, bytes}); }
    /// Passes `bytes` to the device now.
    void disturb(const Bytes& bytes) { events_.emplace(now, Event{true, bytes}); }

    /// Runs until `task` has ended, no event is left, or `limit` is over. Returns the duration.
    Duration run(const ano::host::Task& task, Duration limit = 1h) {
        const TimePoint begin = now;
        send();
        while (!task.end() && now - begin < limit) {
            const auto due = leaves_at_ > now ? leaves_at_ : device.due();
            const auto next = std::min(due.value_or(TimePoint::max()), next_event());
            if (next == TimePoint::max()) break;
            now = std::max(now, next);
            deliver();
            if (each_step) each_step(now);
            send();
        }
        return now - begin;
    }
    /// Advances the time; frames on the line arrive meanwhile.
    void pass(Duration time) {
        const TimePoint until = now + time;
        while (next_event() <= until) {
            now = std::max(now, next_event());
            deliver();
        }
        now = until;
    }

private:
    struct Event {
        bool to_device;
        Bytes frame;
    };

    void send() {
        for (;;) {
            device.wait_to_leave(std::min(now, leaves_at_));
            if (leaves_at_ > now) return;
            const auto frame = device.next_frame(now);
            if (!frame) return;
            ++frames_there;
            bytes_there += frame->bytes().size();
            leaves_at_ = std::max(now, queue_free_at_);
            if (queue_rate != 0)
                queue_free_at_ = leaves_at_ + std::chrono::nanoseconds{frame->bytes().size() * 1'000'000'000 / queue_rate};
            on_line(there, free_there_, {true, {frame->bytes().begin(), frame->bytes().end()}}, leaves_at_);
            most_on_their_way = std::max(most_on_their_way, device.on_their_way());
        }
    }
    TimePoint next_event() const {
        const TimePoint first = events_.empty() ? TimePoint::max() : events_.begin()->first;
        return telemetry_every > Duration::zero() ? std::min(first, telemetry_at_) : first;
    }
    void send_telemetry() {
        if (telemetry_every <= Duration::zero() || telemetry_at_ > now) return;
        on_line(back, free_back_, {false, support::frame(fake_.address, 0xFF, 0x03, Bytes(26))});
        telemetry_at_ = now + telemetry_every;
    }
    void deliver() {
        send_telemetry();
        while (!events_.empty() && events_.begin()->first <= now) {
            const Event event = std::move(events_.begin()->second);
            events_.erase(events_.begin());
            if (!event.to_device) {
                ++taken[device.take(ano::FrameView{event.frame}, now)];
            } else if (!blocks || free_back_ <= now) {
                for (const Bytes& frame : parse ? parse(event.frame) : std::vector<Bytes>{event.frame})
                    answer(ano::FrameView{frame});
            }
        }
    }
    void answer(ano::FrameView frame) {
        for (const Bytes& answer : fake_.take(frame)) {
            ++frames_back;
            bytes_back += answer.size();
            on_line(back, free_back_, {false, answer});
        }
    }
    void on_line(const LineFaults& faults, TimePoint& free, const Event& event, TimePoint leaves_at = TimePoint::min()) {
        free = std::max({free, now, leaves_at});
        if (faults.baud != 0) free += std::chrono::nanoseconds{event.frame.size() * 10'000'000'000 / faults.baud};
        const int copies = chance(faults.duplicate) ? 2 : 1;
        for (int i = 0; i < copies; ++i) {
            if (chance(faults.loss)) continue;
            if (faults.byte_errors > 0 && chance(1 - std::pow(1 - faults.byte_errors, event.frame.size()))) continue;
            const Duration jitter{faults.jitter.count() == 0 ? 0 : random_.below(faults.jitter.count())};
            events_.emplace(free + faults.delay + jitter, event);
        }
    }
    bool chance(double p) { return p > 0 && static_cast<double>(random_.below(1'000'000u)) < p * 1e6; }

    FakeDevice& fake_;
    Random random_;
    TimePoint free_there_{}, free_back_{};
    TimePoint flush_again_at_{}, leaves_at_{}, queue_free_at_{}, telemetry_at_{};
    std::multimap<TimePoint, Event> events_;
};

}    // namespace support
