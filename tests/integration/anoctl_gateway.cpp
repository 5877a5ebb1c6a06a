// anoctl as a client of a running gateway.
#include <http/client/certificate.hpp>
#include <http/server.hpp>
#include <support/changed_certificate.hpp>
#include <support/child.hpp>
#include <support/loop.hpp>
#include <support/namespaces.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/recorded.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <grp.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

namespace anoctl_gateway_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;

struct Result {
    int exit;
    std::string printed;
};

Result anoctl(
    std::vector<std::string> words, const std::vector<std::string>& environment = {},
    const std::function<void()>& in_child = [] {}) {
    Process process{ANOCTL, std::move(words), environment, in_child};
    const int exit = process.wait();
    return {exit, process.output()};
}

std::vector<json> lines_of(const std::string& text) {
    std::vector<json> all;
    std::istringstream lines{text};
    for (std::string line; std::getline(lines, line);) all.push_back(json::parse(line, nullptr, false));
    return all;
}

// Uses its own /run: the machine's may contain a gateway, or files that one left.
void become_nobody_where_none_runs() {
    if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount("none", "/run", "tmpfs", 0, "mode=755") != 0 || !become_nobody())
        ::_exit(100);
}

bool fits_80_columns(const std::string& text) {
    std::istringstream lines{text};
    for (std::string line; std::getline(lines, line);)
        if (line.size() > 80) return false;
    return true;
}

class AnoctlGateway : public testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(daemon.until_up("fc"));
        host.send(daemon.port("ground"), vendor::who_are_you);
        fc.write(vendor::i_am_an_mcu);
        ASSERT_TRUE(daemon.until([](const json& status) { return status.at("routes").size() == 3; }));
    }
    Result ask(std::vector<std::string> words) const {
        words.insert(words.end(), {"--control", socket});
        return anoctl(std::move(words));
    }

    TempDir dir;
    PtyDevice fc{dir / "fc-device"};
    UdpPeer host;
    std::string socket = dir / "control.sock";
    Daemon daemon{
        ANOGATED,
        socket,
        {"--id", "199", "serial:" + fc.path() + ",name=fc", "udp-listen:127.0.0.1:0,name=ground", "serial:/dev/absent"}};
};

TEST_F(AnoctlGateway, shows_its_status) {
    const Result status = ask({"status"});
    EXPECT_EQ(status.exit, 0);
    EXPECT_EQ(status.printed.find("degraded: 1 of 3 links\nanogate, anogate "), 0u) << status.printed;
    EXPECT_EQ(ask({"status", "--exit-code"}).exit, 3);
    EXPECT_EQ(ask({"status", "--exit-code", "--json"}).exit, 3);
    for (const char* words :
         {" IN/s  OUT/s ", "id 199, up for ", "LINK", "fc ", "ground ", "absent ", "waiting", "    /dev/absent not found"})
        EXPECT_NE(status.printed.find(words), std::string::npos) << words << " in\n" << status.printed;
    EXPECT_TRUE(fits_80_columns(status.printed)) << status.printed;
    const Result as_json = ask({"status", "--json"});
    ASSERT_EQ(lines_of(as_json.printed).size(), 1u);
    EXPECT_EQ(lines_of(as_json.printed)[0].at("links").size(), 3u);
}

TEST_F(AnoctlGateway, shows_its_links_and_all_their_counters) {
    fc.write(Bytes(100, 0x55));
    ASSERT_TRUE(daemon.until([&](const json&) { return daemon.count("fc", "skipped_bytes") == 100; }));
    const Result links = ask({"links"});
    EXPECT_EQ(links.exit, 0);
    EXPECT_NE(links.printed.find("skipped_bytes 100"), std::string::npos) << links.printed;
    EXPECT_NE(links.printed.find("\n  127.0.0.1:" + std::to_string(host.port())), std::string::npos) << links.printed;
    EXPECT_EQ(lines_of(ask({"links", "--json"}).printed).size(), 3u);
    const auto one = lines_of(ask({"links", "ground", "--json"}).printed);
    ASSERT_EQ(one.size(), 1u);
    EXPECT_EQ(one[0].at("name"), "ground");
    const Result unknown = ask({"links", "gruond"});
    EXPECT_EQ(unknown.exit, 1);
    EXPECT_EQ(unknown.printed, "anoctl: unknown link 'gruond' (did you mean 'ground'?); links: fc, ground, absent\n");
}

