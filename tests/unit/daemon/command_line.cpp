#include <gtest/gtest.h>
#include <config/config.hpp>
#include <daemon/command_line.hpp>
#include <http/client/certificate.hpp>
#include <support/changed_certificate.hpp>
#include <support/files.hpp>
#include <support/temp_dir.hpp>

#include <algorithm>
#include <filesystem>
#include <sstream>

namespace anogate::command_line_tests {
namespace {

using Parsed = std::variant<CommandLine, Exit>;

Parsed parse(std::vector<const char*> arguments, const std::string& default_file = "/proc/nonexistent/anogate.json") {
    arguments.insert(arguments.begin(), "anogated");
    return parse_command_line(static_cast<int>(arguments.size()), arguments.data(), default_file);
}

CommandLine line_of(std::vector<const char*> arguments, const std::string& default_file = "/proc/nonexistent/anogate.json") {
    const Parsed parsed = parse(std::move(arguments), default_file);
    if (const Exit* exit = std::get_if<Exit>(&parsed)) {
        ADD_FAILURE() << exit->text;
        return {};
    }
    return std::get<CommandLine>(parsed);
}

Settings settings_of(std::vector<const char*> arguments) { return line_of(std::move(arguments)).settings; }

Exit exit_of(std::vector<const char*> arguments) {
    const Parsed parsed = parse(std::move(arguments));
    const Exit* exit = std::get_if<Exit>(&parsed);
    EXPECT_NE(exit, nullptr);
    return exit != nullptr ? *exit : Exit{};
}

/// The text on standard error; the exit code must be 78.
std::string error_of(std::vector<const char*> arguments) {
    const Exit exit = exit_of(std::move(arguments));
    EXPECT_EQ(exit.code, 78);
    return exit.text;
}

TEST(CommandLine, reads_links_and_options) {
    const Settings s = settings_of({"--id", "199", "serial:/dev/ttyUSB0,name=fc", "--route", "0xDC=fc",
                                    "udp-listen:0.0.0.0:12333", "--route=30-40=fc", "--unknown", "fc", "--control", "/tmp/c.sock",
                                    "--log-level", "debug"});
    ASSERT_EQ(s.links.size(), 2u);
    EXPECT_EQ(s.links[0].name, "fc");
    EXPECT_EQ(s.links[1].kind->name, "udp-listen");
    EXPECT_EQ(s.gateway.id, 199);
    EXPECT_EQ(s.gateway.unknown, Unknown::link);
    EXPECT_EQ(s.gateway.unknown_link, "fc");
    EXPECT_EQ(s.routes, (std::vector<RouteSettings>{{220, 220, "fc"}, {30, 40, "fc"}}));
    EXPECT_EQ(s.control.socket, "/tmp/c.sock");
    EXPECT_EQ(s.log.level, "debug");
}

TEST(CommandLine, a_file_in_place_of_a_link_is_suggested_as_the_configuration) {
    EXPECT_EQ(error_of({"g.json"}), "anogated: LINK 'g.json': is not a link (did you mean --config g.json?)\n");
    const support::TempDir folder;
    const std::string file = folder.write("gateway", "{}");
    EXPECT_EQ(error_of({file.c_str()}), "anogated: LINK '" + file + "': is not a link (did you mean --config " + file + "?)\n");
}

TEST(CommandLine, links_add_to_the_file_and_options_override_it) {
    const support::TempDir folder;
    const std::string file = folder.write("a.json",
                                          R"({"gateway": {"id": 5, "name": "boat", "unknown": "nobody"}, "links": ["sim:fc"],
        "routes": [{"address": 220, "link": "app"}], "log": {"level": "warn"}})");
    const Settings s = settings_of(
        {"-c", file.c_str(), "pty:/tmp/app", "--id=0x06", "--unknown=drop", "--log-level=error", "--control=none"});
    ASSERT_EQ(s.links.size(), 2u);
    EXPECT_EQ(s.links[1].name, "app");
    EXPECT_EQ(s.gateway, (GatewaySettings{6, "boat", Unknown::drop, "", std::chrono::seconds{30}}));
    EXPECT_EQ(s.routes.size(), 1u);
    EXPECT_EQ(s.log.level, "error");
    EXPECT_EQ(s.control.socket, "none");
}

TEST(CommandLine, the_last_value_of_an_option_applies) {
    EXPECT_EQ(settings_of({"sim:fc", "--id", "5", "--id", "6"}).gateway.id, 6);
}

TEST(CommandLine, two_configuration_files_are_rejected) {
    EXPECT_EQ(error_of({"--config", "/proc/nonexistent", "-c", "/proc/neither"}),
              "anogated: --config: was given 2 times; only one file is allowed\n"
              "anogated: /proc/nonexistent: No such file or directory\n");
}

TEST(CommandLine, a_control_socket_that_cannot_be_created_is_an_error) {
    EXPECT_EQ(error_of({"sim:fc", "--control", "/proc/nonexistent/c.sock"}),
              "anogated: --control: /proc/nonexistent/c.sock: there is no folder /proc/nonexistent (use --control with another "
              "path, or --control none)\n");
    const support::TempDir folder;
    const std::string file = folder.write("a.json", R"({"control": {"socket": "/proc/nonexistent/c.sock"}})");
    EXPECT_EQ(error_of({"--check", "--config", file.c_str()})
                  .rfind("anogated: " + file + ": /control/socket: /proc/nonexistent/c.sock: there", 0),
              0u);
    EXPECT_EQ(settings_of({"--config", file.c_str(), "--print-config"}).control.socket, "/proc/nonexistent/c.sock")
        << "maybe for another machine";
}

TEST(CommandLine, a_path_that_the_service_may_not_write_is_an_error_in_a_check) {
    const support::TempDir folder;
    const std::string file = folder.write("anogate.json", R"({"links": ["pty:/tmp/app"]})");
    const auto checked = parse({"--check"}, file);
    ASSERT_TRUE(std::holds_alternative<Exit>(checked));
    EXPECT_NE(std::get<Exit>(checked).text.find("'path' '/tmp/app': the service has no write access there"), std::string::npos);
    EXPECT_EQ(line_of({}, file).settings.links.size(), 1u) << "the other links are not to suffer";
    EXPECT_TRUE(line_of({"--check", "--config", file.c_str()}).check)
        << "not the service's: that has its own in /proc/nonexistent";
}

TEST(CommandLine, a_check_warns_of_paths_that_cannot_be_created) {
    const support::TempDir folder;
    const std::string there = folder.path(), file = folder.write("file", "words");
    const auto warnings = [](const std::string& link) { return line_of({"--check", link.c_str()}).warnings; };
    EXPECT_EQ(warnings("pty:" + there + "/none/app"), "anogated: LINK 'pty:" + there + "/none/app': warning: 'path' '" + there +
                                                          "/none/app': there is no folder " + there +
                                                          "/none: anogated waits for it and does not create it\n");
    EXPECT_NE(warnings("pty:" + file + "/app").find(file + " is not a folder"), std::string::npos);
    EXPECT_NE(warnings("pty:" + file).find("another file exists there"), std::string::npos);
    EXPECT_EQ(warnings("pty:" + there + "/app"), "");
    std::filesystem::create_symlink("/dev/null", there + "/by-path");
    std::filesystem::create_symlink("/dev/null", there + "/ttyUSB0");
    const std::string one = "serial:" + there + "/by-path,name=a", two = "serial:" + there + "/ttyUSB0,name=b";
    EXPECT_NE(line_of({"--check", one.c_str(), two.c_str()})
                  .warnings.find("is the same device as '" + there + "/by-path' of another link; only one link can open it"),
              std::string::npos);
    EXPECT_EQ(warnings(one).find("same device"), std::string::npos);
    EXPECT_EQ(line_of({"--check", one.c_str(), (two + ",enabled=no").c_str()}).warnings.find("same device"), std::string::npos);
    EXPECT_EQ(warnings("pty:/run/anogate/app"), "") << "that one is made";
    EXPECT_NE(warnings("serial:" + there + ",baud=500000").find("': is a folder; give the path of the serial port"),
              std::string::npos);
    EXPECT_NE(warnings("serial:" + file + ",baud=500000").find("': is a regular file, not a serial port"), std::string::npos);
    EXPECT_NE(warnings("hid:" + file).find("': is a regular file, not a hidraw device; `anoctl ports` lists the devices"),
              std::string::npos)
        << warnings("hid:" + file);
    EXPECT_EQ(warnings("serial:/dev/null,baud=500000"), "");
    EXPECT_NE(warnings("serial:/dev/serial/by-id/usb-1a86_USB_Serial-if00-port0,baud=500000")
                  .find("': its adapter has no serial number, so after replugging this name may belong to another adapter"),
              std::string::npos);
    EXPECT_EQ(warnings("serial:/dev/nonexistent,baud=500000"), "") << "it is waited for";
    EXPECT_NE(
        warnings("replay:" + there + "/none.mcap").find("'file' '" + there + "/none.mcap': not found; anogated waits for it"),
        std::string::npos);
    EXPECT_NE(warnings("replay:" + there).find("'file' '" + there + "': is not a regular file"), std::string::npos);
    EXPECT_EQ(warnings("replay:" + file), "");
    const auto of_log = [&](const std::string& path) {
        const std::string config = folder.write("log.json", R"({"links": ["sim:fc"], "log": {"file": ")" + path + "\"}}");
        return line_of({"--check", "--config", config.c_str()}).warnings;
    };
    EXPECT_NE(of_log(there + "/none/a.log").find("/log/file: warning: 'file' '" + there + "/none/a.log': there is no folder"),
              std::string::npos);
    EXPECT_NE(of_log(there).find("is a folder: logging to standard error"), std::string::npos);
    EXPECT_EQ(of_log(there + "/a.log"), "");
    EXPECT_EQ(line_of({("pty:" + file).c_str()}).warnings, "") << "the link itself says so when it starts";
    const auto of_recordings = [&](const std::string& path) {
        const std::string config = folder.write("record.json", R"({"links": ["sim:fc"], "record": {"folder": ")" + path + "\"}}");
        return line_of({"--check", "--config", config.c_str()}).warnings;
    };
    EXPECT_NE(of_recordings(file).find("/record/folder: warning: 'folder' '" + file + "': is not a folder: nothing is recorded"),
              std::string::npos)
        << of_recordings(file);
    EXPECT_NE(of_recordings(file + "/sub").find("is below a file: nothing is recorded"), std::string::npos);
    EXPECT_EQ(of_recordings(there), "");
    EXPECT_EQ(of_recordings(there + "/none"), "") << "it is created";
}

