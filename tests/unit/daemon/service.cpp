#include <daemon/service.hpp>
#include <support/temp_dir.hpp>
#include <unit/config/faults.hpp>

#include <gtest/gtest.h>

namespace anogate::service_tests {
namespace {

/// The parts of a configuration that the service does not support, one per line.
std::string faults(std::string_view json, const std::string& config_file = {}) {
    Draft draft = parse_config(json, "a.json");
    EXPECT_EQ(lines(draft.errors), "");
    check_for_service(draft, config_file);
    std::string text;
    for (const ConfigError& error : draft.errors) text += error.where + ": " + error.what + "\n";
    return text;
}

std::string or_elsewhere(std::string_view fault) {
    std::string text{fault};
    return text.append(" (to allow another folder: systemctl edit anogated, ReadWritePaths=FOLDER)\n");
}

TEST(Service, may_write_to_its_folders) {
    EXPECT_EQ(
        faults(R"({"links": ["pty:/run/anogate/app", "pty:/run/anogate/more/app", "pty:/dev/shm/x", "pty:/var/log/anogate/y"],
        "log": {"file": "/var/log/anogate/log"}, "control": {"socket": "/run/anogate/c.sock"}})"),
        "");
    EXPECT_EQ(faults(R"({"links": ["sim:fc"], "control": {"socket": "none"}})"), "");
}

TEST(Service, cannot_write_outside_its_folders) {
    EXPECT_EQ(faults(R"({"links": ["sim:fc", "pty:/tmp/app"]})"),
              std::string{"a.json: /links/1: LINK 'pty:/tmp/app': 'path' '/tmp/app': the service has no write access there, and "
                          "its /tmp is private; /run/anogate/app works\n"});
    EXPECT_EQ(faults(R"({"links": [{"kind": "pty", "path": "/home/pi/fc"}]})"),
              or_elsewhere(
                  "a.json: /links/0/path: 'path' '/home/pi/fc': the service has no write access there; /run/anogate/fc works"));
    EXPECT_EQ(faults(R"({"log": {"file": "/var/log/anogate.log"}})"),
              or_elsewhere("a.json: /log/file: 'file' '/var/log/anogate.log': the service has no write access there; "
                           "/var/log/anogate/anogate.log works"));
    EXPECT_EQ(faults(R"({"control": {"socket": "/tmp/c"}})"),
              "a.json: /control/socket: 'socket' '/tmp/c': the service has no write access there, and its /tmp is private; "
              "/run/anogate/c works\n");
}

TEST(Service, records_in_its_state_folder) {
    EXPECT_EQ(faults(R"({"record": {}})"), "");
    EXPECT_EQ(faults(R"({"record": {"folder": "/var/lib/anogate/flights"}})"), "");
    EXPECT_EQ(
        faults(R"({"record": {"folder": "/mnt/usb"}})"),
        or_elsewhere(
            "a.json: /record/folder: 'folder' '/mnt/usb': the service has no write access there; /var/lib/anogate/usb works"));
}

TEST(Service, creates_tokens_only_in_its_state_folder) {
    EXPECT_EQ(faults(R"({"control": {"http": "0.0.0.0:0", "token_file": "/var/lib/anogate/token"}})"), "");
    EXPECT_EQ(
        faults(R"({"control": {"http": "0.0.0.0:0", "token_file": "/proc/nonexistent"}})"),
        or_elsewhere("a.json: /control/token_file: 'token_file' '/proc/nonexistent': the service has no write access there; "
                     "/var/lib/anogate/nonexistent works"));
    EXPECT_EQ(faults(R"({"control": {"token_file": "/proc/nonexistent"}})"), "") << "there is no listener";
    EXPECT_EQ(faults(R"({"control": {"http": "0.0.0.0:0", "token_file": "/etc/passwd"}})"), "") << "it is only read";
}

TEST(Service, of_an_instance_has_a_separate_runtime_folder) {
    const char* const json = R"({"links": ["pty:/run/anogate-left/app"], "control": {"socket": "/run/anogate-left/c.sock"}})";
    EXPECT_EQ(faults(json, "/etc/anogate/left.json"), "");
    EXPECT_NE(faults(json, "/etc/anogate/right.json"), "");
    EXPECT_NE(faults(json, "/etc/anogate/anogate.json"), "");
    EXPECT_NE(faults(R"({"links": ["pty:/home/pi/fc"]})", "left.json").find("; /run/anogate-left/fc works"), std::string::npos);
}

TEST(Service, finds_no_port_in_its_private_tmp) {
    const std::string fault = faults(R"({"links": [{"kind": "serial", "device": "/tmp/sitl"}, "serial:/run/sitl,baud=9600"]})");
    EXPECT_EQ(fault,
              "a.json: /links/0/device: 'device' '/tmp/sitl': the service has its own private /tmp; create the port in another "
              "folder, such as /run (or: systemctl edit anogated, PrivateTmp=no)\n");
    EXPECT_NE(faults(R"({"links": ["serial:/var/tmp/sitl"]})"), "");
}

TEST(Service, resolves_paths_before_checking_them) {
    EXPECT_NE(faults(R"({"links": ["pty:/run/anogate/../../tmp/app"]})"), "");
    EXPECT_NE(faults(R"({"links": ["pty:app"]})"), "") << "it starts in /";
    EXPECT_NE(faults(R"({"links": ["pty:/run/anogate"]})"), "");
    EXPECT_NE(faults(R"({"links": ["pty:/run/anogate2/app"]})"), "");
}

TEST(Service, is_recognized_by_a_configuration_beside_the_default_one) {
    const support::TempDir folder;
    const std::string theirs = folder.write("anogate.json", "{}"), other = folder.write("other.json", "{}");
    EXPECT_TRUE(is_for_service(theirs, theirs));
    EXPECT_TRUE(is_for_service(other, theirs));
    EXPECT_FALSE(is_for_service(other, "/etc/anogate/anogate.json"));
    EXPECT_FALSE(is_for_service("", theirs)) << "links of a command line";
}

}    // namespace
}    // namespace anogate::service_tests
