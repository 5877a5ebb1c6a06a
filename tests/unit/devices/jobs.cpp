// The assignment of devices to jobs, the reports about jobs, and that every job ends.
#include <devices/device_service.hpp>
#include <support/simulated_net.hpp>

#include <gtest/gtest.h>

namespace jobs_tests {
namespace {

using namespace support;
using json = nlohmann::ordered_json;

struct Jobs : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    Jobs() { fake.make_parameters(20); }

    static std::vector<json> take(anogate::http::Producer& lines) {
        std::string text;
        lines.next(text);
        std::vector<json> all;
        std::istringstream stream{text};
        for (std::string line; std::getline(stream, line);) all.push_back(json::parse(line));
        return all;
    }
};

TEST_F(Jobs, a_second_writer_gets_an_error_that_names_the_first) {
    const auto first = net.asked("PUT", "/devices/0xDC/parameters/PAR_0?client=one", R"({"value": 1})");
    const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 2})");
    EXPECT_EQ(status, 409u);
    EXPECT_EQ(error, json::parse(R"x({"error": "0xDC is used by job 1 (writing a parameter, by one)", "error_id": "used_by_job",
        "error_args": {"device": "0xDC", "job": {"error_id": "job_by", "error_args": {"number": "1",
            "action": {"error_id": "writing_parameter", "error_args": {}}, "client": "one"}}}, "what": "busy", "job": 1})x"));
    ASSERT_TRUE(net.until([&] { return first->has_value(); }));
    EXPECT_EQ((*first)->status, 200u);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 2})").status, 200u);
}

TEST_F(Jobs, that_read_share_the_device) {
    const auto first = net.asked("GET", "/devices/0xDC/parameters");
    const auto second = net.asked("GET", "/devices/0xDC/parameters");
    const auto third = net.asked("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})");
    ASSERT_TRUE(net.until([&] { return first->has_value() && second->has_value() && third->has_value(); }));
    EXPECT_EQ((*first)->status, 200u);
    EXPECT_EQ((*first)->json.at("parameters").size(), 20u);
    EXPECT_EQ((*second)->json.at("parameters").size(), 20u);
    EXPECT_EQ((*third)->status, 200u);
}

TEST_F(Jobs, a_device_whose_info_differs_in_each_answer_is_reported_once) {
    fake.instead = [this](ano::FrameView frame) -> std::optional<std::vector<Bytes>> {
        if (ano::host::is_question_for_info(frame)) ++fake.version;
        return std::nullopt;
    };
    for (int i = 0; i < 6; ++i) EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u);
    ASSERT_EQ(net.reports.size(), 1u);
    EXPECT_TRUE(net.reports[0].starts_with("0xDC: its device info differs in each answer")) << net.reports[0];
}

TEST_F(Jobs, frames_that_wait_in_the_gateway_queue_are_not_sent_again) {
    net.queued_until = net.time + 4s;
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u);
    EXPECT_EQ(net.sent.size(), 3 + 2 * 20u);
    EXPECT_TRUE(net.flushed_before.empty());
}

TEST_F(Jobs, a_frame_that_stays_queued_counts_as_sent_after_a_while) {
    net.queued_until = net.time + 1h;
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 504u);
}

TEST_F(Jobs, a_parser_that_may_be_stuck_is_flushed_before_the_request_is_repeated) {
    fake.deaf = true;
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 504u);
    ASSERT_EQ(net.flushed_before.size(), net.sent.size() - 1) << "the line permits one a second";
    EXPECT_EQ(net.flushed_before[0], net.sent[0]);
}

TEST_F(Jobs, name_a_client_with_a_long_name_by_whole_characters_of_it) {
    std::string name = "ab";
    for (int i = 0; i < 40; ++i) name += "飞";
    const auto lines = net.lines("GET", "/devices/0xDC/parameters?client=" + name);
    ASSERT_TRUE(lines);
    lines->start([] {});
    EXPECT_EQ(take(*lines).at(0).at("client"), name.substr(0, 62)) << "a character has three bytes";
}

