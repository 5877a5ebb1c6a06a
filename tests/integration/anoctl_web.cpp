// anoctl web: how to reach a running gateway, and the certificate that it makes.
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/signing_browser.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace anoctl_web_tests {
namespace {

using namespace support;
using nlohmann::json;

class AnoctlWeb : public testing::Test {
protected:
    struct Result {
        int exit;
        std::string printed;
    };
    static Result run(std::vector<std::string> words, const std::vector<std::string>& environment = {}) {
        Process process{ANOCTL, std::move(words), environment};
        const int exit = process.wait();
        return {exit, process.output()};
    }
    Result web(std::vector<std::string> words, const std::vector<std::string>& environment = {}) const {
        words.insert(words.begin(), {"web", "--control", socket});
        return run(std::move(words), environment);
    }
    static Result certificate(std::vector<std::string> words) {
        words.insert(words.begin(), "certificate");
        return run(std::move(words));
    }
    /// `control` is the value of that key in the configuration.
    Daemon& start(const std::string& control) {
        const std::string config = dir.write("anogate.json",
                                             R"({"links": ["udp-listen:127.0.0.1:0"], "control": )" + control + "}");
        daemon = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", config},
                                          std::vector<std::string>{"STATE_DIRECTORY=" + dir.path().string()});
        EXPECT_TRUE(daemon->until_answers()) << daemon->output();
        return *daemon;
    }

    std::uint16_t start_with_tokens() { return start(R"({"http": "0.0.0.0:0"})").status().at("http").at("port"); }
    /// Sends a code like the page; returns the answer.
    static std::string signed_in(std::uint16_t port, const std::string& code) {
        const std::string body = R"({"code": ")" + code + "\"}";
        return body_of(http(port,
                            "POST /login HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Type: application/json\r\n"
                            "Content-Length: " +
                                std::to_string(body.size()) + "\r\n\r\n" + body));
    }

    TempDir dir;
    std::string socket = dir / "control.sock";
    std::unique_ptr<Daemon> daemon;
};

TEST_F(AnoctlWeb, shows_the_urls_of_a_gateway_and_its_token_file) {
    start(R"({"http": "0.0.0.0:0", "hosts": ["vehicle.lan"], "token_file": ")" + (dir / "mine") + "\"}");
    const Result told = web({"--json"});
    ASSERT_EQ(told.exit, 0) << told.printed;
    const json facts = json::parse(told.printed);
    const std::string port = std::to_string(facts.at("port").get<int>());
    EXPECT_EQ(facts.at("state"), "up");
    EXPECT_EQ(facts.at("address"), "0.0.0.0");
    EXPECT_EQ(facts.at("tls"), false);
    EXPECT_EQ(facts.at("token_needed"), true);
    EXPECT_EQ(facts.at("token_file"), dir / "mine");
    const std::string urls = facts.at("urls").dump();
    EXPECT_NE(urls.find(":" + port + "/\""), std::string::npos) << urls;
    EXPECT_NE(urls.find("\"http://vehicle.lan:" + port + "/\""), std::string::npos) << urls;

    const Result words = web({});
    EXPECT_EQ(words.exit, 0);
    EXPECT_NE(words.printed.find("\nhttp://vehicle.lan:" + port + "/\n"), std::string::npos) << words.printed;
    EXPECT_NE(words.printed.find("in " + (dir / "mine")), std::string::npos) << words.printed;
}

TEST_F(AnoctlWeb, never_shows_a_token) {
    const std::string secret = "0123456789abcdef0123456789abcdef";
    const std::string tokens = dir.write("mine", "control " + secret + "\n");
    std::filesystem::permissions(tokens, std::filesystem::perms{0600});
    start(R"({"http": "127.0.0.1:0", "token_file": ")" + tokens + "\"}");
    const std::string told = web({}).printed + web({"--json"}).printed + daemon->status().dump();
    EXPECT_NE(told.find(tokens), std::string::npos) << told;
    EXPECT_EQ(told.find(secret), std::string::npos) << told;
}

TEST_F(AnoctlWeb, of_a_loopback_address_shows_how_another_computer_can_connect) {
    start(R"({"http": "127.0.0.1:0"})");
    const std::string port = std::to_string(daemon->status().at("http").at("port").get<int>());
    const Result told = web({});
    EXPECT_EQ(told.exit, 0);
    EXPECT_EQ(
        told.printed.find("http://127.0.0.1:" + port + "/\nhttp://localhost:" + port + "/\naccessible from this computer only"),
        0u)
        << told.printed;
    EXPECT_NE(told.printed.find("ssh -L " + port + ":127.0.0.1:" + port + " "), std::string::npos) << told.printed;
}

