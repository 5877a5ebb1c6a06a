#include "manual.hpp"
#include "page.hpp"
#include "programs.hpp"

#include <config/help.hpp>
#include <config/keys.hpp>
#include <ros2/ros2_config.hpp>
#include <ros2/topic_table.hpp>

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

void write_topics(Page& page) {
    page.section("TOPICS");
    page.text("Each begins with /PREFIX/. A topic is created when its first message is published.");
    page.begin_list();
    for (const TopicRow& row : topic_table()) {
        std::string words = full_name(*row.type) + ", from " + format_sources(row);
        if (!row.needs.empty()) words += "; needs " + std::string{row.needs};
        page.item(row.name, "", words);
    }
    page.item("raw/NAME", "", "ano_msgs/msg/NAME: every message of the protocol, and flexible messages with a layout");
    page.item(
        "cmd_vel", "",
        "Input, off by default: geometry_msgs/msg/Twist, forwarded as 0x41 while 0x06 reports one of velocity_modes. After 0.5 s "
        "without a message, one frame with zero velocities is sent, then none");
    page.item("joy", "", "Input, off by default: sensor_msgs/msg/Joy with ten axes from -1 to 1, forwarded as 0x40");
    page.item("command", "",
              "Input, off by default: std_msgs/msg/String with {\"command\": \"TAKE_OFF\", \"values\": [150], \"id\": \"7\"}. "
              "The result "
              "is published on command_result");
    page.end_list();
    page.text("Besides, /diagnostics once per second, and /tf if \"tf\" is true.");
}

void write_configuration(Page& page) {
    page.section("CONFIGURATION");
    page.text(
        "JSON with comments (// and /* */). An omitted key has its default; an unknown key is an error. --check lists the "
        "errors, "
        "one per line.");
    write_keys(page, ros2_keys());
    page.subsection("qos");
    page.text(
        "An object: the name of a topic without its prefix, \"raw\", \"tf\" or \"diagnostics\", and \"reliable\" (the default) "
        "or "
        "\"best_effort\".");
    page.subsection("variances");
    page.text("An object: variances for the covariances of messages. One that is not set is 0, which means unknown.");
    page.begin_list();
    for (const VarianceKey& key : variance_keys()) page.item(key.name, "NUMBER", key.help);
    page.end_list();
    page.subsection("devices");
    page.text("A list of objects:");
    write_keys(page, ros2_device_keys());
    page.begin_list();
    page.item("velocity_modes", "[NUMBER, ...]", velocity_modes_help);
    page.end_list();
    page.subsection("log");
    page.text("An object, as in anogate.json(5).");
}

}    // namespace

std::string anogate_ros2_page() {
    Page page{"anogate-ros2", 8, "ROS 2 topics of the devices of a gateway"};
    page.section("SYNOPSIS");
    page.synopsis("anogate-ros2", "[options]");
    page.section("DESCRIPTION");
    page.text(
        "anogate-ros2 connects to a running anogated as the bridge 0xD2, and publishes the messages of its devices as ROS 2 "
        "topics "
        "over DDS (Fast DDS, UDP). ROS is not needed. It connects again by itself, whichever of the two programs is restarted.");
    page.paragraph();
    page.text(
        "The program was tested with CycloneDDS and Fast DDS, not with an installation of ROS 2. ros2 topic info -v shows its "
        "node as "
        "_CREATED_BY_BARE_DDS_APP_. There are no services: the two common middlewares of ROS 2 encode requests differently.");
    page.section("OPTIONS");
    page.begin_list();
    const Program program = anogate_ros2_program();
    for (const Argument& option : program.commands.front().options) {
        std::string names;
        for (const std::string& name : option.names) names += (names.empty() ? "" : ", ") + name;
        page.item(names, option.value, option.help);
    }
    page.end_list();
    write_topics(page);
    write_configuration(page);
    page.section("FILES");
    page.begin_list();
    page.item("/etc/anogate/ros2.json", "", "Configuration; the program also runs without it");
    page.item("/usr/share/doc/anogate-ros2/config/ros2.json", "", "Example, with what robot_localization expects");
    page.item("/etc/default/anogate-ros2", "", "Environment variables of the service, one NAME=VALUE per line");
    page.end_list();
    page.section("EXIT STATUS");
    page.begin_list();
    page.item("0", "", "Stopped by SIGTERM or SIGINT");
    page.item("1", "", "--list: the gateway can't be reached");
    page.item("78", "", "The configuration or the command line is invalid");
    page.end_list();
    page.section("EXAMPLES");
    page.text("Show the topics and why some are silent:");
    page.literal("anogate-ros2 --list");
    page.text("Not tried, because no ROS 2 was available:");
    page.literal(
        "ros2 topic echo /fc/imu/data\nros2 topic hz /fc/odom\n"
        "ros2 topic pub -r 20 /drone1/cmd_vel geometry_msgs/msg/Twist '{linear: {x: 0.5}}'");
    page.see_also({"anoctl 1", "anogate.json 5", "anogated 8"});
    return page.str();
}

}    // namespace reference
