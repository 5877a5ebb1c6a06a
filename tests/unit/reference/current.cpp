// The generated files of the repository match the tables. tools/update-generated writes them.
#include <ano/faults.hpp>
#include <ano_json/describe.hpp>
#include <anoctl/text/reference.hpp>
#include <config/config.hpp>
#include <control/control_listeners.hpp>
#include <control/flexible_control.hpp>
#include <control/raw_streams.hpp>
#include <control/recording_routes.hpp>
#include <control/reload_routes.hpp>
#include <control/routes.hpp>
#include <control/watch_session.hpp>
#include <foxglove/foxglove_streams.hpp>
#include <http/task_pool.hpp>
#include <link/kinds.hpp>
#include <mavlink/mavlink_config.hpp>
#include <mqtt/mqtt_config.hpp>
#include <recording/recordings.hpp>
#include <ros2/ros2_config.hpp>
#include <runtime/gateway.hpp>
#include <runtime/gateway_devices.hpp>
#include <runtime/reload.hpp>
#include <sys/asio.hpp>
#include <watch/frame_watch.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <reference/completions.hpp>
#include <reference/manual.hpp>
#include <reference/page.hpp>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <support/files.hpp>

namespace current_tests {
namespace {

using namespace reference;

/// With ANOGATE_UPDATE=1 in the environment the file is overwritten with `made`.
void is_current(const std::string& file, const std::string& made) {
    const auto path = support::source_file(file);
    if (std::getenv("ANOGATE_UPDATE")) std::ofstream{path} << made;
    EXPECT_EQ(support::file_text(path), made) << "run tools/update-generated and commit " << file;
}

TEST(Manual, in_the_repository_matches_the_tables) {
    is_current("tools/man/anogated.8", anogated_page());
    is_current("tools/man/anoctl.1", anoctl_page());
    is_current("tools/man/anogate-ros2.8", anogate_ros2_page());
    is_current("tools/man/anogate-mavlink.8", anogate_mavlink_page());
    is_current("tools/man/anogate-mqtt.8", anogate_mqtt_page());
    is_current("tools/man/anogate.json.5", configuration_page());

    anogate::asio::io_context io;
    anogate::Gateway gateway{io, {}};
    anogate::Reload reload{io, gateway, {}, [] { return anogate::ReadConfig{}; }, {}};
    anogate::GatewayDevices devices{gateway};
    anogate::FrameWatch watch{gateway};
    anogate::FrameStreams frames{gateway, watch};
    anogate::FoxgloveStreams foxglove{gateway, watch, devices.service()};
    anogate::RawStreams raw{gateway};
    anogate::TaskPool disk{io};
    anogate::Recordings recordings{gateway, watch, {}};
    anogate::ControlListeners listener{io, {}};
    anogate::add_routes(listener.routes(), {gateway, devices.service(), frames, foxglove, raw, disk});
    anogate::add_reload_routes(listener.routes(), reload);
    anogate::add_recording_routes(listener.routes(), recordings);
    anogate::FlexibleControl flexible{gateway, {}, {}};
    flexible.add_routes(listener.routes());
    listener.add_login_routes();
    is_current("tools/man/anogate-api.7", api_page(listener.routes().rows()));
}

TEST(Completions, in_the_repository_match_the_tables) {
    for (const Program& program :
         {anogated_program(), anoctl_program(), anogate_ros2_program(), anogate_mavlink_program(), anogate_mqtt_program()}) {
        is_current("tools/completions/" + program.name + ".bash", bash_completion(program));
        is_current("tools/completions/_" + program.name, zsh_completion(program));
        is_current("tools/completions/" + program.name + ".fish", fish_completion(program));
    }
}

TEST(Schema, in_the_repository_matches_the_tables) {
    is_current("config/anogate.schema.json", anogate::config_schema(anogate::link_kinds()));
    is_current("config/ros2.schema.json", anogate::ros2_config_schema());
    is_current("config/mavlink.schema.json", anogate::mavlink_config_schema());
    is_current("config/mqtt.schema.json", anogate::mqtt_config_schema());
}

TEST(Messages, in_the_repository_match_the_table) {
    std::ostringstream markdown;
    anoctl::write_markdown(markdown);
    is_current("include/ano/messages.md", markdown.str());
    std::string rows = "[";    // for tests of the page
    for (const auto& row : ano::describe_all({})) rows += (rows.size() > 1 ? ",\n" : "\n") + row.dump();
    is_current("src/web/test/messages.json", rows + "\n]\n");
}

TEST(Faults, in_the_repository_match_the_table) {
    std::string rows;
    for (const ano::FaultRow& row : ano::fault_rows)
        rows += "  " + std::string{row.id} + ": " + nlohmann::json(row.chinese).dump() + ",\n";
    is_current("src/web/src/faults.ts",
               "// The Chinese texts of include/ano/faults.hpp. Made by tools/update-generated.\n"
               "export const faults: Record<string, string> = {\n" +
                   rows + "};\n");
}

TEST(Page, escapes_text_that_looks_like_commands) {
    Page page{"a-b", 7, "nothing"};
    page.section("S");
    page.text(".Sh it is not. A --flag and a \\n");
    page.begin_list();
    page.item("\"name\"", "Ar Xr", "'x");
    page.end_list();
    EXPECT_NE(page.str().find("\n\\&.Sh it is not.\nA \\-\\-flag and a \\en\n"), std::string::npos) << page.str();
    EXPECT_NE(page.str().find(".It Cm \"\\&\"\"name\"\"\" Ar \"\\&Ar Xr\"\n\\&'x\n"), std::string::npos) << page.str();
}

TEST(Page, has_one_sentence_per_line) {
    Page page{"x", 7, "nothing"};
    page.text("One. Two at 1.5 s, e. g. here. Three");
    EXPECT_NE(page.str().find("\nOne.\nTwo at 1.5 s, e. g. here.\nThree\n"), std::string::npos) << page.str();
}

TEST(Programs, list_the_completions_of_each_kind_of_value) {
    const auto of = [](const char* value) { return Argument{{}, value, ""}; };
    EXPECT_EQ(of("utf8|gbk").words(), (std::vector<std::string>{"utf8", "gbk"}));
    EXPECT_EQ(of("flood|drop|LINK").words(), (std::vector<std::string>{"flood", "drop"}));
    EXPECT_EQ(of("[HEX|FILE|-]").offer(), Offer::files);
    EXPECT_EQ(of("LINK...").offer(), Offer::links);
    EXPECT_EQ((Argument{{"--link"}, "LINK...", ""}).offer(), Offer::link_names);
    EXPECT_EQ(of("[LINK...]").offer(), Offer::link_names);
    EXPECT_EQ(of("ADDRESS...").offer(), Offer::addresses);
    EXPECT_EQ(of("in|out|dropped...").words(), (std::vector<std::string>{"in", "out", "dropped"}));
    EXPECT_EQ(of("ID...").offer(), Offer::messages);
    EXPECT_EQ(of("N").offer(), Offer::nothing);
}

TEST(Programs, list_the_names_of_single_addresses) {
    const std::vector<std::string> names = address_names();
    const auto has = [&](const char* name) { return std::find(names.begin(), names.end(), name) != names.end(); };
    for (const char* name : {"host", "flight_controller", "ros_2_bridge", "broadcast"}) EXPECT_TRUE(has(name)) << name;
    for (const char* name : {"port", "user_device", "reserved", "unassigned"}) EXPECT_FALSE(has(name)) << name;
}

}    // namespace
}    // namespace current_tests