TEST(AnoctlStatus, is_ok_when_all_links_are_up_and_shows_a_common_hint_once) {
    const TempDir dir;
    PtyDevice one{dir / "one"}, two{dir / "two"};
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"serial:" + (dir / "one"), "serial:" + (dir / "two")}};
    ASSERT_TRUE(daemon.until([&](const json& status) {
        one.write(frame(0xDC, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));
        two.write(frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));
        const auto& links = status.at("links");
        return std::all_of(links.begin(), links.end(), [](const json& link) { return link.at("hint_id") == "no_host_takes"; });
    }));
    one.write(frame(0xDC, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));
    two.write(frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));
    const Result status = anoctl({"status", "--exit-code", "--control", socket});
    EXPECT_EQ(status.exit, 0) << status.printed;
    EXPECT_EQ(status.printed.find("ok\n"), 0u) << status.printed;
    const std::string hint = "no ground station is registered for this telemetry yet";
    const std::size_t first = status.printed.find(hint);
    ASSERT_NE(first, std::string::npos) << status.printed;
    EXPECT_EQ(status.printed.find(hint, first + 1), std::string::npos) << status.printed;
}

// With the option 0 and 3, without it always 0, whatever is degraded.
TEST(AnoctlStatus, exits_with_3_while_degraded_if_the_option_is_set) {
    const TempDir dir;
    const std::string socket = dir / "control.sock";
    auto two = std::make_unique<PtyDevice>(dir / "two");
    PtyDevice one{dir / "one"};
    Daemon daemon{ANOGATED, socket, {"serial:" + (dir / "one"), "serial:" + (dir / "two")}};
    ASSERT_TRUE(daemon.until_up("one") && daemon.until_up("two"));
    const auto ask = [&](const std::vector<std::string>& words) {
        one.write(frame(0xDC, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));    // a silent link has a hint
        if (two) two->write(frame(0xDD, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 2}));
        return anoctl(words);
    };
    const auto expect = [&](int exit, const std::string& verdict) {
        for (const bool as_json : {false, true}) {
            std::vector<std::string> words{"status", "--control", socket};
            if (as_json) words.push_back("--json");
            const Result plain = ask(words);
            words.push_back("--exit-code");
            const Result asked = ask(words);
            EXPECT_EQ(plain.exit, 0) << plain.printed;
            EXPECT_EQ(asked.exit, exit) << asked.printed;
            if (!as_json) {
                EXPECT_EQ(asked.printed.substr(0, asked.printed.find('\n')), verdict);
            }
        }
    };
    expect(0, "ok");
    EXPECT_TRUE(daemon.until([&](const json& status) {
        one.write(frame(0xDC, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 1}));
        two->write(frame(0xDC, 0xFE, 0x03, {0, 0, 0, 0, 0, 0, 2}));
        return status.at("conflicts").size() == 1;
    }));
    expect(3, "degraded: 1 conflict");
    two.reset();
    EXPECT_TRUE(daemon.until([&](const json& status) { return status.at("links").at(1).at("state") != "up"; }));
    expect(3, "degraded: 1 of 2 links, 1 conflict");
}