TEST_F(Jobs, are_reported_line_by_line_to_clients_that_accept_it) {
    fake.make_parameters(200);
    const auto lines = net.lines("GET", "/devices/0xDC/parameters?client=test");
    ASSERT_TRUE(lines);
    bool woken = false;
    lines->start([&] { woken = true; });
    std::vector<json> all = take(*lines);
    ASSERT_EQ(all.size(), 1u);
    EXPECT_EQ(all[0].at("state"), "running");
    EXPECT_EQ(all[0].at("kind"), "parameters");
    EXPECT_EQ(all[0].at("device"), "0xDC");
    EXPECT_EQ(all[0].at("client"), "test");
    while (all.back().at("state") == "running") {
        ASSERT_TRUE(net.until([&] { return std::exchange(woken, false); }));
        for (json& line : take(*lines)) all.push_back(std::move(line));
    }
    EXPECT_GT(all.size(), 3u) << "its progress is told";
    EXPECT_EQ(all.back().at("state"), "done");
    EXPECT_EQ(all.back().at("result").at("parameters").size(), 220u);
    EXPECT_EQ(all[all.size() / 2].at("unit"), "answers");
    std::string more;
    EXPECT_EQ(lines->next(more), anogate::http::Producer::Next::end);
    EXPECT_EQ(more, "");
}

TEST_F(Jobs, are_listed_and_kept_for_a_while) {
    net.ask("GET", "/devices/0xDC/parameters/PAR_1");
    const json jobs = net.ask("GET", "/jobs").json.at("jobs");
    ASSERT_EQ(jobs.size(), 1u);
    EXPECT_EQ(jobs[0].at("id"), 1);
    EXPECT_EQ(jobs[0].at("state"), "done");
    EXPECT_FALSE(jobs[0].contains("result")) << "the list tells no results";
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("result").at("name"), "PAR_1");
    for (const char* none : {"2", "x", "-1", "99999999999"})
        EXPECT_EQ(net.ask("GET", "/jobs/" + std::string{none}).status, 404u) << none;
    net.pass(11min);
    net.ask("GET", "/devices/0xDC/parameters/PAR_1");
    EXPECT_EQ(net.ask("GET", "/jobs/1").status, 404u);
}

TEST_F(Jobs, are_limited_in_number_when_kept_and_when_running) {
    for (int i = 0; i < 70; ++i) net.ask("GET", "/devices/0xDC/parameters/PAR_1");
    EXPECT_EQ(net.ask("GET", "/jobs").json.at("jobs").size(), anogate::DeviceService::max_jobs);
    fake.deaf = true;
    for (std::size_t i = 0; i < anogate::DeviceService::running_places.of_control; ++i) {
        net.peer = std::to_string(i);
        net.asked("GET", "/devices/0xDC/parameters/" + net.peer);
    }
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 503u);
    EXPECT_NE(net.ask("POST", "/devices/0xDC/commands/by-cid", R"({"cid": [16, 0, 2]})").status, 503u) << "a command has one";
    net.pass(1min);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 504u) << "they ended";
}

TEST_F(Jobs, can_be_cancelled_by_any_client) {
    const auto asked = net.asked("GET", "/devices/0xDC/parameters");
    net.pass(50ms);
    const json job = net.ask("DELETE", "/jobs/1").json;
    EXPECT_EQ(job.at("state"), "cancelled");
    ASSERT_TRUE(asked->has_value());
    EXPECT_EQ((*asked)->status, 409u);
    const std::size_t sent = net.sent.size();
    net.pass(5s);
    EXPECT_EQ(net.sent.size(), sent) << "nothing more is asked";
    EXPECT_EQ(net.ask("DELETE", "/jobs/1").json, job) << "once more";
}

TEST_F(Jobs, end_when_a_client_that_requested_this_disconnects) {
    fake.deaf = true;
    net.asked("GET", "/devices/0xDC/parameters?while_connected");
    net.asked("GET", "/devices/0xDC/parameters?values=0");
    net.pass(50ms);
    net.leave();
    net.pass(50ms);
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("state"), "cancelled");
    EXPECT_EQ(net.ask("GET", "/jobs/2").json.at("state"), "running") << "another goes on";
    auto lines = net.lines("GET", "/devices/0xDC/parameters?while_connected");
    net.pass(50ms);
    lines.reset();
    net.pass(50ms);
    EXPECT_EQ(net.ask("GET", "/jobs/3").json.at("state"), "cancelled");
}