TEST(CommandLine, a_check_warns_of_a_missing_network_interface) {
    const auto warnings = [](const std::string& link) { return line_of({"--check", link.c_str()}).warnings; };
    for (const char* link : {"tcp:[fe80::1%nonesuch0]:5", "udp:[fe80::1%nonesuch0]:5", "tcp-listen:[fe80::1%nonesuch0]:5"})
        EXPECT_NE(warnings(link).find("warning: network interface 'nonesuch0' not found: the link waits for it"),
                  std::string::npos)
            << link << warnings(link);
    EXPECT_EQ(warnings("tcp:[fe80::1%lo]:5"), "");
    EXPECT_EQ(warnings("tcp:[fe80::1%1]:5"), "") << "by its number";
}

TEST(CommandLine, a_check_warns_of_settings_that_keep_the_http_interface_off) {
    const support::TempDir folder;
    const std::string certificate = folder / "certificate.pem", key = folder / "key.pem", other = folder / "other.pem";
    ASSERT_TRUE(http::make_certificate({{"vehicle"}, {}}, certificate, key));
    ASSERT_TRUE(http::make_certificate({{"vehicle"}, {}}, folder / "other_certificate.pem", other));
    const std::string tokens = folder / "state/token";
    const auto warnings = [&](const std::string& its_certificate, const std::string& its_key, const std::string& its_tokens) {
        const std::string file = folder.write(
            "listener.json", R"({"links": ["sim:fc"], "control": {"http": "127.0.0.1:0", "token_file": ")" + its_tokens +
                                 R"(", "tls": {"certificate": ")" + its_certificate + R"(", "key": ")" + its_key + R"("}}})");
        std::string text = line_of({"--check", "--config", file.c_str()}).warnings;
        const std::string begin = "anogated: " + file + ": /control/";
        for (std::size_t at = 0; (at = text.find(begin)) != text.npos;) text.erase(at, begin.size());
        return text;
    };
    EXPECT_EQ(warnings(certificate, key, tokens), "");
    EXPECT_FALSE(std::filesystem::exists(folder / "state")) << "nothing is made";
    const std::string none = folder / "none.pem", shut = "warning: control.http stays off: ";
    EXPECT_EQ(warnings(none, key, tokens), "tls: " + shut + none + ": No such file or directory\n");
    EXPECT_EQ(warnings(certificate, none, tokens), "tls: " + shut + none + ": No such file or directory\n");
    EXPECT_EQ(warnings(certificate, folder.path().string(), tokens),
              "tls: " + shut + folder.path().string() + ": is not a file\n");
    EXPECT_NE(warnings(key, key, tokens).find("tls: " + shut + key + ": "), std::string::npos) << "it has no certificate";
    EXPECT_NE(warnings(certificate, other, tokens).find("tls: " + shut + other + ": "), std::string::npos) << "of another one";
    const std::string words = folder.write("words", "admin 0123456789abcdef");
    std::filesystem::permissions(words, std::filesystem::perms{0600});
    EXPECT_EQ(warnings(certificate, key, words),
              "token_file: " + shut + words + ": line 1: a line must be 'view TOKEN' or 'control TOKEN'\n");
    EXPECT_EQ(warnings(certificate, key, words + "/token"), "token_file: " + shut + words + "/token: Not a directory\n");
    const std::string closed = folder.write("closed.json",
                                            R"({"links": ["sim:fc"], "control": {"token_file": ")" + words + "\"}}");
    EXPECT_EQ(line_of({"--check", "--config", closed.c_str()}).warnings, "") << "there is no listener";
}

