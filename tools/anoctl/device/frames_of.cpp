#include "frames_of.hpp"

#include "device_names.hpp"

#include <anoctl/own_link.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/watch.hpp>

#include <ano_json/frame_json.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <bitset>
#include <variant>

namespace anoctl {
namespace {

using Chosen = std::bitset<256>;

Chosen addresses_of_devices(const std::vector<std::string>& words) {
    if (words.empty()) return Chosen{}.set();
    Chosen chosen;
    for (const std::string& word : words) {
        const auto address = ano::address_called(word);
        if (const auto* fault = std::get_if<ano::JsonFault>(&address)) throw UsageError{"--device: " + fault->what};
        chosen.set(std::get<std::uint8_t>(address));
    }
    return chosen;
}

// Passes only frames with these ids and sources.
class OnlyThese final : public FrameReceiver {
public:
    OnlyThese(const Chosen& ids, const Chosen& from, FrameReceiver& receiver) : ids_{ids}, from_{from}, receiver_{receiver} {}
    bool accept(ano::FrameView frame, const Passage& passage) override {
        return !ids_[frame.id()] || !from_[frame.source()] || receiver_.accept(frame, passage);
    }
    void use(const anogate::DecodingPtr& decoding) override { receiver_.use(decoding); }
    bool flush() override { return receiver_.flush(); }
    void miss(std::uint64_t count, const std::string& names, std::string_view json) override {
        receiver_.miss(count, names, json);
    }

private:
    const Chosen ids_, from_;
    FrameReceiver& receiver_;
};

}    // namespace

void FramesOf::add(Options& declared, FramesOf& self) {
    declared.push_back({"--device", &self.devices, "DEVICE...", "Select only these devices, by address or name"});
    declared.push_back(
        {"--link", &self.link, "KIND:ADDRESS[,KEY=VALUE...]", "Use this link, as for anogated, instead of a gateway"});
    GatewayOptions::add(declared, self.gateway);
}

// The devices as addresses; names are looked up in the gateway. After its start, a gateway knows only the names of devices that
// were asked for them.
std::vector<std::string> FramesOf::by_address() const {
    std::vector<std::string> all = devices;
    for (std::string& word : all) {
        if (!std::holds_alternative<ano::JsonFault>(ano::address_called(word))) continue;
        if (!link.empty())
            throw UsageError{"--device: " + ano::in_quotes(word) +
                             " is not an address (0xDC); with --link, give addresses instead of names"};
        word = address_named(word);
    }
    return all;
}

std::string FramesOf::address_named(const std::string& word) const {
    ano::Json known = parse_answer(gateway.ask("GET", "/devices"));
    ano::Json called = with_name(at(known, "devices"), word);
    if (called.empty() && !all_have_names(at(known, "devices"))) {
        known = parse_answer(gateway.ask("POST", "/devices/scan"));
        called = with_name(at(known, "devices"), word);
    }
    if (called.size() == 1) return text_at(called.front(), "address");
    if (called.size() > 1)
        throw UsageError{"--device: several devices are named " + ano::in_quotes(word) + ": " + list_of(called)};
    const std::string there = list_of(at(known, "devices"));
    throw UsageError{"--device: no device is named " + ano::in_quotes(word) +
                     (there.empty() ? "; no devices known" : "; devices: " + there)};
}

std::string FramesOf::each(const std::vector<std::string>& ids, FrameReceiver& receiver, Streams& streams,
                           const std::string& who) const {
    const std::vector<std::string> named = by_address();
    const Chosen from = addresses_of_devices(named);
    if (link.empty())
        return watch_frames(gateway.socket(),
                            "&direction=in&elsewhere=no" + filter_words("id", ids) + filter_words("from", named), receiver);
    Chosen wanted;
    for (const std::string& id : ids) wanted.set(message_id_of(id));
    OnlyThese only{wanted, from, receiver};
    listen(link, only, streams, who);
    return {};
}

}    // namespace anoctl
