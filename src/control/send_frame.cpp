#include <ano/conversation.hpp>
#include <ano/hex.hpp>
#include <ano_json/answer_json.hpp>
#include <ano_json/fault_json.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/strict_json.hpp>
#include <config/link_kind.hpp>
#include <control/send_frame.hpp>
#include <gateway/hints.hpp>
#include <runtime/control_link.hpp>
#include <runtime/gateway.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {
namespace {

using nlohmann::ordered_json;
using FrameBytes = std::vector<std::uint8_t>;

// A string: the error.
std::variant<FrameBytes, std::string> frame_in_hex(const ordered_json& json) {
    if (json.size() > 1) return "'hex' is a complete frame: use no other keys with it";
    if (!json["hex"].is_string()) return "'hex' must be text";
    auto bytes = ano::from_hex(json["hex"].get_ref<const std::string&>());
    if (!bytes) return "'hex' must be hex digits in pairs";
    const auto frame = ano::frame_at(*bytes);
    if (!frame || frame->bytes().size() != bytes->size())
        return "'hex' is not one complete frame with correct check bytes; anoctl decode shows what is wrong";
    return *std::move(bytes);
}

std::variant<FrameBytes, std::string> frame_in(const std::string& body, const ano::FlexibleLayouts& flexible) {
    const auto parsed = ano::json_body(body);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) return *wrong;
    const ordered_json& json = std::get<ordered_json>(parsed);
    if (!json.is_object())
        return R"(the body must be an object such as {"hex": "AB..."} or {"to": 220, "name": "heartbeat", "fields": {}})";
    if (json.contains("hex")) return frame_in_hex(json);
    auto frame = ano::frame_from_json(json, {.flexible = &flexible});
    if (const auto* fault = std::get_if<ano::JsonFault>(&frame))
        return (fault->pointer.empty() ? "" : fault->pointer + ": ") + fault->what;
    return std::get<FrameBytes>(std::move(frame));
}

template <class Rows, class Cause>
const auto& row_of(const Rows& rows, Cause cause) {
    return *std::find_if(std::begin(rows), std::end(rows), [cause](const auto& row) { return row.value == cause; });
}

// Observes the result for each copy of the sent frame, in the form in which it is sent.
class Fate final : public Forwarder::Observer {
public:
    struct Copy {
        LinkId link;
        ChannelId channel;
        FrameBytes bytes;
        bool has_left = false;
        std::string_view cause{};    // why it was dropped
        std::string why{};
        std::uint8_t not_routed = 0;    // the frame acts on this address, to which no link leads; 0: no
    };

    /// All copies are queued; later events refer to them.
    void is_queued() noexcept { queued_ = true; }
    const std::vector<Copy>& copies() const noexcept { return copies_; }

private:
    void received(const Channel&, ano::FrameView, TimePoint) override {}
    void offered(const Channel& to, ano::FrameView frame, ChannelId from) override {
        if (!queued_ && from == ourselves) copies_.push_back({to.link, to.id, {frame.bytes().begin(), frame.bytes().end()}});
    }
    void dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) override {
        if (queued_ || from.id != ourselves) return;
        const auto& row = row_of(receive_counters, cause);
        copies_.push_back({from.link, from.id, {}, false, row.name, std::string{row.help}});
        const bool acts = ano::intent_of(frame) == ano::Intent::acts;
        if (cause == &ReceiveCounters::no_route && acts) copies_.back().not_routed = frame.destination();
    }
    void refused(LinkId to, ano::FrameView, SendCause cause) override {
        if (queued_) return;
        const auto& row = row_of(send_counters, cause);
        copies_.push_back({to, ourselves, {}, false, row.name, std::string{row.help}});
    }
    void left(const Channel& to, ano::FrameView frame) noexcept override {
        if (Copy* copy = find(to, frame)) copy->has_left = true;
    }
    void discarded(const Channel& to, ano::FrameView frame, SendCause cause) noexcept override {
        Copy* const copy = find(to, frame);
        if (!copy) return;
        copy->cause = row_of(send_counters, cause).name;
        copy->why = row_of(send_counters, cause).help;
        if (!to.v7.refusal.empty()) copy->why = "refused by the rules of V7: " + std::string{to.v7.refusal};
    }
    Copy* find(const Channel& to, ano::FrameView frame) noexcept {
        const auto is_it = [&](const Copy& copy) {
            return copy.channel == to.id && !copy.has_left && copy.cause.empty() &&
                   std::equal(copy.bytes.begin(), copy.bytes.end(), frame.bytes().begin(), frame.bytes().end());
        };
        const auto found = std::find_if(copies_.begin(), copies_.end(), is_it);
        return found != copies_.end() ? &*found : nullptr;
    }

    std::vector<Copy> copies_;
    bool queued_ = false;
};

// {"link": "fc", "peer": "/dev/ttyUSB0"}
ordered_json place_of(const Gateway& gateway, const Fate::Copy& copy) {
    ordered_json place{{"link", gateway.link(copy.link).name()}};
    if (copy.channel != ourselves) place["peer"] = gateway.forwarder().channel(copy.channel).peer;
    return place;
}

http::Response response_for(const Gateway& gateway, const Fate& fate, bool ends_here) {
    ordered_json json{{"sent", ordered_json::array()}, {"waiting", ordered_json::array()}, {"dropped", ordered_json::array()}};
    std::string reasons;
    for (const Fate::Copy& copy : fate.copies()) {
        ordered_json place = place_of(gateway, copy);
        if (!copy.cause.empty()) {
            place["cause"] = copy.cause;
            reasons.append(reasons.empty() ? "" : "; ").append(gateway.link(copy.link).name()).append(": ");
            reasons.append(copy.not_routed != 0 ? not_routed(copy.not_routed).text : copy.why);
        }
        json[!copy.cause.empty() ? "dropped" : copy.has_left ? "sent" : "waiting"].push_back(std::move(place));
    }
    http::Response response;
    if (ends_here) json["taken_by"] = "gateway";
    else if (json["sent"].empty() && json["waiting"].empty()) {
        response.status = 409;
        ano::add_fault(json, {"other", "not sent: " + (reasons.empty() ? std::string{"no link accepts it"} : reasons)});
        json["what"] = "refused";
    }
    response.body = line_of(json);
    return response;
}

}    // namespace

http::Response send_request(Gateway& gateway, const http::Request& request) {
    auto read = frame_in(request.body, gateway.decoding()->layouts());
    if (const auto* wrong = std::get_if<std::string>(&read)) return http::error(400, *wrong);
    const ano::FrameView frame{std::get<FrameBytes>(read)};
    ControlLink* const link = gateway.control();
    if (!link) return http::error(503, no_control_link);
    if (const std::size_t most = ano::max_data_of(frame.id(), link->settings().max_data); frame.data().size() > most)
        return http::error(400, "the frame has more DATA than any link can carry: " + std::to_string(most));
    Fate fate;
    gateway.forwarder().add_observer(fate);
    link->send(frame);
    fate.is_queued();
    gateway.flush();
    gateway.forwarder().remove_observer(fate);
    return response_for(gateway, fate, frame.destination() == gateway.settings().gateway.id && frame.destination() != 0);
}

}    // namespace anogate