TEST(AnoctlStatus, is_degraded_by_an_expired_certificate) {
    const TempDir dir;
    Shell openssl{"cd " + dir.path().string() +
                  " && openssl req -new -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=vehicle -keyout key.pem "
                  "-out request.pem && openssl x509 -req -in request.pem -signkey key.pem -days 0 -out old.pem"};
    ASSERT_EQ(openssl.wait(), 0) << openssl.output();
    const std::string socket = dir / "control.sock";
    Daemon daemon{
        ANOGATED,
        socket,
        {"tls-listen:127.0.0.1:0,name=radio,verify=none,certificate=" + (dir / "old.pem") + ",key=" + (dir / "key.pem")}};
    ASSERT_TRUE(daemon.until([](const json& status) { return status.at("links").at(0).value("certificate_days", 0) < 0; }))
        << daemon.status();
    const Result status = anoctl({"status", "--exit-code", "--control", socket});
    EXPECT_EQ(status.exit, 3);
    EXPECT_EQ(status.printed.find("degraded: 1 expired certificate\n"), 0u) << status.printed;
    EXPECT_NE(status.printed.find("the certificate of this link has expired"), std::string::npos) << status.printed;
}

TEST(AnoctlStatus, is_degraded_by_unusable_certificates_of_a_link_and_of_the_page) {
    const TempDir dir;
    for (const char* name : {"link", "page"})
        ASSERT_TRUE(anogate::http::make_certificate({{"vehicle"}, {}}, dir / (std::string{name} + ".pem"),
                                                    dir / (std::string{name} + "-key.pem")));
    std::filesystem::permissions(dir / "page-key.pem", std::filesystem::perms{0644});
    const std::string socket = dir / "control.sock", config = dir / "anogate.json";
    std::ofstream{config} << json{
        {"links",
         {"tls-listen:127.0.0.1:0,name=l,verify=none,certificate=" + (dir / "link.pem") + ",key=" + (dir / "link-key.pem")}},
        {"control", {{"http", "127.0.0.1:0"}, {"tls", {{"certificate", dir / "page.pem"}, {"key", dir / "page-key.pem"}}}}}};
    Daemon daemon{ANOGATED, socket, {"--config", config}};
    ASSERT_TRUE(daemon.until([](const json& status) { return status.at("links").at(0).at("state") == "up"; })) << daemon.status();
    const Result page = anoctl({"status", "--exit-code", "--control", socket});
    EXPECT_EQ(page.exit, 3);
    EXPECT_EQ(page.printed.find("degraded: http\n"), 0u) << page.printed;
    EXPECT_NE(page.printed.find("page-key.pem: every user of this computer can read it"), std::string::npos) << page.printed;
    std::filesystem::permissions(dir / "link-key.pem", std::filesystem::perms{0644});
    ASSERT_TRUE(daemon.until([](const json& status) {
        return status.at("links").at(0).at("error_id") == "certificate_unusable";
    })) << daemon.status();
    EXPECT_EQ(anoctl({"status", "--control", socket}).printed.find("degraded: 1 unusable certificate, http\n"), 0u);
}

class PageCertificate : public testing::Test {
protected:
    PageCertificate() { EXPECT_TRUE(anogate::http::make_certificate({{"vehicle"}, {}}, certificate, key)); }
    void valid(std::chrono::seconds begin, std::chrono::seconds end) {
        EXPECT_TRUE(change_validity(certificate, key, begin, end));
    }
    void start() {
        std::ofstream{config} << json{
            {"links", {"udp-listen:127.0.0.1:0"}},
            {"control", {{"http", "127.0.0.1:0"}, {"tls", {{"certificate", certificate}, {"key", key}}}}}};
        daemon.emplace(ANOGATED, socket, std::vector<std::string>{"--config", config});
        ASSERT_TRUE(daemon->until_answers()) << daemon->output();
    }
    bool until_hint(const std::string& id) {
        return daemon->until([&](const json& status) { return status.at("http").at("hint_id") == id; });
    }
    Result status() const { return anoctl({"status", "--exit-code", "--control", socket}); }