TEST_F(AnoctlWeb, shows_how_to_switch_http_on) {
    start("{}");
    const Result off = web({});
    EXPECT_EQ(off.exit, 1);
    EXPECT_EQ(
        off.printed,
        "anoctl: the HTTP interface is off; add \"control\": {\"http\": \"0.0.0.0:8088\"} to " + (dir / "anogate.json") +
            ", or start anogated with --http 0.0.0.0:8088, and restart it; 127.0.0.1:8088 limits access to this computer\n");
    const Result as_json = web({"--json"});
    EXPECT_EQ(as_json.exit, 1);
    EXPECT_EQ(as_json.printed.find("{\"urls\":[],\"state\":\"off\"}\n"), 0u) << as_json.printed;
}

TEST_F(AnoctlWeb, reports_why_http_is_off) {
    start(R"({"http": "127.0.0.1:0", "tls": {"certificate": ")" + (dir / "none") + R"(", "key": ")" + (dir / "none") + "\"}}");
    const Result shut = web({});
    EXPECT_EQ(shut.exit, 1);
    EXPECT_EQ(shut.printed.find("anoctl: no HTTP: control.tls: " + (dir / "none") + ": "), 0u) << shut.printed;
}

// The browser reads a file of its user and signs in; the code is on no command line.
TEST_F(AnoctlWeb, opens_a_signed_in_browser_on_this_computer) {
    const std::uint16_t port = start_with_tokens();
    write_signing_browser(dir, port);
    const std::vector<std::string> environment{"PATH=" + dir.path().string() + ":/usr/bin:/bin", "HOME=" + dir.path().string(),
                                               "SUDO_USER="};
    const Result opened = web({"--open"}, environment);
    EXPECT_EQ(opened.exit, 0) << opened.printed;
    EXPECT_NE(opened.printed.find("opens file://" + (dir / "anogate-")), std::string::npos) << opened.printed;
    EXPECT_NE(opened.printed.find("mode 600\nleads to http://localhost:" + std::to_string(port) + "/\n{\"access\": \"control\"}"),
              std::string::npos)
        << opened.printed;
    EXPECT_NE(web({"--open", "--view"}, environment).printed.find("{\"access\": \"view\"}"), std::string::npos);
    for (const auto& entry : std::filesystem::directory_iterator{dir.path()})
        EXPECT_NE(entry.path().extension(), ".html") << "it is removed";
    const Result without = web({"--open"}, {"PATH=" + (dir / "empty"), "HOME=" + dir.path().string(), "SUDO_USER="});
    EXPECT_EQ(without.exit, 1);
    EXPECT_NE(without.printed.find("xdg-open is not installed (package xdg-utils); open it yourself: http://localhost:"),
              std::string::npos)
        << without.printed;
}

// The code in that page is valid until it is used.
TEST_F(AnoctlWeb, leaves_no_page_with_a_code_when_a_signal_ends_it) {
    start_with_tokens();
    for (const char* const folder : {"bin", "home"}) std::filesystem::create_directory(dir.path() / folder);
    const std::string opener = dir.write("bin/xdg-open", "#!/bin/sh\n");
    std::filesystem::permissions(opener, std::filesystem::perms{0700});
    const std::filesystem::path home = dir / "home", old = home / "anogate-0123456789abcdef.html";
    const std::string other = dir.write("home/anogate-notes.html", "mine");
    dir.write("home/" + old.filename().string(), "of a program that was killed");
    const auto pages = [&] {
        std::size_t count = 0;
        for (const auto& entry : std::filesystem::directory_iterator{home}) count += entry.path() == other ? 0u : 1u;
        return count;
    };
    for (const std::filesystem::path& one : {old, std::filesystem::path{other}})
        std::filesystem::last_write_time(one, std::filesystem::file_time_type::clock::now() - std::chrono::minutes{6});
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        Process process{ANOCTL,
                        {"web", "--control", socket, "--open"},
                        {"PATH=" + (dir / "bin") + ":/usr/bin:/bin", "HOME=" + home.string(), "SUDO_USER="}};
        ASSERT_TRUE(wait_until([&] { return !std::filesystem::exists(old) && pages() == 1; })) << process.output();
        process.signal(signal);
        EXPECT_EQ(process.wait(), 128 + signal);
        EXPECT_EQ(pages(), 0u) << signal;
    }
    EXPECT_TRUE(std::filesystem::exists(other));
}

TEST_F(AnoctlWeb, shows_a_link_as_a_qr_code_that_signs_in_once) {
    const std::uint16_t port = start_with_tokens();
    const Result shown = web({"--qr"});
    ASSERT_EQ(shown.exit, 0) << shown.printed;
    EXPECT_NE(shown.printed.find("▀"), std::string::npos) << shown.printed;
    const auto at = shown.printed.find(":" + std::to_string(port) + "/#once=");
    ASSERT_NE(at, std::string::npos) << shown.printed;
    const std::string code = shown.printed.substr(shown.printed.find("#once=") + 6, 32);
    EXPECT_EQ(signed_in(port, code), "{\"access\": \"control\"}\n");
    EXPECT_NE(signed_in(port, code).find("\"error\""), std::string::npos) << "it was used";
    const std::string link = json::parse(web({"--qr", "--view", "--json"}).printed).at("link");
    EXPECT_EQ(signed_in(port, link.substr(link.find("#once=") + 6)), "{\"access\": \"view\"}\n");
}