// An upgrade or a calibration whose client does not wait for its end.
TEST_F(Jobs, are_not_ended_by_a_client_that_only_watches_them) {
    ASSERT_EQ(net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})").status, 202u);
    const auto watched_and_left = [&] {
        auto lines = net.lines("GET", "/jobs/1?while_connected");
        net.pass(50ms);
        lines.reset();
        net.pass(50ms);
        return net.ask("GET", "/jobs/1").json.at("state");
    };
    net.access = anogate::http::Access::view;
    EXPECT_EQ(watched_and_left(), "running");
    net.access = anogate::http::Access::control;
    net.is_foreign = true;
    EXPECT_EQ(watched_and_left(), "running") << "a page of another site, in the browser of somebody who controls";
    net.is_foreign = false;
    EXPECT_EQ(watched_and_left(), "cancelled") << "who controls may cancel it";
}

TEST_F(Jobs, that_read_everything_are_shared_by_requests_made_meanwhile) {
    const auto first = net.asked("GET", "/devices/0xDC/parameters");
    net.pass(50ms);
    const auto second = net.asked("GET", "/devices/0xDC/parameters");
    const auto other = net.asked("GET", "/devices/0xDC/parameters?values=0");
    EXPECT_EQ(net.ask("GET", "/jobs").json.at("jobs").size(), 2u);
    ASSERT_TRUE(net.until([&] { return first->has_value() && second->has_value() && other->has_value(); }));
    EXPECT_EQ((*first)->json, (*second)->json);
    EXPECT_EQ((*first)->json.at("parameters")[0].at("value"), 0);
    EXPECT_FALSE((*other)->json.at("parameters")[0].contains("value"));
    net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_EQ(net.ask("GET", "/jobs").json.at("jobs").size(), 3u) << "one that has ended is not shared";
}

TEST_F(Jobs, that_read_before_a_write_are_not_shared_after_it) {
    fake.make_parameters(300);
    const auto before = net.asked("GET", "/devices/0xDC/parameters");
    net.pass(100ms);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/0", R"({"value": 77})").status, 200u);
    ASSERT_FALSE(before->has_value());
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").json.at("parameters")[0].at("value"), 77);
    EXPECT_EQ(net.ask("GET", "/jobs").json.at("jobs").size(), 3u);
}

TEST_F(Jobs, that_are_shared_continue_while_any_client_needs_them) {
    fake.deaf = true;
    auto one = net.lines("GET", "/devices/0xDC/parameters?while_connected");
    auto two = net.lines("GET", "/devices/0xDC/parameters?while_connected");
    net.pass(50ms);
    one.reset();
    net.pass(50ms);
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("state"), "running");
    two.reset();
    net.pass(50ms);
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("state"), "cancelled");
    auto three = net.lines("GET", "/devices/0xDC/parameters?while_connected");
    auto stays = net.lines("GET", "/devices/0xDC/parameters");
    stays.reset();
    three.reset();
    net.pass(50ms);
    EXPECT_EQ(net.ask("GET", "/jobs/2").json.at("state"), "running") << "one of them did not say that it ends with him";
}

TEST_F(Jobs, keep_a_limited_number_of_result_bytes) {
    using Service = anogate::DeviceService;
    constexpr std::size_t large = Service::max_results / 4;
    for (int i = 0; i < 6; ++i) {
        anogate::JobOrder order{
            anogate::JobKind::parameters, ano::host::Operation::read, 0xDC, false, "", [](const anogate::WorkPlace&) {
                struct Large final : anogate::Work {
                    void start(TimePoint) override { finish({200, '"' + std::string(large, 'x') + '"', {}, ""}); }
                    void run(TimePoint) override {}
                    void cancel(TimePoint) override {}
                };
                return std::make_unique<Large>();
            }};
        ASSERT_EQ(net.service.begin(std::move(order), net.time).index(), 0u);
        net.pass(10ms);
    }
    EXPECT_EQ(net.ask("GET", "/jobs/3").status, 404u) << "the oldest go first";
    EXPECT_EQ(net.ask("GET", "/jobs/4").json.at("result").get<std::string>().size(), large);
    EXPECT_EQ(net.ask("GET", "/jobs/6").json.at("result").get<std::string>().size(), large);
}

