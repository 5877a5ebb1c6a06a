#include <mqtt/request_admission.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <string>
#include <utility>
#include <vector>

namespace request_admission_tests {
namespace {

using namespace anogate;
using Json = nlohmann::json;

constexpr std::uint64_t second = 1'000'000'000;

struct Admitted {
    std::vector<std::string> allow{"POST /devices/*/commands"};
    RequestAdmission admission{Topics{"g"}, allow};
    std::uint64_t now = 1000 * second;

    RequestMessage message(const std::string& payload, const std::string& client = "shore") const {
        RequestMessage message;
        message.topic = "anogate/v1/g/request/" + client;
        message.payload = payload;
        message.correlation = "c1";
        message.expiry_s = 5;
        message.received_ns = now;
        return message;
    }
    static std::string command(const std::string& key) {
        return R"({"method": "POST", "target": "/devices/0x05/commands/TAKE_OFF", "body": {"values": [150]}, "key": ")" + key +
               "\"}";
    }
    RequestAdmission::Decision admit(const RequestMessage& given) { return admission.admit(given, now); }
    /// The status of the response to a request that is not executed; 0: it is executed.
    int refused(const RequestMessage& given) {
        const auto decision = admit(given);
        const auto* response = std::get_if<Response>(&decision);
        return response == nullptr ? 0 : Json::parse(response->payload)["status"].get<int>();
    }
};

TEST(MqttRequests, an_allowed_request_is_executed_and_answered_with_its_correlation) {
    Admitted a;
    const auto decision = a.admit(a.message(Admitted::command("k")));
    const auto* request = std::get_if<AdmittedRequest>(&decision);
    ASSERT_NE(request, nullptr);
    EXPECT_EQ(request->method, "POST");
    EXPECT_EQ(request->target, "/devices/0x05/commands/TAKE_OFF");
    EXPECT_EQ(request->body, R"({"values":[150]})");
    EXPECT_EQ(request->until_ns, a.now + 5 * second);
    const Response response = a.admission.finish(request->key, 200, R"({"result": 1})");
    EXPECT_EQ(response.topic, "anogate/v1/g/response/shore");
    EXPECT_EQ(response.correlation, "c1");
    EXPECT_EQ(Json::parse(response.payload), (Json{{"status", 200}, {"key", "k"}, {"body", {{"result", 1}}}}));
}

TEST(MqttRequests, a_key_is_executed_once_and_its_response_is_repeated) {
    Admitted a;
    const auto first = a.admit(a.message(Admitted::command("k")));
    ASSERT_TRUE(std::holds_alternative<AdmittedRequest>(first));
    RequestMessage again = a.message(Admitted::command("k"));
    again.correlation = "c2";
    EXPECT_TRUE(std::holds_alternative<std::monostate>(a.admit(again))) << "it still runs";
    const Response response = a.admission.finish(std::get<AdmittedRequest>(first).key, 200, "{}");
    EXPECT_EQ(response.correlation, "c2");
    a.now += 3000 * second;
    const auto late = a.admit(a.message(Admitted::command("k")));
    ASSERT_TRUE(std::holds_alternative<Response>(late));
    EXPECT_EQ(std::get<Response>(late).payload, response.payload);
    EXPECT_TRUE(std::holds_alternative<AdmittedRequest>(a.admit(a.message(Admitted::command("k"), "other"))))
        << "keys of another client are others";
}

TEST(MqttRequests, a_key_of_an_earlier_run_is_not_executed_again) {
    Admitted a;
    a.admission.restore("shore/done", R"({"status": 200})", a.now);
    a.admission.restore("shore/begun", "", a.now);
    EXPECT_EQ(a.refused(a.message(Admitted::command("done"))), 200);
    EXPECT_EQ(a.refused(a.message(Admitted::command("begun"))), 500);
    EXPECT_TRUE(RequestAdmission::is_kept("shore/a"));
    const auto reading = a.admit(a.message(R"({"target": "/status", "key": "a"})"));
    EXPECT_FALSE(RequestAdmission::is_kept(std::get<AdmittedRequest>(reading).key));
}

TEST(MqttRequests, an_expired_request_is_refused) {
    Admitted a;
    RequestMessage late = a.message(Admitted::command("k"));
    late.received_ns = a.now - 5 * second;
    EXPECT_EQ(a.refused(late), 408);
    Json json = Json::parse(Admitted::command("k"));
    json["before"] = 999.9;
    EXPECT_EQ(a.refused(a.message(json.dump())), 408) << "by the boot time of the gateway";
    json["before"] = 1001;
    const auto decision = a.admit(a.message(json.dump()));
    ASSERT_TRUE(std::holds_alternative<AdmittedRequest>(decision)) << "a refused request does not use up its key";
    EXPECT_EQ(std::get<AdmittedRequest>(decision).until_ns, 1001 * second);
    EXPECT_EQ(Json::parse(a.admission.expire(std::get<AdmittedRequest>(decision).key).payload)["status"], 408);
}

TEST(MqttRequests, a_request_that_changes_something_needs_an_end_and_a_key) {
    Admitted a;
    RequestMessage message = a.message(Admitted::command("k"));
    message.expiry_s.reset();
    EXPECT_EQ(a.refused(message), 400);
    message = a.message(Admitted::command(""));
    EXPECT_EQ(a.refused(message), 0) << "its correlation is its key";
    EXPECT_TRUE(std::holds_alternative<std::monostate>(a.admit(message)));
    message.correlation.clear();
    EXPECT_EQ(a.refused(message), 400);
}

TEST(MqttRequests, a_retained_request_is_refused) {
    Admitted a;
    RequestMessage message = a.message(Admitted::command("k"));
    message.is_retained = true;
    EXPECT_EQ(a.refused(message), 400);
}

TEST(MqttRequests, by_default_only_reading_is_allowed) {
    Admitted a;
    a.admission = RequestAdmission{Topics{"g"}, {}};
    EXPECT_EQ(a.refused(a.message(Admitted::command("k"))), 403);
    for (const char* target : {"/status", "/devices", "/devices/0x05/parameters?x=1", "/alarms", "/jobs/3"})
        EXPECT_EQ(a.refused(a.message(Json{{"target", target}}.dump())), 0) << target;
    for (const char* target :
         {"/config", "/frames", "/link", "/recordings", "", "status", "/devices/../config", "//devices", "/"})
        EXPECT_EQ(a.refused(a.message(Json{{"target", target}}.dump())), 403) << target;
}

TEST(MqttRequests, a_rule_covers_its_path_and_what_is_below) {
    const AllowedRequests allowed{{"POST /devices/*/commands", "PUT /devices/0x05/parameters/KP"}};
    EXPECT_TRUE(allowed.allows("POST", "/devices/0x05/commands/TAKE_OFF?while_connected"));
    EXPECT_TRUE(allowed.allows("PUT", "/devices/0x05/parameters/KP"));
    for (const auto& [method, target] : {std::pair{"POST", "/devices/0x05/parameters"},
                                         {"POST", "/devices/0x05"},
                                         {"PUT", "/devices/0x05/parameters/KI"},
                                         {"PUT", "/devices/0x05/parameters/KPX"},
                                         {"DELETE", "/devices/0x05/commands/x"},
                                         {"POST", "/send"},
                                         {"POST", "/devices/5%2Fcommands/commands/x"},
                                         {"POST", "/devices//commands/x"},
                                         {"post", "/devices/1/commands/x"}})
        EXPECT_FALSE(allowed.allows(method, target)) << method << target;
    EXPECT_EQ(fault_in_rule("POST /send"), "");
    for (const char* bad : {"POST", "POST send", "PATCH /send", "POST /", "POST /a b", "POST /send/", ""})
        EXPECT_NE(fault_in_rule(bad), "") << bad;
}

TEST(MqttRequests, invalid_requests_get_a_reason) {
    Admitted a;
    for (const char* bad : {"", "[]", "{}", R"({"target": 3})", R"({"target": "/status", "x": 1})",
                            R"({"target": "/status", "key": 1})", R"({"target": "/status", "before": "1"})"})
        EXPECT_EQ(a.refused(a.message(bad)), 400) << bad;
    for (const char* key : {"a/b", "/1", "a\nb"})
        EXPECT_EQ(a.refused(a.message(Json{{"target", "/status"}, {"key", key}}.dump())), 400) << key;
    EXPECT_EQ(a.refused(a.message(Json{{"target", "/status"}, {"key", std::string(65, 'k')}}.dump())), 400);
    RequestMessage elsewhere = a.message("{}");
    elsewhere.topic = "anogate/v1/other/request/shore";
    EXPECT_TRUE(std::holds_alternative<std::monostate>(a.admit(elsewhere)));
}

TEST(MqttRequests, a_response_goes_to_its_client_alone) {
    Admitted a;
    const auto topic = [&](const std::string& wanted) {
        RequestMessage message = a.message("{}");
        message.response_topic = wanted;
        return std::get<Response>(a.admit(message)).topic;
    };
    EXPECT_EQ(topic("anogate/v1/g/response/shore/7"), "anogate/v1/g/response/shore/7");
    for (const char* other : {"anogate/v1/g/request/shore", "anogate/v1/g/response/other", "anogate/v1/g/response/shore/a/b",
                              "anogate/v1/g/response/shore/#", "anogate/v1/g/response/shore/"})
        EXPECT_EQ(topic(other), "anogate/v1/g/response/shore") << other;
}

TEST(MqttRequests, a_key_is_never_forgotten_early) {
    Admitted a;
    for (std::size_t i = 0; i < RequestAdmission::max_keys; ++i) {
        const auto decision = a.admit(a.message(Admitted::command(std::to_string(i))));
        ASSERT_TRUE(std::holds_alternative<AdmittedRequest>(decision)) << i;
        a.admission.finish(std::get<AdmittedRequest>(decision).key, 200, "{}");
    }
    EXPECT_EQ(a.refused(a.message(Admitted::command("one more"))), 429);
    EXPECT_EQ(a.refused(a.message(Admitted::command("0"))), 200);
    a.now += 3600 * second;
    EXPECT_EQ(a.refused(a.message(Admitted::command("one more"))), 0);
}

TEST(MqttRequests, a_large_response_is_replaced) {
    Admitted a;
    const auto decision = a.admit(a.message(R"({"target": "/devices"})"));
    const Response response = a.admission.finish(std::get<AdmittedRequest>(decision).key, 200,
                                                 '"' + std::string(70'000, 'x') + '"');
    EXPECT_EQ(Json::parse(response.payload)["status"], 413);
    const auto failed = a.admit(a.message(R"({"target": "/devices"})"));
    const Response fault = a.admission.finish(std::get<AdmittedRequest>(failed).key, 0, "no gateway is running");
    EXPECT_EQ(Json::parse(fault.payload), (Json{{"status", 502}, {"error", "no gateway is running"}}));
}

}    // namespace
}    // namespace request_admission_tests
