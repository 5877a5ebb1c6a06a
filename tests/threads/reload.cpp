// The program reloads its configuration: SIGHUP, POST /reload, and the configuration after a restart.
#include <support/numbered_frames.hpp>
#include <support/process.hpp>
#include <support/pty_device.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>

namespace reload_tests {
namespace {

using namespace std::chrono_literals;
using namespace support;
using nlohmann::json;

/// Receives the messages to systemd.
class NotifySocket {
public:
    explicit NotifySocket(const std::string& path) : fd_{::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)} {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) std::abort();
    }
    ~NotifySocket() { ::close(fd_); }
    NotifySocket(const NotifySocket&) = delete;
    NotifySocket& operator=(const NotifySocket&) = delete;
    /// All messages since the last call, one per line.
    std::string heard() {
        std::string all;
        char buffer[4096];
        for (ssize_t n; (n = ::recv(fd_, buffer, sizeof buffer, 0)) > 0;) all.append(buffer, static_cast<std::size_t>(n)) += "\n";
        return all;
    }

private:
    int fd_;
};

struct Answer {
    int status = 0;
    json body;
};

class Reload : public testing::Test {
protected:
    std::string config() const { return dir / "anogate.json"; }
    void write(const json& links, const json& more = json::object()) const {
        json all = more;
        all["links"] = links;
        dir.write("anogate.json", all.dump());
    }
    bool start(std::vector<std::string> more = {}) {
        std::vector<std::string> arguments{"--config", config()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        daemon.emplace(ANOGATED, dir / "control", arguments,
                       std::vector<std::string>{"STATE_DIRECTORY=" + (dir / "state"), "NOTIFY_SOCKET=" + (dir / "notify")});
        return daemon->until_answers();
    }
    Answer post(const std::string& target) const {
        const std::string answer = http(dir / "control", "POST " + target + " HTTP/1.0\r\nContent-Length: 0\r\n\r\n");
        if (answer.size() < 12) return {};
        return {std::stoi(answer.substr(9, 3)), json::parse(body_of(answer))};
    }
    std::string state() const { return daemon->status().at("gateway").at("config").at("state"); }
    std::vector<std::string> names() const {
        std::vector<std::string> names;
        const json now = daemon->status();
        for (const auto& link : now.at("links")) names.push_back(link.at("name"));
        return names;
    }
    bool has_names(const std::vector<std::string>& wanted) {
        return wait_until([&] { return names() == wanted; });
    }
    bool is_kept() const { return std::filesystem::exists(dir / "state") && !std::filesystem::is_empty(dir / "state"); }

    TempDir dir;
    NotifySocket notify{dir / "notify"};
    std::optional<Daemon> daemon;
};

TEST_F(Reload, applies_the_changes_of_the_file_and_reports_them_link_by_link) {
    PtyDevice device{dir / "fc"};
    write({"serial:" + device.path() + ",name=fc", "sim:fc,name=sim", "sim:fc,name=old"});
    ASSERT_TRUE(start({"udp-listen:127.0.0.1:0,name=ground"}));
    ASSERT_TRUE(daemon->until_up("ground"));
    EXPECT_EQ(daemon->status().at("gateway").at("config"), (json{{"file", config()}, {"state", "file"}}));
    const auto port = daemon->port("ground");
    notify.heard();
    write({"serial:" + device.path() + ",name=fc,baud=115200", "sim:fc,name=sim", "sim:fc,name=new"},
          {{"gateway", {{"forget_after", "1m"}}}, {"control", {{"socket", dir / "control"}}}, {"log", {{"file", dir / "log"}}}});
    const Answer answer = post("/reload");
    EXPECT_EQ(answer.status, 200);
    const json links = {{{"name", "fc"}, {"change", "changed"}, {"differences", {"baud: 500000 -> 115200"}}},
                        {{"name", "sim"}, {"change", "same"}, {"differences", json::array()}},
                        {{"name", "new"}, {"change", "added"}, {"differences", json::array()}},
                        {{"name", "ground"}, {"change", "same"}, {"differences", json::array()}},
                        {{"name", "old"}, {"change", "removed"}, {"differences", json::array()}}};
    EXPECT_EQ(answer.body, (json{{"dry_run", false},
                                 {"changed", true},
                                 {"links", links},
                                 {"gateway", {"gateway.forget_after: 30s -> 1m"}},
                                 {"files", json::array()},
                                 {"needs_restart", {"log.file: not set -> " + (dir / "log")}},
                                 {"confirm_within_s", nullptr}}));
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "sim", "new", "ground"}));
    EXPECT_EQ(daemon->port("ground"), port);
    EXPECT_EQ(daemon->status().at("gateway").at("config").at("needs_restart").size(), 1u);
    const std::string told = notify.heard();
    EXPECT_TRUE(told.starts_with("RELOADING=1\nMONOTONIC_USEC=")) << told;
    EXPECT_TRUE(told.ends_with("READY=1\n")) << told;
    EXPECT_TRUE(daemon->until_says("reload: fc changed: baud: 500000 -> 115200"));
    EXPECT_TRUE(daemon->until_says("takes effect at the next start: log.file"));
    EXPECT_FALSE(std::filesystem::exists(dir / "log"));
    const Answer again = post("/reload");
    EXPECT_EQ(again.body.at("changed"), false);
}