// While the answer is built, the loop of the gateway also runs its other tasks.
TEST_F(Jobs, with_many_rows_are_reported_a_few_at_a_time) {
    constexpr std::size_t many = 1000;
    fake.parameters.clear();
    fake.make_parameters(many);
    const auto answer = net.asked("GET", "/devices/0xDC/parameters");
    std::size_t heard = 0, turns = 0;
    ASSERT_TRUE(net.until([&] {
        turns = std::exchange(heard, fake.heard.size()) == fake.heard.size() ? turns + 1 : 0;
        return answer->has_value();
    }));
    EXPECT_GE(turns, 10u);
    const json& all = (*answer)->json.at("parameters");
    ASSERT_EQ(all.size(), many);
    for (std::size_t i = 0; i < many; ++i) EXPECT_EQ(all[i].at("name"), "PAR_" + std::to_string(i));
    fake.commands.assign(many, {{1, 2, 3}, {1, 9}, "COMMAND", "says something"});
    const auto [status, commands] = net.ask("GET", "/devices/0xDC/commands");
    EXPECT_EQ(status, 200u);
    EXPECT_EQ(commands.at("device").at("address"), "0xDC");
    ASSERT_EQ(commands.at("commands").size(), many);
    EXPECT_EQ(commands.at("commands")[many - 1],
              json::parse(R"({"id": 999, "name": "COMMAND", "text": "says something", "values": ["u8", "f32"]})"));
}

TEST_F(Jobs, that_are_finished_share_one_text_among_all_clients) {
    fake.parameters.clear();
    fake.make_parameters(1000);
    net.ask("GET", "/devices/0xDC/parameters");
    const auto ask = [&] { return net.routes.answer(SimulatedNet::request("GET", "/jobs/1")).shared; };
    const auto first = ask(), second = ask();
    ASSERT_TRUE(first);
    EXPECT_EQ(first, second);
    auto lines = net.lines("GET", "/jobs/1");
    std::string line, part;
    auto next = anogate::http::Producer::Next::part;
    while (next == anogate::http::Producer::Next::part) {
        part.clear();
        next = lines->next(part);
        EXPECT_LE(part.size(), std::size_t{64} * 1024) << "what is written between two turns of the loop";
        line += part;
    }
    EXPECT_EQ(next, anogate::http::Producer::Next::end);
    EXPECT_EQ(line, *first);
    EXPECT_EQ(json::parse(line).at("result").at("parameters").size(), 1000u);
}

TEST_F(Jobs, on_a_port_and_on_the_device_behind_it_count_for_one_device) {
    net.where[3] = {.is_known = true};
    net.same.emplace(3, 0xDC);
    const auto first = net.asked("PUT", "/devices/0xDC/parameters/PAR_0?client=one", R"({"value": 1})");
    const auto [status, error] = net.ask("PUT", "/devices/3/parameters/PAR_0", R"({"value": 2})");
    EXPECT_EQ(status, 409u);
    EXPECT_EQ(error.at("error"), "0x03 is used by job 1 (writing a parameter, by one)");
    ASSERT_TRUE(net.until([&] { return first->has_value(); }));
}

TEST_F(Jobs, end_at_once_when_the_rules_refuse_their_frames) {
    net.refuses[0xE1] = "refused by the rules 'control.receive'";
    const ano::TimePoint begin = net.time;
    const auto [status, error] = net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})");
    EXPECT_EQ(status, 403u);
    EXPECT_EQ(error.at("what"), "refused");
    EXPECT_EQ(error.at("error"), "refused by the rules 'control.receive'");
    EXPECT_LT(net.time - begin, 2s);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u) << "what the rules let pass";
}