TEST(CommandLine, a_check_warns_of_a_key_that_slows_down_new_connections) {
    const support::TempDir folder;
    const std::string certificate = folder / "c.pem", key = folder / "k.pem";
    const std::string file = folder.write(
        "listener.json", R"({"links": ["sim:fc"], "control": {"http": "127.0.0.1:0", "tls": {"certificate": ")" + certificate +
                             R"(", "key": ")" + key + R"("}}})");
    const auto warnings = [&](int bits) {
        const std::string made = "openssl req -x509 -nodes -subj /CN=x -newkey rsa:" + std::to_string(bits) + " -keyout " + key +
                                 " -out " + certificate + " 2>/dev/null";
        EXPECT_EQ(std::system(made.c_str()), 0);
        std::filesystem::permissions(key, std::filesystem::perms{0600});
        return line_of({"--check", "--config", file.c_str()}).warnings;
    };
    EXPECT_NE(warnings(3072).find("an RSA key of 3072 bits slows down every new connection"), std::string::npos);
    EXPECT_EQ(warnings(2048).find("RSA"), std::string::npos);
}

TEST(CommandLine, a_check_warns_of_a_certificate_of_the_page_that_is_not_valid) {
    const support::TempDir folder;
    const std::string certificate = folder / "c.pem", key = folder / "k.pem";
    const std::string file = folder.write(
        "listener.json", R"({"links": ["sim:fc"], "control": {"http": "127.0.0.1:0", "tls": {"certificate": ")" + certificate +
                             R"(", "key": ")" + key + R"("}}})");
    const auto warnings = [&](int days) {
        const std::string made = "openssl req -x509 -nodes -subj /CN=x -newkey rsa:2048 -days " + std::to_string(days) +
                                 " -keyout " + key + " -out " + certificate + " 2>/dev/null";
        EXPECT_EQ(std::system(made.c_str()), 0);
        std::filesystem::permissions(key, std::filesystem::perms{0600});
        return line_of({"--check", "--config", file.c_str()}).warnings;
    };
    EXPECT_EQ(warnings(100).find(certificate), std::string::npos);
    EXPECT_NE(warnings(9).find("tls: warning: " + certificate + ": the certificate expires in "), std::string::npos);
    ASSERT_TRUE(support::postpone_validity(certificate, key));
    EXPECT_NE(line_of({"--check", "--config", file.c_str()}).warnings.find(certificate + ": the certificate is not valid yet"),
              std::string::npos);
}