    const TempDir dir;
    const std::string certificate = dir / "page.pem", key = dir / "page-key.pem";
    const std::string socket = dir / "control.sock", config = dir / "anogate.json";
    std::optional<Daemon> daemon;
};

TEST_F(PageCertificate, that_has_expired_or_is_not_valid_yet_degrades_the_gateway) {
    valid(-48h, -24h - 10min);
    start();
    EXPECT_EQ(daemon->status().at("http").at("certificate_days"), -2);
    const Result expired = status();
    EXPECT_EQ(expired.exit, 3);
    EXPECT_EQ(expired.printed.find("degraded: 1 expired certificate\n"), 0u) << expired.printed;
    EXPECT_NE(expired.printed.find("http: the certificate of control.tls has expired: replace it, then run anoctl reload\n"),
              std::string::npos)
        << expired.printed;
    valid(24h, 800h);
    EXPECT_EQ(anoctl({"reload", "--control", socket}).printed, "read again: " + certificate + "\n1 link unchanged\n");
    EXPECT_TRUE(until_hint("certificate_not_valid_yet"));
    EXPECT_EQ(status().printed.find("degraded: 1 hint\n"), 0u) << status().printed;
}

TEST_F(PageCertificate, is_reported_during_its_last_two_weeks_also_if_they_begin_while_the_gateway_runs) {
    valid(-24h, 15 * 24h + 4s);
    start();
    EXPECT_EQ(daemon->status().at("http").at("certificate_days"), 15);
    EXPECT_EQ(daemon->status().at("http").at("hint"), "");
    EXPECT_TRUE(until_hint("certificate_expires"));
    EXPECT_EQ(daemon->status().at("http").at("hint_args"), json({{"days", 14}}));
    EXPECT_TRUE(daemon->until_says("control.tls: " + certificate + ": the certificate expires in 14 days: replace it"))
        << daemon->output();
    EXPECT_NE(http(socket, "GET /metrics HTTP/1.0\r\n\r\n").find("\nanogate_http_certificate_expires_seconds 1209600\n"),
              std::string::npos);
    const Result soon = status();
    EXPECT_EQ(soon.exit, 0) << "it still works";
    EXPECT_NE(soon.printed.find("http: the certificate of control.tls expires in 14 days"), std::string::npos) << soon.printed;
}

TEST_F(PageCertificate, whose_content_has_changed_is_named_by_a_reload) {
    start();
    const auto reload = [&](std::vector<std::string> words) {
        words.insert(words.begin(), "reload");
        words.insert(words.end(), {"--control", socket});
        return anoctl(words).printed;
    };
    EXPECT_EQ(reload({}), "no changes\n");
    for (const std::string& file : {certificate, key}) std::filesystem::remove(file);
    EXPECT_TRUE(anogate::http::make_certificate({{"vehicle"}, {}}, certificate, key));
    const std::string files = "read again: " + key + "\nread again: " + certificate + "\n1 link unchanged\n";
    EXPECT_EQ(reload({"--dry-run"}), files + "nothing was changed (--dry-run)\n");
    EXPECT_EQ(reload({}), files);
    EXPECT_TRUE(daemon->until_says("reload: read again: " + certificate)) << daemon->output();
    EXPECT_EQ(reload({}), "no changes\n");
}