TEST_F(Jobs, that_read_continue_when_frames_of_another_job_are_refused) {
    const auto reads = net.asked("GET", "/devices/0xDC/parameters");
    net.refuses[0xE1] = "no";
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})").status, 403u);
    ASSERT_TRUE(net.until([&] { return reads->has_value(); }));
    EXPECT_EQ((*reads)->status, 200u);
    net.refuses = {{0xE0, "no"}};
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 403u);
}

TEST_F(Jobs, report_the_changes_made_before_the_rules_refused_the_rest) {
    const auto writes = net.asked("POST", "/devices/0xDC/apply", R"({"parameters": {"PAR_0": 7, "PAR_1": 7}, "rollback": true})");
    const auto has_written = [&] {
        return std::any_of(net.sent.begin(), net.sent.end(), [](const Bytes& one) { return one[3] == 0xE1; });
    };
    ASSERT_TRUE(net.until(has_written));
    net.refuses[0xE1] = "no";
    ASSERT_TRUE(net.until([&] { return writes->has_value(); }, 1min));
    EXPECT_EQ((*writes)->status, 403u);
    EXPECT_TRUE((*writes)->json.at("error").get<std::string>().starts_with("no")) << (*writes)->json;
    EXPECT_EQ((*writes)->json.at("result").at("parameters").size(), 2u) << (*writes)->json;
}

TEST_F(Jobs, leave_quota_for_clients_that_do_not_wait_for_them) {
    std::vector<decltype(net.lines("GET", ""))> waiting;
    for (std::size_t i = 0; i < anogate::DeviceService::waiting_places.of_control / 2; ++i)    // of one client
        waiting.push_back(net.lines("GET", "/devices/0xDC/parameters"));
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 503u);
    EXPECT_EQ(net.ask("GET", "/jobs").status, 200u);
    waiting.pop_back();
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u);
}

TEST_F(Jobs, only_allowed_on_the_ground_check_the_flight_state_again_after_a_pause) {
    net.ask("GET", "/devices/0xDC/parameters");
    net.passes(frame(0xDC, 0xFF, 0x06, {1, 2, 0, 0, 0}));    // it flies
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "restore_defaults"})").status, 409u);
    net.pass(2min);    // and lands
    ASSERT_FALSE(net.listens);
    EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "restore_defaults"})").status, 200u);
}

TEST_F(Jobs, do_not_write_nan_or_infinity) {
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": "nan"})").status, 422u);
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": "-inf"})").status, 422u);
}

TEST_F(Jobs, are_not_started_for_an_absent_device) {
    const TimePoint begin = net.time;
    const auto [status, absent] = net.ask("GET", "/devices/0xDD/parameters");
    EXPECT_EQ(status, 404u);
    EXPECT_EQ(absent.at("error"), "0xDD was not seen and does not answer");
    EXPECT_EQ(net.time - begin, 2s);
    EXPECT_EQ(net.sent, std::vector<Bytes>(4, frame(0xFE, 0xDD, 0xE0, {0, 0, 0}))) << "it was asked whether it is there";
    net.sent.clear();
    EXPECT_EQ(net.ask("GET", "/devices/nobody/parameters").status, 404u);
    EXPECT_EQ(net.ask("GET", "/devices/255/parameters").status, 400u);
    EXPECT_EQ(net.ask("GET", "/devices/host/parameters").status, 400u);
    EXPECT_TRUE(net.sent.empty());
}

TEST_F(Jobs, contact_an_unseen_device_before_anything_else) {
    net.add(0xDD).make_parameters(3);
    net.where[0xDD] = {};
    net.learns = true;
    const TimePoint begin = net.time;
    const auto several = net.asked("GET", "/devices/0xDD/commands");
    const auto [status, answer] = net.ask("PUT", "/devices/0xDD/parameters/PAR_0", R"({"value": 1})");
    EXPECT_EQ(status, 200u) << answer;
    EXPECT_LT(net.time - begin, 1s);
    ASSERT_TRUE(several->has_value());
    EXPECT_EQ((*several)->status, 200u);
    EXPECT_EQ(net.sent.front(), frame(0xFE, 0xDD, 0xE0, {0, 0, 0}));
    EXPECT_NE(net.sent[1], net.sent.front()) << "both wait for the same answer";
}

