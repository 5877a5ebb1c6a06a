#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <config/unlikely.hpp>
#include <gateway/can_settings.hpp>
#include <link/can/can_link.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/ip_socket.hpp>

#include <sys/socket.h>

#include <algorithm>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr Duration first_pause = 1ms;    // a queue of 10 frames drains in 2.2 ms at 500 kbit/s
constexpr Duration max_pause = 20ms;
constexpr int max_error_frames = 64;         // per read: a faulty bus causes thousands per second
constexpr Duration carrier_follows = 5ms;    // drivers report bus-off and a restart before the interface changes
constexpr Duration patience = 1s;            // blocked for longer: the bus itself has a fault

}    // namespace

CanLink::CanLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      descriptor_{context.io},
      pacing_{context.alarms, [this] { write(); }},
      errors_{context.io},
      reconnect_{context, *this, [this] { return open(); }},
      again_{context.alarms, [this] { write(); }},
      carrier_look_{context.alarms, [this] { look_at_carrier(); }},
      pause_{first_pause} {}

void CanLink::start() {
    channel_ = context_.host.open_channel(*this, {});
    reconnect_.start();
}

Opened<void> CanLink::open() {
    auto stored = context_.host.claim_stored(*this);
    auto wire = check_can_interface(can()).and_then([&] { return open_wire(stored ? std::move(stored->wire) : UniqueFd{}); });
    if (!wire) return NotOpened{std::move(wire.error())};
    reconnect_.came_up(context_.host.now());
    if (!errors_.is_open()) {
        bus_.came_up();
        watch_bus();
    }
    found_room();
    descriptor_.open(std::move(*wire));
    keep_stamps(descriptor_.fd());
    const ClockReading clocks = context_.host.turn().clocks();
    begin_arrival(arrival_, descriptor_.fd(), stored ? &*stored : nullptr, clocks);
    pacing_.start(settings().rate, settings().latency);
    descriptor_.read_with([this] { read(); });
    context_.host.link_up(*this);
    return {};
}

void CanLink::fail(LinkError why) {
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
    carrier_look_.cancel();
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
    const TimePoint now = context_.host.now();
    for (int i = 0; i < max_error_frames; ++i) {
        can_frame frame{};
        const ssize_t n = ::recv(errors_.fd(), &frame, sizeof frame, 0);
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) break;
        if (n < static_cast<ssize_t>(CAN_MTU)) return errors_.close();    // the interface is down or was removed
        bus_.note(frame, now);
    }
    const bool is_off = bus_.state() == CanBus::State::off;
    if (is_open() == is_off) carrier_look_.set_no_later(now + carrier_follows);
}

void CanLink::look_at_carrier() {
    if (!is_open()) return reconnect_.try_now();
    if (bus_.state() != CanBus::State::off || !can_bus_is_off(can().interface)) return;
    if (auto usable = check_can_interface(can()); !usable) fail(std::move(usable.error()));
}

// Not every driver reports that the controller left bus-off.
void CanLink::heard_on_bus() noexcept {
    if (bus_.state() == CanBus::State::off) bus_.came_up();
}

