#include <link/can_link.hpp>
#include <link/datagram_batch.hpp>
#include <link/ip_socket.hpp>

#include <sys/socket.h>

#include <algorithm>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr Duration first_pause = 1ms;    // a queue of 10 frames drains in 2.2 ms at 500 kbit/s
constexpr Duration max_pause = 20ms;
constexpr Duration patience = 1s;    // blocked for so long, the bus itself is in trouble

}    // namespace

std::unique_ptr<Link> make_can_link(LinkId id, const LinkSettings& settings, const LinkContext& context) {
    if (settings.can.framing == CanFraming::isotp) return std::make_unique<CanIsotpLink>(id, settings, context);
    return std::make_unique<CanStreamLink>(id, settings, context);
}

CanLink::CanLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      pacing_{context.alarms, [this] { write(); }},
      errors_{context.io},
      reconnect_{context, *this, [this] { return open(); }},
      again_{context.alarms, [this] { write(); }},
      pause_{first_pause} {}

void CanLink::start() {
    channel_ = context_.host.open_channel(*this, {});
    reconnect_.start();
}

Expected<void> CanLink::open() {
    auto wire = check_can_interface(can()).and_then([this] { return open_wire(); });
    if (!wire) return Unexpected{std::move(wire.error())};
    reconnect_.came_up(context_.host.now());
    if (!errors_.is_open()) {
        bus_.came_up();
        watch_bus();
    }
    found_room();
    descriptor_.open(std::move(*wire));
    keep_stamps(descriptor_.fd());
    arrival_.found_empty(context_.host.turn().clocks());
    pacing_.start(settings().rate, settings().latency);
    descriptor_.read_with([this] { read(); });
    context_.host.link_up(*this);
    return {};
}

void CanLink::fail(std::string why) {
    old_kernel_drops_ += kernel_drops(descriptor_.fd());
    close_wire();
    again_.cancel();
    pacing_.stop();
    lost();
    reconnect_.lost(std::move(why));
}

void CanLink::stop_reading() {
    descriptor_.stop_reading();
    errors_.stop_reading();
    reconnect_.stop();
}

void CanLink::stop() {
    reconnect_.stop();
    again_.cancel();
    pacing_.stop();
    errors_.close();
    close_wire();
}

void CanLink::watch_bus() {
    auto errors = open_can_errors(can());
    if (!errors) return;
    errors_.open(std::move(*errors));
    errors_.read_with([this] { read_errors(); });
}

void CanLink::read_errors() {
    can_frame frame{};
    const ssize_t n = ::recv(errors_.fd(), &frame, sizeof frame, 0);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return;
    if (n < static_cast<ssize_t>(CAN_MTU)) return errors_.close();    // the interface is down or gone
    const TimePoint now = context_.host.now();
    bus_.note(frame, now);
    if (bus_.state() == CanBus::State::off) {
        if (!is_open() || !can_bus_is_off(can().interface)) return;
        if (auto usable = check_can_interface(can()); !usable) fail(std::move(usable.error()));
    } else if (!is_open()) {
        reconnect_.try_soon();
    }
}

void CanLink::wait_for_room(bool kernel_tells) {
    const TimePoint now = context_.host.now();
    if (!blocked_since_) blocked_since_ = now;
    channel_->outbox.set_congested();
    if (kernel_tells && !woken_) {
        descriptor_.when_writable([this] {
            woken_ = true;
            write();
        });
        return;
    }
    woken_ = false;    // woken in vain: some kernels call a busy ISO-TP socket writable
    again_.set(now + pause_);
    pause_ = std::min(2 * pause_, max_pause);
}

void CanLink::found_room() noexcept {
    woken_ = false;
    pause_ = first_pause;
    blocked_since_.reset();
}

LinkFacts CanLink::facts() const {
    LinkFacts facts{{"interface", can().interface},
                    {"framing", std::string{can().framing == CanFraming::isotp ? "isotp" : "stream"}},
                    {"kernel_drops", old_kernel_drops_ + (is_open() ? kernel_drops(fd()) : 0)}};
    bus_.add_facts(facts, Clock::now());
    return facts;
}

std::string CanLink::trouble() const {
    if (std::string trouble = bus_.trouble(); !trouble.empty()) return trouble;
    if (blocked_since_ && Clock::now() - *blocked_since_ > patience)
        return "the bus takes nothing: is another node on it, at the same bit rate?";
    return {};
}

}    // namespace anogate