TEST(CommandLine, a_check_explains_once_the_risk_of_ports_open_to_all_networks) {
    const auto said = [](std::vector<const char*> links) {
        links.insert(links.begin(), "--check");
        const CommandLine line = line_of(links);
        EXPECT_TRUE(line.check) << "it is no fault";
        return line.warnings;
    };
    EXPECT_EQ(said({"sim:fc", "udp-listen:0.0.0.0:5,name=ground", "udp-listen:[::]:6,name=tablet,allow=any"}),
              "anogated: LINK 'udp-listen:0.0.0.0:5,name=ground': note: 'ground', 'tablet': any host on the local networks can "
              "send commands to this port, and source addresses can be spoofed; on untrusted networks bind a single address, "
              "restrict 'allow', and use WireGuard (config/README.md: On a shared Wi-Fi)\n");
    for (const char* link :
         {"udp-listen:127.0.0.1:5", "udp-listen:192.168.1.5:5", "udp-listen:0.0.0.0:5,allow=10.77.0.0/24",
          "udp-listen:0.0.0.0:5,interface=wg0", "udp:192.168.1.5:5", "tcp-listen:0.0.0.0:5,allow=10.77.0.0/24"})
        EXPECT_EQ(said({link}), "") << link;
    EXPECT_EQ(line_of({"udp-listen:0.0.0.0:5"}).warnings, "") << "only a check says it";
    EXPECT_EQ(said({"tcp-listen:0.0.0.0:5,name=bridge"}),
              "anogated: LINK 'tcp-listen:0.0.0.0:5,name=bridge': note: 'bridge': any host on the local networks can send "
              "commands to this port; on untrusted networks bind a single address, restrict 'allow', and use tls-listen or "
              "WireGuard\n");
}