TEST(AnoctlStatus, names_a_vehicle_that_was_lost_in_flight) {
    const TempDir dir;
    PtyDevice one{dir / "one"};
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"serial:" + (dir / "one")}};
    ASSERT_TRUE(daemon.until_up("one"));
    const auto until_lost = [&](std::uint8_t state) {
        for (int i = 0; i < 3; ++i) one.write(frame(0xDC, 0xFF, 0x06, {1, state, 0, 0, 0}));
        return daemon.until([&](const json& status) {
            const auto& lost = status.at("lost");
            return lost.size() == 1 && lost.at(0).at("sflag") == state;
        });
    };
    ASSERT_TRUE(until_lost(2)) << daemon.status();
    const Result status = anoctl({"status", "--exit-code", "--control", socket});
    EXPECT_EQ(status.exit, 3);
    EXPECT_EQ(status.printed.find("degraded: 0xDC lost, airborne "), 0u) << status.printed;
    EXPECT_NE(status.printed.find("\nlost: 0xDC, airborne "), std::string::npos) << status.printed;
    const Result devices = anoctl({"devices", "--control", socket});
    EXPECT_NE(devices.printed.find("\n    lost: airborne "), std::string::npos) << devices.printed;
    const auto as_json = lines_of(anoctl({"devices", "--json", "--control", socket}).printed);
    ASSERT_EQ(as_json.size(), 1u);
    EXPECT_TRUE(as_json[0].at("lost") == true && as_json[0].at("sflag") == 2) << as_json[0];
    ASSERT_TRUE(until_lost(0));
    const Result locked = anoctl({"status", "--control", socket});
    EXPECT_EQ(locked.printed.find(" lost, "), std::string::npos) << "it may have been switched off: " << locked.printed;
    EXPECT_NE(locked.printed.find("\nlost: 0xDC, locked "), std::string::npos) << locked.printed;
}

TEST(AnoctlLinks, show_counters_that_only_some_kinds_have) {
    const TempDir dir;
    KeptItem command;
    command.link = "fc";
    command.frame = frame(0x30, 0xDC, 0xC0, {1, 0});
    const std::string file = dir.write("flight.pcapng", write_pcapng({command, command}, {"anogate 0.1.0"}));
    const std::string socket = dir / "control.sock";
    Daemon daemon{ANOGATED, socket, {"replay:" + file}};
    ASSERT_TRUE(daemon.until([&](const json&) { return daemon.count("flight", "kept_back_commands") == 2; })) << daemon.status();
    const Result links = anoctl({"links", "--control", socket});
    EXPECT_NE(links.printed.find("      also: kept_back_commands 2\n"), std::string::npos) << links.printed;
}

TEST_F(AnoctlGateway, shows_which_port_the_system_chose) {
    const std::string place = "    at 127.0.0.1:" + std::to_string(daemon.port("ground")) + "\n";
    for (const char* command : {"links", "status"}) {
        const Result result = ask({command});
        EXPECT_NE(result.printed.find(place), std::string::npos) << result.printed;
    }
}

TEST_F(AnoctlGateway, shows_its_routes_and_removes_one) {
    const Result routes = ask({"routes"});
    EXPECT_EQ(routes.exit, 0);
    EXPECT_NE(routes.printed.find("0xFE"), std::string::npos) << routes.printed;
    EXPECT_NE(routes.printed.find("learned"), std::string::npos) << routes.printed;
    EXPECT_TRUE(fits_80_columns(routes.printed)) << routes.printed;
    EXPECT_EQ(lines_of(ask({"routes", "--json"}).printed).size(), 3u);
    const Result forgotten = ask({"routes", "--forget", "host"});
    EXPECT_EQ(forgotten.exit, 0);
    EXPECT_EQ(forgotten.printed, "0xFE: route removed\n");
    const Result again = ask({"routes", "--forget", "0xFE"});
    EXPECT_EQ(again.exit, 1);
    EXPECT_EQ(again.printed, "anoctl: 0xFE was not seen: there is nothing to forget\n");
    EXPECT_EQ(ask({"routes", "--forget", "no/body"}).exit, 1);
}

TEST_F(AnoctlGateway, shows_its_metrics) {
    EXPECT_NE(ask({"metrics"}).printed.find("\nanogate_link_frames_in_total{link=\"fc\"} 1\n"), std::string::npos);
    EXPECT_TRUE(ask({"metrics", "--openmetrics"}).printed.ends_with("# EOF\n"));
    bool found = false;
    for (const json& sample : lines_of(ask({"metrics", "--json"}).printed))
        found = found || sample == json{{"name", "anogate_link_frames_in_total"}, {"labels", {{"link", "fc"}}}, {"value", 1}};
    EXPECT_TRUE(found);
}

