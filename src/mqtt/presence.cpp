#include <ano/hex.hpp>
#include <ano_json/json_writer.hpp>
#include <mqtt/presence.hpp>

namespace anogate {
namespace {

constexpr std::uint64_t schema = 1;    // of topics and records
constexpr std::size_t max_listed = 256;

void write_number(ano::JsonWriter& out, std::string_view name, std::uint64_t number) {
    out.key(name);
    out.number(number);
}

void write_devices(ano::JsonWriter& out, const std::set<HeardDevice>& devices, const std::map<std::uint8_t, std::string>& names) {
    out.key("devices");
    out.begin_array();
    std::size_t count = 0;
    for (const HeardDevice& device : devices) {
        if (++count > max_listed) break;
        out.begin_object();
        out.text("device", device_level(device.link, device.address));
        out.text("link", device.link);
        out.text("address", ano::hex_byte(device.address));
        if (const auto name = names.find(device.address); name != names.end()) out.text("name", name->second);
        out.end_object();
    }
    out.end_array();
}

void write_counts(ano::JsonWriter& out, const DeliveryCounts& counts) {
    out.key("counts");
    out.begin_object();
    write_number(out, "published", counts.published);
    write_number(out, "unread", counts.unread);
    write_number(out, "denied", counts.denied);
    write_number(out, "refused", counts.refused);
    write_number(out, "spooled", counts.spooled);
    write_number(out, "waiting", counts.waiting);
    write_number(out, "dropped", counts.dropped);
    write_number(out, "gateway_lost", counts.gateway_lost);
    out.end_object();
}

}    // namespace

std::string Presence::offline(std::string_view why, std::uint64_t connection) const {
    std::string text;
    ano::JsonWriter out{text};
    out.begin_object();
    out.text("gateway", gateway_);
    out.text("state", "offline");
    out.text("why", why);
    out.text("run", run_);
    write_number(out, "connection", connection);
    out.end_object();
    return text;
}

std::string Presence::birth(std::uint64_t connection, const std::set<HeardDevice>& devices,
                            const std::map<std::uint8_t, std::string>& names, const DeliveryCounts& counts) const {
    std::string text;
    ano::JsonWriter out{text};
    out.begin_object();
    out.text("gateway", gateway_);
    out.text("state", "online");
    out.text("why", connection <= 1 ? "restart" : "connection");
    out.text("run", run_);
    write_number(out, "connection", connection);
    out.text("version", version_);
    write_number(out, "schema", schema);
    write_devices(out, devices, names);
    write_counts(out, counts);
    out.end_object();
    return text;
}

}    // namespace anogate