TEST_F(Jobs, accept_an_acknowledgement_from_a_port_of_the_device) {
    net.fakes[0]->instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() != 0xE0 || f.data()[0] != 0x10) return std::nullopt;
        return std::vector<Bytes>{frame(0x05, 0xFE, 0x00, {f.id(), f.checks().sum, f.checks().add})};
    };
    const TimePoint begin = net.time;
    const auto [status, job] = net.ask("POST", "/devices/0xDC/actions", R"({"action": "save"})");
    EXPECT_EQ(status, 200u) << job;
    EXPECT_LT(net.time - begin, 1s);
    EXPECT_EQ(job.value("note", ""), "acknowledged by 0x05, a port");
    const auto lists_the_port = [&] {
        const auto devices = net.ask("GET", "/devices").json.at("devices");
        return std::any_of(devices.begin(), devices.end(), [](const auto& one) { return one.at("address") == "0x05"; });
    };
    EXPECT_FALSE(lists_the_port()) << "it is no device of its own";
    net.passes(frame(0x05, 0xFE, 0x03, Bytes(7)));
    EXPECT_TRUE(lists_the_port()) << "now it is";
}

TEST_F(Jobs, are_not_refused_when_another_host_writes_and_name_that_host) {
    fake.commands = {{{1, 0, 1}, {}, "LOCK", ""}};
    net.ask("GET", "/devices/0xDC/parameters");
    const std::string conflict = "0xD2 also writes to 0xDC";
    for (const std::uint8_t to : {std::uint8_t{0xDC}, std::uint8_t{0xFF}}) {
        net.passes(frame(0xD2, to, 0xE1, {0, 0, 5}));
        const auto land = net.ask("POST", "/devices/0xDC/commands/LOCK");
        EXPECT_EQ(land.status, 200u) << land.json;
        EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})").status, 200u);
        EXPECT_EQ(net.ask("POST", "/devices/0xDC/actions", R"({"action": "save"})").status, 200u);
        EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u);
        const auto all = net.ask("GET", "/jobs").json.at("jobs");
        for (const auto& job : all) {
            if (job.at("id") < all.size() - 3 && job.at("kind") != "command") continue;
            EXPECT_EQ(job.value("conflict", ""), job.at("kind") == "parameters" ? "" : conflict) << job;
        }
        net.pass(3s);
        net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})");
        EXPECT_FALSE(net.ask("GET", "/jobs").json.at("jobs").back().contains("conflict"));
    }
}

TEST_F(Jobs, name_other_writers_while_they_run) {
    const auto begun = net.ask("POST", "/devices/0xDC/calibration", R"({"what": "accelerometer"})");
    ASSERT_EQ(begun.status, 202u) << begun.json;
    net.pass(1s);
    net.passes(frame(0xD2, 0xDC, 0xE1, {0, 0, 5}));
    net.pass(1s);
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.value("conflict", ""), "0xD2 also writes to 0xDC");
    EXPECT_EQ(net.ask("GET", "/jobs/1").json.at("state"), "running");
}

TEST_F(Jobs, that_waited_through_a_stall_are_refused) {
    net.stood_still = true;
    EXPECT_EQ(net.ask("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})").status, 503u);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 200u);
}

TEST_F(Jobs, stop_listening_some_time_after_the_last_one) {
    EXPECT_FALSE(net.listens);
    net.ask("GET", "/devices/0xDC/parameters");
    EXPECT_TRUE(net.listens);
    net.pass(2min);
    EXPECT_FALSE(net.listens);
}

TEST_F(Jobs, end_when_the_gateway_stops) {
    const auto asked = net.asked("GET", "/devices/0xDC/parameters");
    net.pass(20ms);
    net.service.stop(net.time);
    ASSERT_TRUE(asked->has_value());
    EXPECT_EQ((*asked)->status, 503u);
    EXPECT_FALSE(net.listens);
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 503u);
}

