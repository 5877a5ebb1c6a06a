#include <link/can_bus.hpp>

#include <linux/can/error.h>

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

#ifndef CAN_ERR_CRTL_ACTIVE
constexpr std::uint8_t CAN_ERR_CRTL_ACTIVE = 0x40;    // Linux 4.5
#endif

}    // namespace

void CanBus::note(const can_frame& frame, TimePoint now) noexcept {
    if (frame.can_id & CAN_ERR_CRTL) {
        const std::uint8_t said = frame.data[1];
        if (said & (CAN_ERR_CRTL_RX_OVERFLOW | CAN_ERR_CRTL_TX_OVERFLOW)) seen(overflow, now);
        if (said & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) {
            seen(passive, now);
            state_ = State::passive;
        } else if (said & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) {
            seen(warning, now);
            state_ = State::warning;
        } else if (said & CAN_ERR_CRTL_ACTIVE) {
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
    for (std::size_t i = 0; i < events; ++i) {
        facts.push_back({event_names[i].count, seen_[i].count});
        if (seen_[i].count == 0) continue;
        facts.push_back({event_names[i].age, std::chrono::duration_cast<std::chrono::seconds>(now - seen_[i].last).count()});
    }
}

LinkError CanBus::trouble(const std::string& interface) const {
    const LinkError::Arguments where{{"interface", interface}};
    switch (state_) {
    case State::active: return {};
    case State::warning:
        return {"bus_errors", "error-warning: the controller counts many errors; check wiring and termination", where};
    case State::passive:
        return {"bus_passive", "error-passive: check wiring, termination and bit rate; is another node on the bus?", where};
    case State::off: return {"bus_off", "bus-off: the controller has left the bus", where};
    }
    return {};
}

}    // namespace anogate