TEST(CommandLine, a_check_reports_no_warnings_for_the_examples) {
    std::size_t examples = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator{support::source_file("config/examples")}) {
        if (entry.path().extension() != ".json") continue;
        ++examples;
        const CommandLine line = line_of({"--check", "--config", entry.path().c_str()});
        EXPECT_TRUE(line.check) << entry.path();
        EXPECT_EQ(line.warnings, "") << entry.path();
    }
    EXPECT_GE(examples, 5u);
}

TEST(CommandLine, the_default_file_is_where_the_program_was_installed) {
    const support::TempDir folder;
    const std::filesystem::path prefix = folder.path();
    EXPECT_EQ(config_file_of("/usr/local/bin/anogated"), "/etc/anogate/anogate.json");
    EXPECT_EQ(config_file_of("/usr/bin/anogated"), "/etc/anogate/anogate.json");
    EXPECT_EQ(config_file_of(prefix / "bin/anogated"), "/etc/anogate/anogate.json") << "nothing is installed there";
    std::filesystem::create_directories(prefix / "etc/anogate");
    EXPECT_EQ(config_file_of(prefix / "bin/anogated"), (prefix / "etc/anogate/anogate.json").string());
    EXPECT_EQ(config_file_of(prefix / "src/anogated"), "/etc/anogate/anogate.json") << "a build tree";
}

