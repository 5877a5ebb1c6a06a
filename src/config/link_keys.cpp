#include <ano/address.hpp>
#include <config/link_kind.hpp>
#include <config/rule_keys.hpp>

#include <algorithm>
#include <tuple>

namespace anogate {
namespace {

using namespace key_rows;
using L = LinkSettings;

Value get_hello(const KeyFacts&, const LinkSettings& link) {
    if (!link.hello) return {};
    if (*link.hello == LinkSettings::usual_hello) return true;
    return *link.hello == Duration{} ? Value{false} : Value{*link.hello};
}

std::string set_hello(const KeyFacts&, Value value, LinkSettings& link) {
    if (const bool* on = std::get_if<bool>(&value)) link.hello = *on ? LinkSettings::usual_hello : Duration{};
    else link.hello = std::get<Duration>(value);
    return {};
}

// values of KeyFacts::kinds
constexpr std::string_view paced = "paced", datagrams = "datagrams", one_by_one = "one by one", streams = "streams";

constexpr Key<L> own_rows[] = {
    text<&L::name>("name", 1, max_name, "the name of the link (default: last part of the path, or kind-port)") | as("NAME"),
    address<&L::id>("id", 1, ano::address::last_port_id, "port id: frames to this address are sent by this link (default: none)"),
    choice<&L::profile>(
        "profile", "none|vendor|old",
        "the kind of devices on this link; vendor, the manufacturer's newest library: max_data_out=198, hello=on, "
        "value_type_7=u64, no frames without DATA, at most 8 unanswered requests; old, "
        "devices that act on frames for any address: flood=no, broadcast=no, max_data_out=60, hello=on"),
    integer<&L::max_data>("max_data", 0, 65535,
                          "maximum DATA length of a received frame; longer ones are refused, but images (0xB0) may have 20000 "
                          "if this is 4096 or more"),
    integer<&L::max_data_out>(
        "max_data_out", 0, 65535,
        "maximum DATA length of a sent frame (default: max_data, at most 198 with profile=vendor, 60 with old)"),
    Key<L>{{.name = "hello",
            .form = Form::interval,
            .help = "while nothing is received, query the devices (0xE0 0 from 0xFE): first after 1 s, then at this interval; on "
                    "means 2s "
                    "(default: off, with a profile on); not on udp-listen",
            .min = second,
            .max = day},
           get_hello,
           set_hello},
    choice<&L::value_type_7>("value_type_7", "f32|u64",
                             "the meaning of value type 7 in commands (default: u64 with profile=vendor, else derived from the "
                             "descriptions of the device)"),
    choice<&L::encoding>(
        "encoding", "utf8|gbk",
        "the encoding of names and texts of the devices (default: utf8 if all texts of a device are valid UTF-8, else gbk)"),
    choice<&L::attitude>("attitude", "document|lx",
                         "for tools: the signs of Euler angles (0x03); lx, the manufacturer's LX units: pitch and yaw have the "
                         "opposite sign of the "
                         "quaternion (0x04)"),
    integer<&L::queue>("queue", 8, 64 << 20, "maximum number of bytes waiting in a channel, at least max_data_out + 8"),
    boolean<&L::flood>("flood", "send frames to unknown addresses (default: yes, with profile=old no)"),
    boolean<&L::broadcast>("broadcast", "send frames to 0xFF (default: yes, with profile=old no)"),
    text<&L::group>("group", 1, max_name,
                    "links of one group lead to the same place: one is used, copies are dropped (default: none)") |
        as("GROUP"),
    address<&L::present_as>("present_as", first_id, last_id,
                            "for devices that answer only 0xFE: hosts with another address appear there under this one, and "
                            "answers return to the sender (default: none)"),
    integer<&L::rate>("rate", 1, 1'000'000'000,
                      "maximum bytes sent per second, for a slow radio behind the link (default: no limit)") |
        of(paced),
    duration<&L::latency>("latency", 1, second, "how far writing may be ahead of the line on a paced link") | of(paced),
    duration<&L::gap>(
        "gap", 0, second,
        "pause after each sent frame, from its end on the wire, one frame per write: for devices that read one frame "
        "at a time (default: none)") |
        of(one_by_one),
    duration<&L::frame_gap>(
        "frame_gap", 1, 10 * second,
        "for bridges that pause within a frame: the longest pause within a frame (default: 50 ms, 100 ms between "
        "datagrams)") |
        of(streams),
    boolean<&L::pack>("pack", "put several waiting frames into one datagram") | of(datagrams),
    integer<&L::mtu>("mtu", 64, 65507, "maximum size of a datagram with several frames") | of(datagrams),
    duration<&L::age, &AgeLimits::control>("age.control", 1, day, "drop control frames (0x40, 0x41) that waited longer"),
    duration<&L::age, &AgeLimits::telemetry>("age.telemetry", 1, day, "drop telemetry that waited longer"),
    duration<&L::age, &AgeLimits::rest>("age.rest", 1, day, "drop any other frame that waited longer"),
    boolean<&L::required>("required", "exit with status 1 if this link is not up within 10 s"),
    boolean<&L::enabled>("enabled", "no: the link is not opened, and frames for it are dropped (link_down)"),
    boolean<&L::manage>("manage",
                        "senders on this link may write the parameters of the gateway itself and command it, if it has an id"),
};

constexpr auto rows = own_rows + rules_of<L, &L::rules>();

// Keys for sent frames: links that only receive do not have them.
bool is_for_takers(std::string_view key) {
    constexpr std::string_view keys[] = {"id",    "max_data_out", "hello",       "queue",         "flood",   "broadcast",
                                         "group", "present_as",   "age.control", "age.telemetry", "age.rest"};
    return std::find(std::begin(keys), std::end(keys), key) != std::end(keys);
}

bool may_have(const LinkKind& kind, const KeyFacts& common) {
    if (kind.replays && is_for_takers(common.name)) return false;
    const bool is_stream = kind.carries == Carries::bytes || kind.carries == Carries::datagrams;
    if (common.kinds == paced) return kind.may_be_paced;
    const bool shares_a_socket = kind.listens && kind.carries == Carries::datagrams;    // all its peers
    if (common.kinds == one_by_one) return kind.may_be_paced && is_stream && !shares_a_socket;
    if (common.kinds == streams) return is_stream;
    return common.kinds != datagrams || kind.carries == Carries::datagrams;
}

/// The order in help texts: wires before networks, listening kinds last.
auto place_of(const LinkKind* kind) {
    return std::tuple{kind->carries == Carries::datagrams, kind->carries != Carries::bytes, kind->listens};
}

/// The kinds that have a key with this name, for error texts. For a key in the tables of single kinds, in the order of `kinds`.
std::vector<std::string_view> owners_of(std::string_view name, LinkKinds kinds) {
    std::vector<std::string_view> owners;
    for (const LinkKind* kind : kinds)
        if (find_key(kind->keys, name) != nullptr) owners.push_back(kind->name);
    if (!owners.empty()) return owners;
    const Key<L>* common = find_key(common_link_keys(), name);
    std::vector<const LinkKind*> all{kinds.begin(), kinds.end()};
    std::stable_sort(all.begin(), all.end(), [](const auto* a, const auto* b) { return place_of(a) < place_of(b); });
    for (const LinkKind* kind : all)
        if (common != nullptr && may_have(*kind, *common)) owners.push_back(kind->name);
    return owners;
}

}    // namespace

Keys<LinkSettings> common_link_keys() noexcept { return rows; }

KeyList<LinkSettings> keys_of(const LinkKind& kind, LinkKinds kinds) {
    KeyList<LinkSettings> list;
    for (const Key<L>& key : kind.keys) list.keys.push_back(&key);
    for (const Key<L>& key : common_link_keys())
        if (may_have(kind, key)) list.keys.push_back(&key);
    list.unknown = [kind = &kind, kinds](std::string_view name) {
        if (std::string about = kind->about_key ? kind->about_key(name) : ""; !about.empty()) return about;
        std::vector<std::string_view> names;
        for (const Key<L>* key : keys_of(*kind, kinds).keys) names.push_back(key->name);
        return unknown_key(name, names, kind->name, owners_of(name, kinds));
    };
    return list;
}

const Key<LinkSettings>* find_key_of_any(LinkKinds kinds, std::string_view name) {
    for (const LinkKind* kind : kinds)
        if (const Key<L>* key = find_key(kind->keys, name)) return key;
    return find_key(common_link_keys(), name);
}

}    // namespace anogate
