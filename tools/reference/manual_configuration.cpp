#include "manual.hpp"
#include "page.hpp"

#include <config/help.hpp>
#include <config/keys.hpp>
#include <config/link_kind.hpp>
#include <link/kinds.hpp>

namespace reference {
namespace {

using namespace anogate;

template <class Section>
void write_key(Page& page, const Key<Section>& key, const Section& defaults) {
    page.item(key.name, (key.form == Form::limits ? "{MESSAGE: NUMBER}" : placeholder(key)) + (key.required ? ", required" : ""),
              help_of(key, key.text_in(defaults)));
}

template <class Section>
void write_section(Page& page, std::string_view title, std::string_view words, Keys<Section> keys) {
    page.subsection(title);
    page.text(words);
    page.begin_list();
    for (const Key<Section>& key : keys) write_key(page, key, Section{});
    page.end_list();
}

void write_links(Page& page) {
    page.subsection("links");
    page.text(
        "A list of at most 64 links. Each is a LINK text as in anogated(8), or an object with \"kind\", the address key of that "
        "kind, and these keys common to all kinds:");
    page.begin_list();
    for (const Key<LinkSettings>& key : common_link_keys())
        if (key.kinds.empty()) write_key(page, key, LinkSettings{});
    page.end_list();
    for (const LinkKind* kind : link_kinds()) {
        page.subsection("links of kind \"" + std::string{kind->name} + "\"");
        page.text(kind->help);
        page.begin_list();
        const LinkSettings usual = new_link(*kind);
        for (const Key<LinkSettings>* key : keys_of(*kind, link_kinds()).keys) {
            const bool is_common = find_key(common_link_keys(), key->name) == key && key->kinds.empty();
            if (!is_common) write_key(page, *key, usual);
        }
        page.end_list();
    }
}

}    // namespace

std::string configuration_page() {
    Page page{"anogate.json", 5, "configuration of anogated"};
    page.section("DESCRIPTION");
    page.text(
        "JSON with comments (// and /* */). An omitted key has its default; an unknown key is an error that suggests the nearest "
        "one. Durations are written 500ms, 30s, 2m, 1h; addresses (hardware ids) 220 or \"0xDC\". A key with a dot in its name "
        "belongs to an object: \"send.deny\" is {\"send\": {\"deny\": []}}.");
    page.paragraph();
    page.text("anogated --check lists the errors in a file, one per line.");
    page.section("KEYS");
    write_section<GatewaySettings>(page, "gateway", "An object:", gateway_keys());
    write_links(page);
    write_section<RouteSettings>(page, "routes", "A list of objects: addresses pinned to a link.", route_keys());
    write_section<AliasSettings>(page, "alias", "A list of objects: a device on a link appears with another id.", alias_keys());
    write_section<ClassSettings>(page, "classes",
                                 "A list of objects: queueing class of the frames of a message id on a slow link, if not the "
                                 "default of the protocol. For setpoints in flexible messages.",
                                 class_keys());
    write_section<TunnelSettings>(page, "tunnel", "An object; without it, tunnel frames (0xB1, 0xB2) are not carried over UDP.",
                                  tunnel_keys());
    write_section<WrapSettings>(page, "tunnel: wrap", "A list of objects in tunnel: plain frames are wrapped for a link.",
                                wrap_keys());
    write_section<GpioSettings>(page, "gpio", "A list of objects: lines of GPIO chips.", gpio_keys());
    page.subsection("flexible");
    page.text(
        "A list of objects for tools: the layouts of the flexible messages 0xF1 to 0xFA. Each has \"id\", optionally \"source\", "
        "\"endian\" (little or big), \"when\" (only frames whose first field has this value), "
        "and \"fields\", a list of {\"name\", \"type\", \"count\", \"scale\", \"unit\"}, where type is u8, i8, u16, i16, u32, "
        "i32 or f32, and a count above 1 makes an array.");
    write_section<ControlSettings>(page, "control", "An object:", control_keys());
    write_section<RecordSettings>(page, "record", "An object; if present, the gateway records frames to files for Wireshark.",
                                  record_keys());
    write_section<LogSettings>(page, "log", "An object:", log_keys());
    page.section("FILES");
    page.begin_list();
    page.item("/etc/anogate/anogate.full.json", "", "Every key with its default and a comment");
    page.item("/usr/share/doc/anogate/config/examples", "", "Complete example files");
    page.item("/usr/share/doc/anogate/config/anogate.schema.json", "", "JSON Schema, for editors");
    page.end_list();
    page.section("EXAMPLES");
    page.literal(
        "{\n"
        "  \"gateway\": {\"id\": 199},\n"
        "  \"links\": [\n"
        "    {\"name\": \"fc\", \"kind\": \"serial\", \"device\": \"/dev/ttyUSB0\", \"baud\": 500000, \"id\": 1},\n"
        "    {\"name\": \"ground\", \"kind\": \"udp-listen\", \"address\": \"0.0.0.0:12333\"},\n"
        "    \"serial:/dev/ttyS0,baud=115200,name=flow\"\n"
        "  ],\n"
        "  \"routes\": [{\"address\": \"0xDC\", \"link\": \"fc\"}]\n"
        "}");
    page.see_also({"anoctl 1", "anogated 8"});
    return page.str();
}

}    // namespace reference