TEST(CommandLine, the_default_file_is_read_when_neither_file_nor_link_is_named) {
    const support::TempDir folder;
    const std::string file = folder.write("default.json", R"({"gateway": {"name": "default"}})");
    EXPECT_EQ(line_of({}, file).settings.gateway.name, "default");
    EXPECT_EQ(line_of({}, file).config_file, file);
    EXPECT_EQ(line_of({"sim:fc"}, file).settings.gateway.name, "anogate");
    EXPECT_EQ(line_of({"sim:fc"}, file).config_file, "");
}

TEST(CommandLine, without_a_default_file_it_explains_what_to_do) {
    EXPECT_EQ(error_of({}),
              "anogated: /proc/nonexistent/anogate.json: No such file or directory; create it, or give links, for example: "
              "anogated serial:/dev/ttyUSB0,baud=500000,profile=vendor udp-listen:0.0.0.0:12333\n");
}

TEST(CommandLine, an_unreadable_file_is_reported_in_one_line) {
    const support::TempDir folder;
    EXPECT_EQ(error_of({"-c", "/proc/nonexistent"}), "anogated: /proc/nonexistent: No such file or directory\n");
    EXPECT_EQ(error_of({"-c", folder.path().c_str()}), "anogated: " + folder.path().string() + ": Is a directory\n");
    EXPECT_EQ(error_of({"-c", "/dev/zero"}), "anogated: /dev/zero: is not a regular file but a pipe, socket or device\n");
    const std::string file = folder.write("a.json", "{\n,");
    EXPECT_EQ(error_of({"-c", file.c_str(), "--route", "5=x"}),
              "anogated: " + file +
                  ": line 2, column 1: syntax error while parsing object key - unexpected ','; expected string literal\n");
}

TEST(CommandLine, every_error_is_reported_in_one_line) {
    const support::TempDir folder;
    const std::string file = folder.write("a.json", R"({"links": [{"kind": "serial", "device": "/dev/x", "bauds": 9}]})");
    EXPECT_EQ(error_of({"-c", file.c_str(), "serial:/dev/y,bauds=9", "--chek", "--id", "300", "--route", "nowhere"}),
              "anogated: unknown option '--chek' (did you mean '--check'?)\n"
              "anogated: " +
                  file +
                  ": /links/0/bauds: unknown key 'bauds' (did you mean 'baud'?)\n"
                  "anogated: LINK 'serial:/dev/y,bauds=9': unknown key 'bauds' (did you mean 'baud'?)\n"
                  "anogated: --route 'nowhere': must be ADDR=LINK such as 0xDC=fc\n"
                  "anogated: --id: 'id' must be an address from 1 to 254 (or in hex such as 0x05), not '300'\n");
}

TEST(CommandLine, routes_and_unknown_must_name_existing_links) {
    EXPECT_EQ(error_of({"sim:fc", "--route", "5=fd", "--unknown", "app"}),
              "anogated: --unknown: there is no link 'app'; use flood, drop, or one of fc\n"
              "anogated: --route '5=fd': there is no link 'fd' (did you mean 'fc'?); use one of fc\n");
}

TEST(CommandLine, an_address_without_0x_is_recognized) {
    EXPECT_EQ(
        error_of({"sim:fc", "--id", "C7", "--route", "DC=fc", "--route", "0xDC-DE=fc"}),
        "anogated: --route 'DC=fc': 'address' must be an address such as 0xDC or a range such as 30-40, from 1 to 254, not "
        "'DC' (did you mean '0xDC'?)\n"
        "anogated: --route '0xDC-DE=fc': 'address' must be an address such as 0xDC or a range such as 30-40, from 1 to 254, "
        "not '0xDC-DE' (did you mean '0xDC-0xDE'?)\n"
        "anogated: --id: 'id' must be an address from 1 to 254 (or in hex such as 0x05), not 'C7' (did you mean '0xC7'?)\n");
}