TEST_F(Jobs, that_the_gateway_ends_report_unfinished_work) {
    fake.instead = [](ano::FrameView f) { return f.id() == 0xE1 ? std::optional{std::vector<Bytes>{}} : std::nullopt; };
    auto lines = net.lines("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})");
    const auto writes = [&] {
        return std::any_of(net.sent.begin(), net.sent.end(), [](const Bytes& sent) { return sent[3] == 0xE1; });
    };
    ASSERT_TRUE(net.until(writes));
    take(*lines);
    net.service.stop(net.time);
    std::string text;
    EXPECT_EQ(lines->next(text), anogate::http::Producer::Next::end) << "its last line is there at once";
    const json last = json::parse(text);
    EXPECT_EQ(last.at("state"), "cancelled");
    EXPECT_EQ(last.at("error"), "the gateway is stopping: PAR_0 may have been written");
}

TEST_F(Jobs, that_were_not_started_when_the_gateway_stops_report_this) {
    auto lines = net.lines("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})");
    net.service.stop(net.time);
    std::string text;
    lines->next(text);
    EXPECT_EQ(json::parse(text).at("error"), "the gateway is stopping: nothing was started");
}

/// Accepts messages as slowly as the test sets.
struct Socket final : anogate::http::WebSocket {
    std::vector<json> told;
    bool is_slow = false;
    std::optional<std::uint16_t> closed;
    bool send(Message message, Kind) override {
        told.push_back(json::parse(*message));
        return true;
    }
    std::size_t waiting() const noexcept override { return is_slow ? 1 : 0; }
    std::uint64_t reads() const noexcept override { return 0; }
    void close(std::uint16_t code, std::string_view) override { closed = code; }
    void abandon() noexcept override { closed = 0; }
};

TEST_F(Jobs, are_reported_by_messages_on_a_web_socket) {
    fake.make_parameters(200);
    net.asked("GET", "/devices/0xDC/parameters");
    auto request = SimulatedNet::request("GET", "/jobs/1");
    request.headers.push_back({"Connection", "Upgrade"});
    request.headers.push_back({"Upgrade", "websocket"});
    const auto user = std::move(net.routes.answer(request).web_socket);
    ASSERT_TRUE(user);
    EXPECT_TRUE(user->closes_itself());
    Socket socket;
    user->opened(socket);
    ASSERT_EQ(socket.told.size(), 1u);
    EXPECT_EQ(socket.told[0].at("state"), "running");
    net.pass(500ms);
    const std::size_t so_far = socket.told.size();
    EXPECT_GT(so_far, 2u) << "its progress is told";
    socket.is_slow = true;
    net.pass(1min);
    EXPECT_EQ(socket.told.size(), so_far) << "who takes nothing is sent nothing";
    EXPECT_FALSE(socket.closed);
    socket.is_slow = false;
    user->sent_all();
    ASSERT_EQ(socket.told.size(), so_far + 1);
    EXPECT_EQ(socket.told.back().at("state"), "done");
    EXPECT_EQ(socket.told.back().at("result").at("parameters").size(), 220u);
    user->sent_all();
    EXPECT_EQ(socket.closed, 1000);
}

TEST_F(Jobs, devices_are_listed_with_their_known_data) {
    json devices = net.ask("GET", "/devices").json.at("devices");
    ASSERT_EQ(devices.size(), 1u);
    EXPECT_EQ(devices[0], json::parse(R"({"address": "0xDC", "link": "fc", "peer": "/dev/fake", "age": 0.2})"));
    net.ask("GET", "/devices/0xDC/parameters");
    devices = net.ask("GET", "/devices").json.at("devices");
    EXPECT_EQ(devices[0].at("name"), "fake");
    EXPECT_EQ(devices[0].at("parameters"), 20);
    net.asked("PUT", "/devices/0xDC/parameters/PAR_0", R"({"value": 1})");
    EXPECT_EQ(net.ask("GET", "/devices").json.at("devices")[0].at("job"), 2);
}