TEST_F(Reload, of_a_faulty_file_changes_nothing_and_reports_all_errors) {
    write({"sim:fc"});
    ASSERT_TRUE(start());
    std::filesystem::create_directory(dir / "conf.d");
    dir.write("conf.d/10.json", R"({"links": ["sim:fc,hz=0", {"kind": "serial", "device": "/dev/x", "bauds": 9}]})");
    const Answer answer = post("/reload");
    EXPECT_EQ(answer.status, 422);
    EXPECT_EQ(answer.body.at("what"), "invalid");
    ASSERT_EQ(answer.body.at("faults").size(), 2u) << answer.body;
    EXPECT_EQ(answer.body.at("faults")[1], (dir / "conf.d/10.json: /links/1/bauds: unknown key 'bauds' (did you mean 'baud'?)"));
    EXPECT_EQ(names(), std::vector<std::string>{"fc"});
    EXPECT_EQ(state(), "file");
    daemon->new_output();
    daemon->signal(SIGHUP);
    EXPECT_TRUE(daemon->until_says("reload: " + (dir / "conf.d/10.json: /links/1/bauds: unknown key")));
    EXPECT_EQ(post("/reload?confirm_within=5s").status, 422);
    EXPECT_FALSE(is_kept());
    std::filesystem::remove(config());
    EXPECT_EQ(post("/reload").status, 422);
    EXPECT_EQ(names(), std::vector<std::string>{"fc"});
    EXPECT_NE(notify.heard().find("READY=1"), std::string::npos) << "the end of a reload that came to nothing";
}

TEST_F(Reload, with_dry_run_changes_nothing) {
    write({"sim:fc"});
    ASSERT_TRUE(start());
    write({"sim:fc", "sim:fc,name=two"});
    notify.heard();
    const Answer answer = post("/reload?dry_run");
    EXPECT_EQ(answer.body.at("dry_run"), true);
    EXPECT_EQ(answer.body.at("changed"), true);
    EXPECT_EQ(answer.body.at("links")[1].at("change"), "added");
    EXPECT_EQ(post("/reload?dry_run=yes&confirm_within=5s").body.at("confirm_within_s"), 5.0);
    EXPECT_EQ(names(), std::vector<std::string>{"fc"});
    EXPECT_EQ(state(), "file");
    EXPECT_FALSE(is_kept());
    EXPECT_EQ(notify.heard(), "");
}

TEST_F(Reload, with_an_invalid_query_is_refused) {
    write({"sim:fc"});
    ASSERT_TRUE(start());
    for (const char* query :
         {"?confirm_witin=30s", "?confirm_within=30", "?confirm_within=10ms", "?confirm_within=2h", "?dry_run=maybe"}) {
        const Answer answer = post(std::string{"/reload"} + query);
        EXPECT_EQ(answer.status, 400) << query;
        EXPECT_EQ(answer.body.at("what"), "invalid");
    }
    EXPECT_NE(post("/reload?confirm_witin=30s").body.at("error").dump().find("did you mean 'confirm_within'"), std::string::npos);
    EXPECT_EQ(post("/reload/confirm").status, 409);
}

TEST_F(Reload, by_sighup_reads_conf_d_too) {
    write({"sim:fc"});
    ASSERT_TRUE(start());
    std::filesystem::create_directory(dir / "conf.d");
    dir.write("conf.d/10.json", R"({"links": ["sim:fc,name=two"]})");
    daemon->signal(SIGHUP);
    EXPECT_TRUE(has_names({"fc", "two"}));
    dir.write("conf.d/10.json", "{}");
    daemon->signal(SIGHUP);
    EXPECT_TRUE(has_names({"fc"}));
    EXPECT_TRUE(daemon->until_says("reload: two removed"));
}

