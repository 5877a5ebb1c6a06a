#include <ano/hex.hpp>
#include <ano_json/strict_json.hpp>
#include <devices/device_json.hpp>
#include <devices/unit_note.hpp>
#include <devices/works/work.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>

namespace anogate {
namespace {

using UnitJson = nlohmann::ordered_json;

// FNV-1a: names of notes only need to differ.
std::uint32_t digest(std::string_view text) {
    std::uint32_t sum = 2166136261u;
    for (const char c : text) sum = (sum ^ static_cast<std::uint8_t>(c)) * 16777619u;
    return sum;
}

bool has_same_versions(const ano::host::DeviceInfo& one, const ano::host::DeviceInfo& other) {
    return one.dev_id == other.dev_id && one.hw_ver == other.hw_ver && one.sw_ver == other.sw_ver && one.bl_ver == other.bl_ver &&
           one.pt_ver == other.pt_ver;
}

std::string format_info(const ano::host::DeviceInfo& info) {
    return info.name + " (dev_id " + std::to_string(info.dev_id) + ", hw " + std::to_string(info.hw_ver) + ", sw " +
           std::to_string(info.sw_ver) + ", bl " + std::to_string(info.bl_ver) + ", pt " + std::to_string(info.pt_ver) + ")";
}

UnitJson member(const UnitJson& json, const char* key) { return json.is_object() ? json.value(key, UnitJson{}) : UnitJson{}; }

std::string text_in_note(const UnitJson& json, const char* key) {
    const UnitJson value = member(json, key);
    return value.is_string() ? value.get<std::string>() : std::string{};
}

UnitPlace here_of(const WorkPlace& place) { return place.net.unit_place(place.device.address(), place.net.now()); }

constexpr std::size_t note_digits = 8;

}    // namespace

UnitJson unit_json(const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info) {
    const UnitPlace at = here_of(place);
    return {{"gateway", at.gateway},
            {"link", at.link},
            {"wire", at.wire},
            {"kept_at", place.net.date_text()},
            {"device", identity_json(place.device.address(), info, place.texts)}};
}

std::string unit_note_name(std::string_view kind, const WorkPlace& place, const std::optional<ano::host::DeviceInfo>& info,
                           std::string_view ending) {
    const UnitPlace at = here_of(place);
    const std::uint32_t mark = digest(at.gateway + '\n' + at.link + '\n' + at.wire + '\n' +
                                      (info ? format_info(*info) : std::string{}));
    std::string name{kind};
    name.append("-").append(ano::hex_byte(place.device.address())).append("-");
    for (int shift = 28; shift >= 0; shift -= 4) name += "0123456789abcdef"[(mark >> shift) & 15u];
    if (!ending.empty()) name.append("-").append(ending);
    return name.append(".json");
}

bool is_unit_note_name(std::string_view name, std::string_view kind, std::string_view ending) {
    const auto address = address_of_note(name);
    if (!address) return false;
    const std::string begin = std::string{kind} + "-" + ano::hex_byte(*address);
    const std::string end = (ending.empty() ? "" : "-" + std::string{ending}) + ".json";
    if (!name.starts_with(begin)) return false;
    name.remove_prefix(begin.size());
    const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
    const bool has_digits = name.size() > note_digits && name[0] == '-' &&
                            std::all_of(name.begin() + 1, name.begin() + 1 + note_digits, is_digit);
    return name == end || (has_digits && name.substr(1 + note_digits) == end);
}

std::optional<std::uint8_t> address_of_note(std::string_view name) {
    const std::string_view digits = name.substr(std::min(name.find("0x"), name.size() - 2) + 2).substr(0, 2);
    std::uint8_t address = 0;
    const auto [end, ec] = std::from_chars(digits.data(), digits.data() + digits.size(), address, 16);
    return digits.size() == 2 && ec == std::errc{} && end == digits.data() + 2 ? std::optional{address} : std::nullopt;
}

UnitJson note_json(const std::string& text) {
    auto json = ano::strict_json<UnitJson>(text);
    return json && json->is_object() ? *std::move(json) : UnitJson{};
}

bool names_its_device(std::string_view name, const std::string& text) {
    const auto address = address_of_note(name);
    return address && text_in_note(member(note_json(text), "device"), "address") == ano::hex_byte(*address);
}

std::optional<ano::host::DeviceInfo> info_in_note(const std::string& text) {
    return identity_in(member(note_json(text), "device"));
}

std::string misfit_of_place(const std::string& text, const UnitPlace& here, bool link_is_known) {
    const UnitJson note = note_json(text);
    const std::string gateway = text_in_note(note, "gateway"), link = text_in_note(note, "link"),
                      wire = text_in_note(note, "wire");
    if (gateway.empty()) return "of an older version without the gateway and link";
    if (gateway != here.gateway) return "of the gateway " + gateway;
    if (link_is_known && (link != here.link || wire != here.wire))
        return "of the link '" + link + "' (" + wire + "), not of '" + here.link + "' (" + here.wire + ")";
    return {};
}

std::string misfit_of_note(const std::string& text, const WorkPlace& place, WithoutInfo silent) {
    if (std::string misfit = misfit_of_place(text, here_of(place), true); !misfit.empty()) return misfit;
    const UnitJson of = member(note_json(text), "device");
    if (text_in_note(of, "address") != ano::hex_byte(place.device.address())) return "of no known device";
    const auto was = identity_in(of);
    const auto& info = place.device.info();
    if (!info && silent == WithoutInfo::fits) return {};
    if (!was) return "of no known device";
    if (info && place.texts.is(info->name, was->name) && has_same_versions(*was, *info)) return {};
    return "of another device, " + format_info(*was);
}

std::string find_note(const WorkPlace& place, const std::function<bool(std::string_view name)>& wanted, WithoutInfo silent) {
    for (const std::string& name : place.journal.names(place.device.address()))
        if (wanted(name) && misfit_of_note(*place.journal.find(name), place, silent).empty()) return name;
    return {};
}

std::string describe_unit(const std::string& text) {
    const UnitJson note = note_json(text);
    const UnitJson of = member(note, "device");
    const std::string name = text_in_note(of, "name"), link = text_in_note(note, "link"), at = text_in_note(note, "kept_at");
    return (name.empty() ? "an unnamed device" : name) + " (" + text_in_note(of, "address") + ")" +
           (link.empty() ? "" : ", link '" + link + "'") + (at.empty() ? "" : ", saved " + at);
}

}    // namespace anogate