void CanLink::wait_for_room(bool kernel_notifies) {
    const TimePoint now = context_.host.now();
    if (!blocked_since_) blocked_since_ = now;
    channel_->outbox.set_congested();
    if (kernel_notifies && !woken_) {
        descriptor_.when_writable([this] {
            woken_ = true;
            write();
        });
        return;
    }
    woken_ = false;    // some kernels report a busy ISO-TP socket as writable
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

LinkError CanLink::trouble() const {
    const std::string& interface = can().interface;
    if (LinkError trouble = bus_.trouble(interface); !trouble.text.empty()) return trouble;
    if (blocked_since_ && Clock::now() - *blocked_since_ > patience)
        return {"bus_blocked",
                "frames are not acknowledged on the bus. Is another node connected, with the same bit rate?",
                {{"interface", interface}}};
    return {};
}

namespace {

using namespace key_rows;
using Can = CanSettings;

constexpr Key<LinkSettings> can_keys[] = {
    text<own<Can>, &Can::interface>("interface", 1, max_interface, "the CAN interface; the system sets its bit rate") | needed,
    choice<own<Can>, &Can::framing>("framing", "stream|isotp",
                                    "stream: each frame as a byte stream in CAN frames with the sender's id; isotp: each frame "
                                    "as one ISO-TP PDU, for one peer device"),
    boolean<own<Can>, &Can::fd>("fd", "CAN FD frames of up to 64 bytes"),
    boolean<own<Can>, &Can::brs>("brs", "with fd: send the data phase at the faster bit rate"),
    boolean<own<Can>, &Can::extended>("extended", "29-bit CAN ids"),
    can_id<own<Can>, &Can::base>("base",
                                 "first CAN id of stream framing, a multiple of 0x100 up to 0x700, or of 0x40000 with "
                                 "extended (default: 0x600, extended 0x0AB00000)"),
    can_id<own<Can>, &Can::tx>("tx", "with isotp: the CAN id to send with (default: none)"),
    can_id<own<Can>, &Can::rx>("rx", "with isotp: the CAN id to receive (default: none)"),
};

void validate_can(const LinkSettings& link, LinkFaults& faults) {
    if (!faults.is_whole()) return;
    const Can& can = link.as<Can>();
    if (std::string fault = fault_of_interface(can.interface); !fault.empty()) faults.error("interface", std::move(fault));
    if (std::string fault = fault_of(can); !fault.empty())
        faults.error(can.framing == CanFraming::isotp ? "framing" : "base", std::move(fault));
}

bool share_ids(const Can& a, const Can& b) {
    if (a.framing != b.framing || a.extended != b.extended) return false;
    return a.framing == CanFraming::stream ? CanIds{a}.base() == CanIds{b}.base() : a.rx == b.rx || a.tx == b.tx;
}

std::optional<SharedByTwo> shared_ids(const LinkSettings& first, const LinkSettings& second) {
    const Can &a = first.as<Can>(), &b = second.as<Can>();
    if (b.interface.empty() || a.interface != b.interface || !share_ids(a, b)) return std::nullopt;
    return SharedByTwo{"interface", "'interface' " + in_quotes(b.interface) + " is already used by ", ", with the same CAN ids"};
}

std::string meant_can(std::string_view text) {
    const std::string_view address = text.substr(0, text.find(','));
    return address.starts_with("can") || address.starts_with("vcan") ? "'can:" + std::string{text} + "'" : "";
}

std::string about_key_of_can(std::string_view name) {
    if (name != "bitrate" && name != "dbitrate" && name != "baud") return {};
    return in_quotes(name) + " is not a key of can: set the bit rate with sudo ip link set can0 up type can bitrate 500000";
}

std::unique_ptr<Link> make_can_link(LinkId id, const LinkSettings& settings, const LinkContext& context) {
    if (settings.as<Can>().framing == CanFraming::isotp) return std::make_unique<CanIsotpLink>(id, settings, context);
    return std::make_unique<CanStreamLink>(id, settings, context);
}

}    // namespace

extern const LinkKind can_kind;    // listed in kinds.cpp
constinit const LinkKind can_kind{
    .name = "can",
    .address = "interface",
    .example = "can0",
    .help = "a CAN interface; if it is absent, down or bus-off, the link waits for it",
    .carries = Carries::pieces,
    .may_be_paced = true,
    .devices_only = true,
    .hints = {.nothing_yet = {"nothing_on_bus",
                              "nothing received yet: check bit rate, termination, and that all nodes use the same base"},
              .may_wait_for_hello = true},
    .keys = can_keys,
    .settings = [] { return KindSettings{Can{}}; },
    .make = make_can_link,
    .usual_name = [](const LinkSettings& link) { return link.as<Can>().interface; },
    .validate = validate_can,
    .shared = shared_ids,
    .meant_by = meant_can,
    .about_key = about_key_of_can,
};

}    // namespace anogate