TEST_F(Reload, that_is_confirmed_stays_in_effect_after_a_restart) {
    write({"sim:fc"});
    ASSERT_TRUE(start());
    write({"sim:fc", "sim:fc,name=two"});
    EXPECT_EQ(post("/reload?confirm_within=30s").body.at("confirm_within_s"), 30.0);
    EXPECT_EQ(state(), "unconfirmed");
    EXPECT_GT(daemon->status().at("gateway").at("config").at("confirm_within_s"), 0.0);
    EXPECT_TRUE(is_kept());
    EXPECT_EQ(post("/reload/confirm").body, (json{{"confirmed", true}}));
    EXPECT_EQ(state(), "file");
    EXPECT_FALSE(is_kept());
    EXPECT_EQ(post("/reload/confirm").status, 409);
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(), 0);
    ASSERT_TRUE(start());
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "two"}));
    EXPECT_EQ(state(), "file");
}

TEST_F(Reload, that_is_not_confirmed_in_time_is_undone) {
    write({"sim:fc", "sim:fc,name=old"});
    ASSERT_TRUE(start());
    write({"sim:fc", "sim:fc,name=new"});
    EXPECT_EQ(post("/reload?confirm_within=1s").status, 200);
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "new"}));
    EXPECT_TRUE(has_names({"fc", "old"}));
    EXPECT_TRUE(wait_until([&] { return state() == "not the file"; }));
    EXPECT_TRUE(daemon->until_says("not confirmed in time; the previous configuration is restored"));
    EXPECT_EQ(post("/reload/confirm").status, 409) << "too late";
    daemon->signal(SIGKILL);    // simulates a power failure
    daemon->wait();
    ASSERT_TRUE(start());
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "old"})) << "and again";
    EXPECT_EQ(state(), "not the file");
    EXPECT_TRUE(daemon->until_says("was not confirmed; running the previous configuration"));
    EXPECT_EQ(post("/reload").body.at("changed"), true) << "the user takes the file";
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "new"}));
    EXPECT_EQ(state(), "file");
    EXPECT_FALSE(is_kept());
}

TEST_F(Reload, that_was_not_confirmed_before_a_restart_is_undone_by_the_restart) {
    write({"sim:fc", "sim:fc,name=old"});
    ASSERT_TRUE(start({"sim:fc,name=line"}));
    write({"sim:fc", "sim:fc,name=new"});
    EXPECT_EQ(post("/reload?confirm_within=1m").status, 200);
    daemon->signal(SIGKILL);
    daemon->wait();
    ASSERT_TRUE(start({"sim:fc,name=line"}));
    EXPECT_EQ(names(), (std::vector<std::string>{"fc", "old", "line"}));
    EXPECT_EQ(state(), "not the file");
    EXPECT_EQ(post("/reload/confirm").status, 409) << "nobody waits for it any more";
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(), 0);
    write({"sim:fc,name=newest"});    // a file written since then has priority
    ASSERT_TRUE(start());
    EXPECT_EQ(names(), std::vector<std::string>{"newest"});
    EXPECT_EQ(state(), "file");
    EXPECT_FALSE(is_kept());
}

TEST_F(Reload, repeated_before_confirmation_falls_back_to_the_last_confirmed_configuration) {
    write({"sim:fc,name=a"});
    ASSERT_TRUE(start());
    write({"sim:fc,name=b"});
    EXPECT_EQ(post("/reload?confirm_within=1m").status, 200);
    write({"sim:fc,name=c"});
    EXPECT_EQ(post("/reload?confirm_within=1s").status, 200);
    EXPECT_TRUE(has_names({"a"}));
    write({"sim:fc,name=d"});
    EXPECT_EQ(post("/reload?confirm_within=1m").status, 200);
    EXPECT_EQ(post("/reload").body.at("changed"), false) << "it holds now";
    EXPECT_EQ(state(), "file");
    EXPECT_EQ(post("/reload/confirm").status, 409);
    write({"sim:fc,name=a"});
    EXPECT_EQ(post("/reload?confirm_within=1m").status, 200);
    write({"sim:fc,name=d"});
    const Answer back = post("/reload?confirm_within=1m");
    EXPECT_EQ(back.body.at("changed"), true);
    EXPECT_EQ(back.body.at("confirm_within_s"), nullptr) << "that had been confirmed";
    EXPECT_EQ(state(), "file");
}

