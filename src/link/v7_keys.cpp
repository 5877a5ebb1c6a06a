#include <config/values.hpp>
#include <link/v7_keys.hpp>

#include <algorithm>

namespace anogate {
namespace {

constexpr std::string_view devices = "0xDC, 0xDD, 0xDB, 0xDE, 0xE6, or 1 to 199";

}    // namespace

namespace key_rows {

std::string fault_of_v7_device(std::uint64_t device) {
    const std::string text = address_text(static_cast<std::uint8_t>(device));
    return parse_v7_source("0x51:" + text) ? std::string{} : "'v7_device' must be " + std::string{devices} + ", not " + text;
}

std::string fault_of_v7_sources(const std::vector<std::string>& sources) {
    std::vector<V7Source> before;
    for (const std::string& text : sources) {
        const auto source = parse_v7_source(text);
        if (!source)
            return "'v7_sources' must be ID:DEVICE such as 0x51:0xDE or 0xF1-0xFA:0xDB, with a device of " +
                   std::string{devices} + ", not '" + text + "'";
        for (const V7Source& other : before)
            if (const std::uint8_t first = std::max(source->first, other.first);
                source->address != other.address && first <= std::min(source->last, other.last))
                return "'v7_sources' must name one device for an id, not both " + address_text(other.address) + " and " +
                       address_text(source->address) + " for " + address_text(first);
        before.push_back(*source);
    }
    return {};
}

std::string fault_of_v7_acceleration(const std::string& text) {
    return parse_v7_acceleration(text)
               ? std::string{}
               : "'v7_acc' must be lx, flow, cmss, keep or a number above 0 such as 2048, not '" + text + "'";
}

std::string fault_of_v7_params(const std::string& text) {
    const bool is_table = text == "none" || text == "lx" || text == "tkz" || text.starts_with('/');
    return is_table ? std::string{}
                    : "'v7_params' must be none, lx, tkz or the path of a file that begins with /, not '" + text + "'";
}

std::string fault_of_v7_down(const std::vector<ByteRange>& ids) {
    for (const ByteRange& range : ids)
        for (unsigned id = range.first; id <= range.last; ++id)
            if (V7Translation::is_of_own_sensor(static_cast<std::uint8_t>(id)))
                return "'v7_down' must not contain " + address_text(static_cast<std::uint8_t>(id)) +
                       ": a V7 device would take it for a measurement of its own sensor";
    return {};
}

}    // namespace key_rows

void check_v7(const V7LinkSettings& v7, LinkFaults& faults) {
    if (!faults.is_whole()) return;
    if (v7.is_on() && v7.device == 0)
        faults.error("v7_device",
                     "'protocol' v7 needs 'v7_device', the id under which hosts see the device: " + std::string{devices});
    if (v7.role == V7Role::host && (v7.layout != V7Layout::v8 || !v7.down.empty() || v7.ack != V7Ack::device))
        faults.error("v7_role", "'v7_layout', 'v7_down' and 'v7_ack' have no effect with 'v7_role' host: remove them");
    std::vector<V7Parameter> rows;
    if (const std::string wrong = read_v7_parameters(v7.params, rows); !wrong.empty())
        faults.error("v7_params", "the table of 'v7_params' cannot be used: " + wrong);
    if (!v7.is_on() && v7 != V7LinkSettings{}) faults.error("protocol", "the keys v7_... have no effect without 'protocol' v7");
}

}    // namespace anogate
