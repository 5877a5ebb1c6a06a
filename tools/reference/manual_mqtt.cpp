#include "manual.hpp"
#include "page.hpp"
#include "programs.hpp"

#include <config/help.hpp>
#include <config/keys.hpp>
#include <mqtt/mqtt_config.hpp>

namespace reference {
namespace {

using namespace anogate;

template <class Section>
void write_keys(Page& page, Keys<Section> keys) {
    page.begin_list();
    for (const Key<Section>& key : keys)
        page.item(key.name, placeholder(key) + (key.required ? ", required" : ""), help_of(key, key.text_in(Section{})));
    page.end_list();
}

void write_mqtt_topics(Page& page) {
    page.section("TOPICS");
    page.text("Each begins with anogate/v1/GATEWAY/.");
    page.begin_list();
    page.item(
        "status", "",
        "Retained JSON: online with version, devices and counts; offline when the program was stopped, or by the will of the "
        "connection");
    page.item(
        "up/DEVICE/MESSAGE", "",
        "A record: a message as JSON, with stream and seq, which identify it. DEVICE is the name of the link and the address");
    page.item("backlog/CLASS", "", "Records that could not be published at once: lines of JSON, compressed by zstd");
    page.item("raw/up", "", "With \"raw\": true, received frames unchanged");
    page.item("raw/down", "", "Input, off by default: frames for devices");
    page.item("request/CLIENT", "",
              "Input: {\"method\": \"POST\", \"target\": \"/devices/0x05/commands/TAKE_OFF\", \"body\": {}, \"key\": \"7c1e\", "
              "\"before\": 51200.5}; see anogate-api(7)");
    page.item("response/CLIENT", "",
              "{\"status\": 200, \"key\": \"7c1e\", \"body\": {}}, with the correlation data of the request");
    page.end_list();
    page.text(
        "A request that changes something must be allowed by \"allow\". It needs a key, and an end: before (seconds of the boot "
        "time "
        "of the gateway) or a message expiry. A key is executed once.");
}

void write_mqtt_configuration(Page& page) {
    page.section("CONFIGURATION");
    page.text(
        "JSON with comments (// and /* */). An omitted key has its default; an unknown key is an error. --check lists the "
        "errors, "
        "one per line. A name with a dot is a nested object: \"tls\": {\"ca\": \"FILE\"}.");
    write_keys(page, mqtt_keys());
    page.subsection("messages");
    page.text("A list of objects. Of several for a message, the last one applies.");
    write_keys(page, message_rule_keys());
    page.subsection("log");
    page.text("An object, as in anogate.json(5).");
}

}    // namespace

std::string anogate_mqtt_page() {
    Page page{"anogate-mqtt", 8, "messages of the devices of a gateway at an MQTT broker"};
    page.section("SYNOPSIS");
    page.synopsis("anogate-mqtt", "[options]");
    page.synopsis("anogate-mqtt", "--collect --to FOLDER [options]");
    page.section("DESCRIPTION");
    page.text(
        "anogate-mqtt connects to a running anogated and publishes the messages of its devices to an MQTT 5 broker. What the "
        "broker "
        "does not acknowledge is stored on the disk and published later, by batches. It connects again by itself, whichever of "
        "the "
        "programs is restarted.");
    page.paragraph();
    page.text("With --collect, it receives the records of all gateways and writes each of them once.");
    page.section("OPTIONS");
    page.begin_list();
    const Program program = anogate_mqtt_program();
    for (const Argument& option : program.commands.front().options) {
        std::string names;
        for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + name;
        page.item(names, option.value, option.help);
    }
    page.end_list();
    write_mqtt_topics(page);
    write_mqtt_configuration(page);
    page.section("FILES");
    page.begin_list();
    page.item("/etc/anogate/mqtt.json", "", "Configuration");
    page.item("/var/lib/anogate-mqtt/mqtt/spool.db", "", "Records of the service that the broker did not acknowledge");
    page.item("/usr/share/doc/anogate-mqtt/config", "",
              "Examples: mqtt.json; a mosquitto on a server, AWS IoT Core, ThingsBoard");
    page.item("/etc/default/anogate-mqtt", "", "Environment variables of the service, one NAME=VALUE per line");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "Stopped by SIGTERM or SIGINT");
    page.item("1", "", "--collect: a file can't be read or written");
    page.item("78", "", "The configuration or the command line is invalid");
    page.end_list();
    page.section("EXAMPLES");
    page.text("Publish to a broker on this computer:");
    page.literal("anogate-mqtt --broker localhost:1883 --name drone-1");
    page.text("Collect the records of a fleet:");
    page.literal("anogate-mqtt --collect --broker localhost:1883 --to /var/lib/fleet --mcap");
    page.see_also({"anoctl 1", "anogate.json 5", "anogate-api 7", "anogated 8"});
    return page.str();
}

}    // namespace reference