TEST_F(AnoctlGateway, is_found_by_the_option_control_before_and_after_the_command) {
    EXPECT_EQ(anoctl({"--control", socket, "--json", "routes"}).exit, 0);
    EXPECT_EQ(anoctl({"--control=" + socket, "routes"}).exit, 0);
    EXPECT_EQ(anoctl({"routes", "--control=" + socket}).exit, 0);
    EXPECT_EQ(anoctl({"--control", "none", "routes"}).exit, 2);
    EXPECT_EQ(anoctl({"--control", socket}).exit, 2);
}

TEST_F(AnoctlGateway, of_a_user_is_found_at_the_default_path) {
    Daemon own{ANOGATED, dir / "anogate.sock", {"sim:fc,name=own"}};
    ASSERT_TRUE(own.until_answers()) << own.output();
    if (::geteuid() != 0) {
        EXPECT_NE(anoctl({"status"}, {"XDG_RUNTIME_DIR=" + dir.path().string()}).printed.find("own"), std::string::npos);
        return;
    }
    // Another user, who may enter that folder.
    const auto as_nobody = [] { return ::setgid(65534) == 0 && ::setuid(65534) == 0; };
    ASSERT_EQ(::chmod(dir.path().c_str(), 0755), 0);
    ASSERT_EQ(::chmod((dir / "anogate.sock").c_str(), 0666), 0);
    const Result status = anoctl({"status"}, {"XDG_RUNTIME_DIR=" + dir.path().string()}, [&] { (void)as_nobody(); });
    EXPECT_NE(status.printed.find("own"), std::string::npos) << status.printed;
}

TEST_F(AnoctlGateway, without_permission_shows_how_to_get_it) {
    if (::geteuid() != 0) GTEST_SKIP() << "only root can become a user who may not";
    const auto nobody = [] { (void)(::setgroups(0, nullptr) == 0 && become_nobody()); };
    ASSERT_EQ(::chmod(dir.path().c_str(), 0755), 0);
    ASSERT_EQ(::chmod(socket.c_str(), 0600), 0);
    const Result alone = anoctl({"status", "--control", socket}, {}, nobody);
    EXPECT_EQ(alone.exit, 1);
    EXPECT_EQ(alone.printed,
              "anoctl: no permission for " + socket + ": only user root has access: run sudo -u root anoctl ...\n");
    ASSERT_EQ(::chmod(socket.c_str(), 0660), 0);
    ASSERT_EQ(::chown(socket.c_str(), 0, 1), 0);
    const Result group = anoctl({"status", "--control", socket}, {}, nobody);
    EXPECT_EQ(group.exit, 1);
    EXPECT_NE(group.printed.find("it belongs to group "), std::string::npos) << group.printed;
    EXPECT_NE(group.printed.find("sudo usermod -aG "), std::string::npos) << group.printed;
    ASSERT_EQ(::chmod(dir.path().c_str(), 0700), 0);
    EXPECT_NE(
        anoctl({"status", "--control", socket}, {}, nobody).printed.find("this user has no access to its folder: sudo anoctl"),
        std::string::npos);
}