TEST_F(AnoctlWeb, shows_digits_that_sign_in_once) {
    const std::uint16_t port = start_with_tokens();
    const Result shown = web({"--pair"});
    ASSERT_EQ(shown.exit, 0) << shown.printed;
    EXPECT_EQ(shown.printed.find("\nType these digits instead of the token at http"), 6u) << shown.printed;
    EXPECT_NE(shown.printed.find("They allow full control; valid once, for 5 minutes. Three wrong attempts"), std::string::npos)
        << shown.printed;
    EXPECT_EQ(signed_in(port, shown.printed.substr(0, 6)), "{\"access\": \"control\"}\n");
    const json told = json::parse(web({"--pair", "--view", "--json"}).printed);
    EXPECT_EQ(told.at("expires_s"), 300);
    EXPECT_EQ(signed_in(port, told.at("digits")), "{\"access\": \"view\"}\n");
}

TEST_F(AnoctlWeb, of_a_loopback_address_shows_no_qr_code) {
    start(R"({"http": "127.0.0.1:0"})");
    const Result refused = web({"--qr"});
    EXPECT_EQ(refused.exit, 1);
    EXPECT_NE(refused.printed.find("a phone cannot reach the page: control.http listens only on 127.0.0.1"), std::string::npos)
        << refused.printed;
    EXPECT_EQ(web({"--view"}).exit, 2);
    EXPECT_EQ(web({"--qr", "--pair"}).exit, 2);
}

TEST_F(AnoctlWeb, a_certificate_is_accepted_by_the_gateway_and_trusted_by_clients_that_know_the_authority) {
    const Result made = certificate({"--into", dir / "", "--json"});    // no gateway runs
    ASSERT_EQ(made.exit, 0) << made.printed;
    const json facts = json::parse(made.printed);
    EXPECT_EQ(facts.at("ca"), dir / "ca.pem");
    const std::string pem = facts.at("certificate"), key = facts.at("key");
    struct stat of_key {};
    ASSERT_EQ(::stat(key.c_str(), &of_key), 0);
    EXPECT_EQ(of_key.st_mode & 0777, 0600u);

    start(R"({"http": "127.0.0.1:0", "tls": )" + json{{"certificate", pem}, {"key", key}}.dump() + "}");
    const json http = daemon->status().at("http");
    ASSERT_EQ(http.at("state"), "up") << http;
    EXPECT_EQ(http.at("certificate"), pem);
    const std::string port = std::to_string(http.at("port").get<int>());
    for (const std::string host : {"localhost", "127.0.0.1"}) {
        Shell curl{"curl -sS -m 20 -o /dev/null -w '%{ssl_verify_result}' --cacert " + (dir / "ca.pem") + " https://" + host +
                   ":" + port + "/"};
        curl.wait();
        EXPECT_EQ(curl.output(), "0");
    }
    const Result told = web({});
    EXPECT_EQ(told.printed.find("https://127.0.0.1:" + port + "/\n"), 0u) << told.printed;
    EXPECT_NE(told.printed.find("programs verify it with " + (dir / "ca.pem")), std::string::npos) << told.printed;
    EXPECT_NE(told.printed.find("SHA-256 fingerprint " + facts.at("fingerprint").get<std::string>()), std::string::npos)
        << told.printed;
}

TEST_F(AnoctlWeb, a_certificate_is_made_by_its_former_command_as_well) {
    const Result made = web({"--make-certificate", "--into", dir.path().string()});
    ASSERT_EQ(made.exit, 0) << made.printed;
    EXPECT_NE(made.printed.find("    \"control\": {\"tls\": {\"certificate\":\"" + dir.path().string()), std::string::npos)
        << made.printed;
    EXPECT_TRUE(std::filesystem::exists(dir / "ca.pem"));
    EXPECT_EQ(web({"--help"}).printed.find("--make-certificate"), std::string::npos);
}

TEST_F(AnoctlWeb, folders_for_a_certificate_that_cannot_be_used_are_reported) {
    EXPECT_EQ(certificate({"--into", dir / "none"}).printed,
              "anoctl: folder not found: " + (dir / "none") + "; choose another folder with --into\n");
    if (::geteuid() != 0) {
        EXPECT_NE(certificate({"--into", "/usr"}).printed.find("permission denied: cannot write to /usr"), std::string::npos);
    }
}

}    // namespace
}    // namespace anoctl_web_tests