TEST_F(Reload, that_can_not_be_kept_for_a_restart_is_refused) {
    write({"sim:fc"});
    dir.write("state", "no folder");
    ASSERT_TRUE(start());
    write({"sim:fc,name=two"});
    const Answer answer = post("/reload?confirm_within=30s");
    EXPECT_EQ(answer.status, 409);
    EXPECT_EQ(answer.body.at("what"), "refused");
    EXPECT_EQ(names(), std::vector<std::string>{"fc"});
    EXPECT_EQ(post("/reload").status, 200) << "without a confirmation it is";
    EXPECT_EQ(names(), std::vector<std::string>{"two"});
}

TEST_F(Reload, without_a_file_changes_nothing) {
    Daemon line{ANOGATED, dir / "line", {"sim:fc"}};
    ASSERT_TRUE(line.until_answers());
    EXPECT_EQ(line.status().at("gateway").at("config"), (json{{"file", nullptr}, {"state", "command line"}}));
    const std::string answer = http(dir / "line", "POST /reload HTTP/1.0\r\nContent-Length: 0\r\n\r\n");
    EXPECT_EQ(json::parse(body_of(answer)).at("changed"), false);
}

// Frames are forwarded while many clients request reloads at once, by signals and by requests.
TEST_F(Reload, storms_do_not_disturb_forwarding) {
    stay_on_one_processor();
    PtyDevice device{dir / "fc"};
    const json stays = {"serial:" + device.path() + ",name=fc,pace=off", "udp-listen:127.0.0.1:0,name=ground"};
    write(stays);
    ASSERT_TRUE(start());
    ASSERT_TRUE(daemon->until_up("fc") && daemon->until_up("ground"));
    UdpPeer peer;
    const auto port = daemon->port("ground");
    int sent = 0, came = 0;
    std::vector<int> asking;
    const auto one = [&](int n) {
        return frame(0xDC, 0xFE, 0xF1, {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8), 1});
    };
    peer.send(port, frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    ASSERT_TRUE(daemon->until([&](const json&) { return daemon->count("ground", "frames_in") == 1; }));
    const std::string request = "POST /reload HTTP/1.0\r\nContent-Length: 0\r\n\r\n";
    int storms = 0;
    const auto storm = [&] {
        ++storms;
        json links = stays;
        for (int i = 0; i < storms % 4; ++i) links.push_back("sim:fc,name=sim" + std::to_string(i) + ",broadcast=no,flood=no");
        write(links);
        daemon->signal(SIGHUP);
        for (const int fd : asking) ::close(fd);    // some have their answer, some disconnect before it
        asking.clear();
        for (int i = 0; i < 3; ++i) {
            const int fd = connect_unix(dir / "control");
            if (fd < 0) continue;
            ::send(fd, request.data(), request.size(), MSG_NOSIGNAL);
            asking.push_back(fd);
        }
    };
    EXPECT_TRUE(wait_until(
        [&] {
            for (int i = 0; i < 10 && sent < 3000 && sent - came < 100; ++i) device.write(one(sent++));
            for (const Bytes& f : peer.frames()) {
                if (f[3] != 0xF1) continue;
                EXPECT_EQ(f, one(came++));
            }
            if (sent / 100 > storms) storm();
            return came == 3000;
        },
        60s))
        << came << " of " << sent;
    for (const int fd : asking) ::close(fd);
    EXPECT_TRUE(daemon->until([&](const json&) { return daemon->count("fc", "frames_in") == 3000; })) << "once there is a place";
    daemon->signal(SIGHUP);
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(), 0) << daemon->output();
}

TEST_F(Reload, during_a_stop_does_not_prevent_a_clean_end) {
    PtyDevice stuck{dir / "stuck"};
    write({"serial:" + stuck.path() + ",pace=off", "udp-listen:127.0.0.1:0,name=ground"});
    ASSERT_TRUE(start());
    ASSERT_TRUE(daemon->until_up("stuck"));
    UdpPeer load;
    const auto port = daemon->port("ground");
    ASSERT_TRUE(daemon->until([&](const auto&) {
        for (int i = 0; i < 50; ++i) load.send(port, frame(0xDD, 0xFF, 0xF1, Bytes(200, 1)));
        return daemon->count("stuck", "waiting") > 0;
    }));
    write({"udp-listen:127.0.0.1:0,name=ground"});
    daemon->signal(SIGHUP);
    std::this_thread::sleep_for(20ms);    // while it waits for the removed link
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(), 0) << daemon->output();
}

}    // namespace
}    // namespace reload_tests