TEST_F(AnoctlGateway, that_does_not_run_is_reported) {
    const Result none = anoctl({"status", "--control", dir / "none.sock"});
    EXPECT_EQ(none.exit, 1);
    EXPECT_EQ(none.printed, "anoctl: no gateway is running at " + dir / "none.sock" +
                                ": socket not found (another one: --control PATH); to start one: anogated LINK...\n");
    if (no_namespaces().empty()) {
        const Result nowhere = anoctl({"status"}, {"XDG_RUNTIME_DIR="}, become_nobody_where_none_runs);
        EXPECT_NE(nowhere.printed.find("socket not found; XDG_RUNTIME_DIR is not set, so a gateway of this user can't be found"),
                  std::string::npos)
            << nowhere.printed;
        const Result neither = anoctl({"status"}, {"XDG_RUNTIME_DIR=/proc/none"}, become_nobody_where_none_runs);
        EXPECT_NE(neither.printed.find("at /proc/none/anogate.sock: socket not found, nor /run/anogate/control.sock"),
                  std::string::npos)
            << neither.printed;
    }
    daemon.signal(SIGKILL);
    daemon.wait();
    const Result dead = ask({"links"});
    EXPECT_EQ(dead.exit, 1);
    EXPECT_EQ(dead.printed, "anoctl: no gateway is running at " + socket +
                                ": the socket is left from a stopped one; to start one: anogated LINK...\n");
}

TEST_F(AnoctlGateway, lists_devices_and_links_for_shell_completion) {
    const Result devices = anoctl({"__complete", "devices", "monitor", "--control", socket, "--from", ""});
    EXPECT_EQ(devices.exit, 0);
    EXPECT_NE(devices.printed.find("0xFE\thost, ground\n"), std::string::npos) << devices.printed;
    const Result links = anoctl({"__complete", "links", "links", "--control=" + socket});
    EXPECT_NE(links.printed.find("fc\tserial, up\n"), std::string::npos) << links.printed;
    EXPECT_NE(links.printed.find("absent\tserial, waiting\n"), std::string::npos) << links.printed;
    EXPECT_EQ(anoctl({"__complete", "links", "links", "--control", "=", socket}).printed, links.printed);    // as bash splits it
    EXPECT_EQ(anoctl({"--help"}).printed.find("__complete"), std::string::npos);
}

TEST(AnoctlComplete, prints_nothing_when_no_gateway_answers) {
    const TempDir dir;
    const std::string silent = dir / "silent.sock";
    const int listening = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    silent.copy(address.sun_path, sizeof address.sun_path - 1);
    ASSERT_EQ(::bind(listening, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
    ASSERT_EQ(::listen(listening, 1), 0);
    const auto before = std::chrono::steady_clock::now();
    for (const std::string& socket : {silent, dir / "none.sock", std::string{"none"}})
        for (const char* what : {"devices", "links"}) {
            const Result nothing = anoctl({"__complete", what, "top", "--control", socket});
            EXPECT_EQ(nothing.exit, 0) << socket;
            EXPECT_EQ(nothing.printed, "") << socket;
        }
    EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds{8}) << "0.3 s each, not the 10 s of other commands";
    EXPECT_EQ(anoctl({"__complete"}).printed, "");
    EXPECT_EQ(anoctl({"__complete", "what", "--control"}).printed, "");
    ::close(listening);
}

/// A gateway whose answer to reload is set by the test.
class AnoctlReload : public testing::Test {
protected:
    void SetUp() override {
        const auto answer = [this](const anogate::http::Request& request) {
            asked = request.target;
            anogate::http::Response response;
            response.status = status;
            response.body = body;
            return response;
        };
        server.routes().add("POST", "/reload", answer);
        server.routes().add("POST", "/reload/confirm", answer);
        ASSERT_EQ(server.start(socket).error, "");
    }
    void TearDown() override {
        server.stop();
        loop.turn();
    }
    Result reload(std::vector<std::string> words) {
        words.insert(words.begin(), {"--control", socket, "reload"});
        Process process{ANOCTL, words};
        EXPECT_TRUE(loop.until([&] { return !process.is_running(); }));
        return {process.wait(), process.output()};
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    Loop loop;
    anogate::http::Server server{loop.io};
    std::string asked;
    unsigned status = 200;
    std::string body = R"({"dry_run": false, "changed": true, "links": [
        {"name": "fc", "change": "same", "differences": []},
        {"name": "radio", "change": "changed", "differences": ["baud: 500000 -> 115200"]},
        {"name": "gps", "change": "added", "differences": []}],
        "gateway": ["forget_after: 30s -> 10s"], "confirm_within_s": 30})";
};

