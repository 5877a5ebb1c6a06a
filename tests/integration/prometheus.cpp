// The metrics of the gateway, read by a real Prometheus; the dashboard and the alert rules, run on them.
#include <support/http.hpp>
#include <support/process.hpp>
#include <support/temp_dir.hpp>
#include <support/udp_peer.hpp>
#include <support/vendor_frames.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <memory>
#include <regex>
#include <set>
#include <sstream>
#include <string>

namespace prometheus_tests {
namespace {

using namespace support;
using nlohmann::json;

/// A program of the package prometheus, which tools/test unpacks; empty: not available.
std::string program(const std::string& name) {
    std::istringstream path{std::string{std::getenv("PATH") ? std::getenv("PATH") : ""} + ":" ANOGATE_SOURCE_DIR
                                                                                          "/build/prometheus/usr/bin"};
    for (std::string folder; std::getline(path, folder, ':');)
        if (const std::string file = folder + "/" + name; ::access(file.c_str(), X_OK) == 0) return file;
    return {};
}

std::string file_text(const std::string& path) {
    std::ifstream file{path};
    return {std::istreambuf_iterator<char>{file}, {}};
}

/// The output of a shell command; its exit status is ignored.
std::string output_of(const std::string& command) {
    Shell shell{command};
    shell.wait();
    return shell.output();
}

class Prometheus : public testing::Test {
protected:
    void SetUp() override {
        if (program("promtool").empty() || program("prometheus").empty()) GTEST_SKIP() << "the package prometheus is not here";
    }
    const std::string promtool = program("promtool");
    const std::string rules = ANOGATE_SOURCE_DIR "/config/prometheus/alerts.yml";
    const std::string dashboard = ANOGATE_SOURCE_DIR "/config/prometheus/anogate.json";
};

/// With a gateway that has metrics to report, and names that need escaping.
class PrometheusAndGateway : public Prometheus {
protected:
    void SetUp() override {
        Prometheus::SetUp();
        if (IsSkipped()) return;
        const std::string config = dir.write(
            "anogate.json",
            R"({"links": [{"name": "g\"r\\ 地", "kind": "udp-listen", "address": "127.0.0.1:0"}, "serial:/dev/absent"],
                               "tunnel": {"links": ["absent"], "port": 0}})");
        daemon = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", config});
        ASSERT_TRUE(daemon->until_answers()) << daemon->output();
        host.send(daemon->port("g\"r\\ 地"), vendor::who_are_you);
        ASSERT_TRUE(daemon->until([](const json& status) { return !status.at("routes").empty(); }));
    }
    std::string metrics() const { return body_of(http(socket, "GET /metrics HTTP/1.0\r\n\r\n")); }

    TempDir dir;
    std::string socket = dir / "control.sock";
    std::unique_ptr<Daemon> daemon;
    UdpPeer host;
};

TEST_F(PrometheusAndGateway, finds_no_fault_in_the_metrics_text) {
    const std::string text = dir.write("metrics", metrics());
    EXPECT_EQ(run(promtool + " check metrics < " + text), 0);
    const std::string wrong = dir.write("wrong", metrics() + "anogate_link_up{link=\"x\"} 1 1 1\n");
    EXPECT_NE(output_of(promtool + " check metrics < " + wrong), "") << "it would say so";
}

/// The first words after "NAME" in the output of a process; waits for them.
std::string word_behind(Process& process, const std::string& words) {
    EXPECT_TRUE(process.until_says(words)) << process.output();
    const std::regex word{words + "(\\S+)"};
    std::smatch found;
    wait_until([&] { return std::regex_search(process.output(), found, word) || !process.is_running(); });
    return found.size() == 2 ? found[1].str() : "";
}