TEST_F(Jobs, devices_whose_frames_passed_are_listed_but_not_hosts) {
    net.ask("GET", "/devices");
    net.passes(frame(0x30, 0xFF, 0x01, Bytes(13)));
    net.passes(frame(0xFE, 0xFF, 0xE0, {0, 0, 0}));
    json devices = net.ask("GET", "/devices").json.at("devices");
    ASSERT_EQ(devices.size(), 2u);
    EXPECT_EQ(devices[1], json::parse(R"({"address": "0x30", "link": "fc", "age": 0.0})"));
    for (int i = 0; i < 500; ++i) {
        net.pass(10ms);
        net.passes(frame(0x30, 0xFF, 0x01, Bytes(13)));
    }
    devices = net.ask("GET", "/devices").json.at("devices");
    EXPECT_NEAR(devices[1].at("rate").get<double>(), 100, 5);
    net.pass(1min);
    EXPECT_EQ(net.ask("GET", "/devices").json.at("devices").size(), 1u);
}

TEST_F(Jobs, a_device_cannot_claim_the_address_of_another_by_its_name) {
    net.add(0x30).name = "0xDC";
    net.ask("POST", "/devices/scan");
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/commands").json.at("device").at("address"), "0xDC");
}

TEST_F(Jobs, that_read_a_constantly_changing_device_end) {
    std::uint16_t count = 3;
    fake.instead = [&](ano::FrameView f) -> std::optional<std::vector<Bytes>> {
        if (f.id() == 0xE0 && f.data()[0] == 1) fake.reported_count = count++ % 15;
        return std::nullopt;
    };
    EXPECT_EQ(net.ask("GET", "/devices/0xDC/parameters").status, 502u);
}

// Two devices whose own addresses are port ids send equal answers: only their source distinguishes them.
TEST(DevicesAtPortIds, read_at_the_same_time_are_not_confused) {
    SimulatedNet net;
    for (const std::uint8_t address : {std::uint8_t{10}, std::uint8_t{20}}) {
        FakeDevice& fake = net.add(address);
        fake.name = "device " + std::to_string(address);
        fake.parameters.push_back({2, "ADDRESS", "its own", Bytes{address, 0}});
    }
    const auto ten = net.asked("GET", "/devices/10/parameters");
    const auto twenty = net.asked("GET", "/devices/20/parameters");
    ASSERT_TRUE(net.until([&] { return ten->has_value() && twenty->has_value(); }));
    for (const auto& [answer, address] : {std::pair{ten, 10}, std::pair{twenty, 20}}) {
        ASSERT_EQ((*answer)->status, 200u) << (*answer)->json;
        EXPECT_EQ((*answer)->json.at("device").at("name"), "device " + std::to_string(address));
        EXPECT_EQ((*answer)->json.at("parameters")[0].at("value"), address);
    }
}

struct BehindAPort : testing::Test {
    SimulatedNet net;
    FakeDevice& fake = net.add();

    // Every question to port 3 is answered by 0xDC.
    BehindAPort() {
        fake.make_parameters(20);
        net.where[3] = {.is_known = true};
        fake.port = 3;
    }
};

TEST_F(BehindAPort, a_device_that_answers_with_its_address_is_accepted) {
    net.ways.emplace(3, 0xDC);
    const auto at_port = net.asked("GET", "/devices/3/parameters");
    const auto at_address = net.asked("GET", "/devices/0xDC/parameters");
    ASSERT_TRUE(net.until([&] { return at_port->has_value() && at_address->has_value(); }));
    EXPECT_EQ((*at_port)->status, 200u) << (*at_port)->json;
    EXPECT_EQ((*at_address)->status, 200u) << (*at_address)->json;
}

TEST_F(BehindAPort, a_device_that_answers_is_accepted_while_another_port_is_silent) {
    net.ways.emplace(3, 0xDC);
    net.where[2] = {.is_known = true};
    const auto silent = net.asked("GET", "/devices/2/parameters");
    EXPECT_EQ(net.ask("GET", "/devices/3/parameters").status, 200u);
    ASSERT_TRUE(net.until([&] { return silent->has_value(); }));
    EXPECT_EQ((*silent)->status, 504u);
}

TEST_F(BehindAPort, a_device_on_another_path_is_not_accepted) { EXPECT_EQ(net.ask("GET", "/devices/3/parameters").status, 504u); }

}    // namespace
}    // namespace jobs_tests