TEST(CommandLine, several_routes_in_one_option_are_rejected) {
    EXPECT_EQ(error_of({"sim:fc", "--route", "0xDC=fc,0xDD=fc"}),
              "anogated: --route '0xDC=fc,0xDD=fc': must be one ADDR=LINK; repeat --route for more\n");
}

TEST(CommandLine, an_option_without_its_value_is_a_fault) {
    const std::string error = error_of({"sim:fc", "--id"});
    EXPECT_EQ(error.rfind("anogated: --id", 0), 0u) << error;
    EXPECT_EQ(error.find('\n'), error.size() - 1);
}

TEST(CommandLine, an_option_does_not_use_the_next_option_as_its_value) {
    for (const char* option : {"--config", "--log-level", "--route", "--id", "--unknown", "--control"})
        EXPECT_EQ(error_of({"sim:fc", option, "--check"}),
                  "anogated: " + std::string{option} + ": the value is missing before '--check'\n");
}

TEST(CommandLine, a_key_of_a_link_is_not_an_option) {
    EXPECT_EQ(error_of({"sim:fc", "--baud=9600"}),
              "anogated: unknown option '--baud': it is a key of a LINK: write KIND:ADDRESS,baud=NUMBER\n");
    EXPECT_EQ(error_of({"--check", "--bla"}), "anogated: unknown option '--bla'; --help all lists all options\n")
        << "the default file is not to blame";
    EXPECT_EQ(error_of({"sim:fc", "-v"}), "anogated: unknown option '-v'; --help all lists all options\n");
}

TEST(CommandLine, check_and_print_config_apply_only_to_a_valid_command_line) {
    EXPECT_FALSE(line_of({"sim:fc"}).check);
    EXPECT_FALSE(line_of({"sim:fc"}).print_config);
    EXPECT_TRUE(line_of({"sim:fc", "--check"}).check);
    EXPECT_TRUE(line_of({"sim:fc", "--print-config"}).print_config);
    EXPECT_EQ(error_of({"sim:plane", "--check"}),
              "anogated: LINK 'sim:plane': 'device' must be one of fc, imu, flow, radio, car, lx, not 'plane'\n");
}

TEST(CommandLine, has_the_same_meaning_when_printed_as_a_file) {
    const Settings said = settings_of(
        {"--id", "199", "serial:/dev/ttyUSB0,baud=9600,rts", "udp-listen:[::]:12333,allow=any", "--route", "30-40=ttyUSB0"});
    const support::TempDir folder;
    const std::string file = folder.write("a.json", print_config(said));
    EXPECT_EQ(settings_of({"--config", file.c_str()}), said);
}

TEST(CommandLine, prints_help_and_version) {
    const Exit brief = exit_of({"--help"});
    EXPECT_EQ(brief.code, 0);
    EXPECT_LE(std::count(brief.text.begin(), brief.text.end(), '\n'), 24) << "a screen of a terminal: " << brief.text;
    std::istringstream lines{brief.text};
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
    for (const char* word : {"serial:", "udp-listen:", "can:", "--help all", "--version", "Example: "})
        EXPECT_NE(brief.text.find(word), std::string::npos) << word;
    EXPECT_EQ(exit_of({"-V"}).text, exit_of({"--version"}).text);
    const Exit help = exit_of({"--help", "all"});
    EXPECT_EQ(help.code, 0);
    for (const char* word : {"--config FILE", "--id", "--route", "--unknown", "--control", "--check", "--print-config",
                             "--log-level", "--version", "--help", "serial:", "udp-listen:", "baud=", "forget_after"})
        EXPECT_NE(help.text.find(word), std::string::npos) << word;
    const Exit version = exit_of({"--version"});
    EXPECT_EQ(version.code, 0);
    EXPECT_EQ(version.text.rfind("anogated ", 0), 0u);
    EXPECT_EQ(version.text.back(), '\n');
}

}    // namespace
}    // namespace anogate::command_line_tests
