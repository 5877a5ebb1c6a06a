#include <link/can/can_bus.hpp>

#include <linux/can/error.h>

#include <iterator>

namespace anogate {
namespace {

constexpr std::string_view state_names[] = {"error-active", "error-warning", "error-passive", "bus-off"};

struct EventName {
    std::string_view count;
    std::string_view age;
};
constexpr EventName event_names[] = {{"error_warning", "error_warning_s"},
                                     {"error_passive", "error_passive_s"},
                                     {"bus_off", "bus_off_s"},
                                     {"restarted", "restarted_s"},
                                     {"controller_overflow", "controller_overflow_s"}};

// The kinds of error frames. Those of the controller (CAN_ERR_CRTL) carry its state and are handled separately.
struct ErrorKind {
    canid_t flag;
    std::string_view name;
};
constexpr ErrorKind error_kinds[] = {{CAN_ERR_TX_TIMEOUT, "errors_tx_timeout"},
                                     {CAN_ERR_LOSTARB, "errors_lost_arbitration"},
                                     {CAN_ERR_PROT, "errors_protocol"},
                                     {CAN_ERR_TRX, "errors_transceiver"},
                                     {CAN_ERR_ACK, "errors_no_ack"},
                                     {CAN_ERR_BUSERROR, "errors_bus"}};
static_assert(std::size(error_kinds) == CanBus::error_kinds);

#ifndef CAN_ERR_CRTL_ACTIVE
constexpr std::uint8_t CAN_ERR_CRTL_ACTIVE = 0x40;    // Linux 4.5
#endif

}    // namespace

void CanBus::note(const can_frame& frame, TimePoint now) noexcept {
    ++error_frames_;
    for (std::size_t i = 0; i < error_kinds; ++i)
        if (frame.can_id & anogate::error_kinds[i].flag) ++kinds_[i];
    if (frame.can_id & CAN_ERR_CRTL) {
        const std::uint8_t error_bits = frame.data[1];
        if (error_bits & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) seen(overflow, now);
        if (error_bits & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) {
            seen(passive, now);
            state_ = State::passive;
        } else if (error_bits & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) {
            seen(warning, now);
            state_ = State::warning;
        } else if (error_bits & CAN_ERR_CRTL_ACTIVE) {
            state_ = State::active;
        }
    }
    if (frame.can_id & CAN_ERR_BUSOFF) {
        seen(off, now);
        state_ = State::off;
    }
    if (frame.can_id & CAN_ERR_RESTARTED) {
        seen(restarted, now);
        state_ = State::active;
    }
}

void CanBus::add_facts(LinkFacts& facts, TimePoint now) const {
    facts.push_back({"bus", std::string{state_names[static_cast<std::size_t>(state_)]}});
    facts.push_back({"error_frames", error_frames_});
    for (std::size_t i = 0; i < error_kinds; ++i) facts.push_back({anogate::error_kinds[i].name, kinds_[i]});
    for (std::size_t i = 0; i < events; ++i) {
        facts.push_back({event_names[i].count, seen_[i].count});
        if (seen_[i].count == 0) continue;
        facts.push_back({event_names[i].age, std::chrono::duration_cast<std::chrono::seconds>(now - seen_[i].last).count()});
    }
}

std::string bus_off_text(const std::string& interface) {
    return interface +
           " is bus-off: check wiring, termination (120 ohms at both ends) and bit rate; with restart-ms it recovers by "
           "itself: "
           "sudo ip link set " +
           interface + " down, then ... up type can restart-ms 100";
}

LinkError CanBus::trouble(const std::string& interface) const {
    const LinkError::Arguments where{{"interface", interface}};
    switch (state_) {
    case State::active: return {};
    case State::warning: return {"bus_errors", "error-warning: many CAN errors; check wiring and termination", where};
    case State::passive:
        return {"bus_passive",
                "error-passive: check wiring, termination (120 ohms at both ends) and bit rate; is another node on the bus?",
                where};
    case State::off: return {"bus_off", bus_off_text(interface), where};
    }
    return {};
}

}    // namespace anogate