/// A real Prometheus, which supports only TCP, so a relay in front of the socket is needed.
class PrometheusScrapes : public PrometheusAndGateway {
protected:
    void SetUp() override {
        PrometheusAndGateway::SetUp();
        if (IsSkipped() || HasFatalFailure()) return;
        relay = std::make_unique<Shell>("exec socat -d -d TCP-LISTEN:0,bind=127.0.0.1,fork UNIX-CONNECT:" + socket);
        const std::string gateway = word_behind(*relay, "listening on AF=2 ");
        const std::string config = dir.write(
            "prometheus.yml", "global: {scrape_interval: 1s}\nrule_files: ['" + rules +
                                  "']\nscrape_configs:\n- job_name: anogate\n  static_configs: [{targets: ['" + gateway +
                                  "']}]\n");
        prometheus = std::make_unique<Process>(
            program("prometheus"), std::vector<std::string>{"--config.file=" + config, "--storage.tsdb.path=" + (dir / "data"),
                                                            "--web.listen-address=127.0.0.1:0"});
        address = word_behind(*prometheus, "msg=\"Listening on\" address=");
    }
    /// The values of a query; null: it is invalid.
    json query(const std::string& expression) const {
        const json answer = json::parse(output_of("curl -s -G --data-urlencode \"query@-\" http://" + address +
                                                  "/api/v1/query <<'END'\n" + expression + "\nEND\n"),
                                        nullptr, false);
        return answer.is_object() && answer.value("status", "") == "success" ? answer.at("data").at("result") : json{};
    }
    /// The value of a query; empty: it has none or several.
    std::string value(const std::string& expression) const {
        const json result = query(expression);
        return result.size() == 1 ? result.at(0).at("value").at(1).get<std::string>() : "";
    }

    std::unique_ptr<Shell> relay;
    std::unique_ptr<Process> prometheus;
    std::string address;
};

TEST_F(PrometheusScrapes, counters_with_the_names_of_the_links) {
    EXPECT_TRUE(wait_until([&] { return value("up") == "1"; })) << prometheus->output();
    EXPECT_EQ(value(R"(anogate_link_frames_in_total{link="g\"r\\ 地"})"), "1");
    EXPECT_EQ(value(R"(anogate_link_up{link="absent"})"), "0");
    EXPECT_EQ(value(R"(anogate_routes{via="learned"})"), "1");
    EXPECT_EQ(query("anogate_tunnel_in_total").size(), 1u);
    EXPECT_EQ(query("process_open_fds").size(), 1u);
}

// The names of metrics in PromQL expressions.
std::set<std::string> metrics_in(const std::string& text) {
    const std::regex name{"\\b(anogate|process)_[a-z_]+"};
    return {std::sregex_token_iterator{text.begin(), text.end(), name}, {}};
}

std::vector<std::string> expressions_of_dashboard(const std::string& file) {
    std::vector<std::string> all;
    const json dashboard = json::parse(file_text(file));
    for (const json& panel : dashboard.at("panels"))
        for (const json& target : panel.at("targets")) {
            std::string expression = target.at("expr");
            for (const auto& [variable, meant] :
                 {std::pair{"$__rate_interval", "5m"}, std::pair{"$instance", ".*"}, std::pair{"$link", ".*"}})
                for (auto at = expression.find(variable); at != std::string::npos; at = expression.find(variable))
                    expression.replace(at, std::string{variable}.size(), meant);
            all.push_back(expression);
        }
    return all;
}

TEST_F(PrometheusScrapes, all_metrics_that_the_dashboard_queries) {
    ASSERT_TRUE(wait_until([&] { return value("up") == "1"; })) << prometheus->output();
    const std::set<std::string> there = metrics_in(metrics());
    const auto expressions = expressions_of_dashboard(dashboard);
    EXPECT_GT(expressions.size(), 20u);
    for (const std::string& expression : expressions) {
        EXPECT_FALSE(query(expression).is_null()) << expression;
        EXPECT_EQ(expression.find('$'), std::string::npos) << expression;
        for (const std::string& name : metrics_in(expression)) EXPECT_TRUE(there.contains(name)) << name;
    }
    for (const std::string& name : metrics_in(file_text(rules))) EXPECT_TRUE(there.contains(name)) << name;
}

TEST_F(PrometheusScrapes, and_evaluates_the_alert_rules) {
    ASSERT_TRUE(wait_until([&] { return value("up") == "1"; })) << prometheus->output();
    const std::string alerts = "curl -s http://" + address + "/api/v1/rules";
    EXPECT_TRUE(wait_until([&] {
        const json answer = json::parse(output_of(alerts), nullptr, false);
        if (!answer.is_object() || answer.at("data").at("groups").empty()) return false;
        const json& all = answer.at("data").at("groups").at(0).at("rules");
        return std::all_of(all.begin(), all.end(), [](const json& rule) { return rule.at("health") != "err"; }) &&
               all.size() == 11u;
    })) << output_of(alerts);
}

TEST_F(Prometheus, finds_no_fault_in_the_alert_rules) {
    EXPECT_EQ(run(promtool + " check rules " + rules), 0);
    EXPECT_EQ(run(promtool + " test rules " ANOGATE_SOURCE_DIR "/tests/prometheus/alerts_test.yml"), 0);
}

}    // namespace
}    // namespace prometheus_tests