TEST_F(AnoctlReload, shows_what_changes) {
    const Result done = reload({"--confirm-within", "30s"});
    EXPECT_EQ(asked, "/reload?confirm_within=30s");
    EXPECT_EQ(done.exit, 0);
    EXPECT_EQ(done.printed,
              "radio: changed\n"
              "    baud: 500000 -> 115200\n"
              "gps: added\n"
              "gateway: changed\n"
              "    forget_after: 30s -> 10s\n"
              "1 link unchanged\n"
              "the previous configuration is restored in 30 s unless you confirm: anoctl reload --confirm\n");
    EXPECT_EQ(lines_of(reload({"--json"}).printed).at(0).at("links").size(), 3u);
    EXPECT_EQ(asked, "/reload");
}

TEST_F(AnoctlReload, changes_nothing_in_a_dry_run) {
    const Result would = reload({"--dry-run"});
    EXPECT_EQ(asked, "/reload?dry_run");
    EXPECT_TRUE(would.printed.ends_with("nothing was changed (--dry-run)\n")) << would.printed;
    body = R"({"dry_run": true, "changed": false, "links": [], "gateway": []})";
    EXPECT_EQ(reload({"--dry-run"}).printed, "no changes\n");
}

TEST_F(AnoctlReload, lists_the_changes_that_need_a_restart) {
    body =
        R"({"dry_run": false, "changed": false, "links": [], "gateway": [], "needs_restart": ["control.http: not set -> 1.2.3.4:8"]})";
    EXPECT_EQ(reload({}).printed, "at the next start:\n    control.http: not set -> 1.2.3.4:8\n");
}

TEST_F(AnoctlReload, shows_why_the_http_interface_is_off) {
    body =
        R"({"dry_run": false, "changed": false, "links": [], "gateway": [], "files": [], "http_error": "control.tls: no key"})";
    EXPECT_EQ(reload({}).printed, "HTTP interface off: control.tls: no key\n");
}

TEST_F(AnoctlReload, shows_the_faults_of_a_configuration) {
    status = 422;
    body = R"({"error": "the configuration has 2 errors", "what": "invalid", "faults": ["/links/0/baud: one", "/links/1: two"]})";
    const Result refused = reload({});
    EXPECT_EQ(refused.exit, 1);
    EXPECT_EQ(refused.printed,
              "anoctl: /links/0/baud: one\n"
              "anoctl: /links/1: two\n"
              "anoctl: the configuration has 2 errors\n");
}

TEST_F(AnoctlReload, names_the_option_whose_value_is_refused) {
    status = 400;
    body = R"({"error": "'confirm_within' must be a duration such as 30s, from 1s to 1h, not '0'", "what": "invalid"})";
    const Result refused = reload({"--confirm-within", "0"});
    EXPECT_EQ(refused.exit, 2);
    EXPECT_EQ(refused.printed, "anoctl: --confirm-within must be a duration such as 30s, from 1s to 1h, not '0'\n");
}

TEST_F(AnoctlReload, confirms_the_new_configuration) {
    EXPECT_EQ(reload({"--confirm"}).printed, "the new configuration is confirmed\n");
    EXPECT_EQ(asked, "/reload/confirm");
    status = 409;
    body = R"({"error": "no configuration is waiting for confirmation", "what": "busy"})";
    const Result refused = reload({"--confirm"});
    EXPECT_EQ(refused.exit, 1);
    EXPECT_EQ(refused.printed, "anoctl: no configuration is waiting for confirmation\n");
    EXPECT_EQ(reload({"--confirm", "--dry-run"}).exit, 2);
}

}    // namespace
}    // namespace anoctl_gateway_tests
