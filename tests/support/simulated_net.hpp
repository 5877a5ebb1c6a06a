// The devices of a test and the host engine for them, in simulated time.
#pragma once
#include <ano/fault.hpp>
#include <devices/device_routes.hpp>
#include <devices/device_service.hpp>
#include <http/routes.hpp>
#include <support/fake_device.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <functional>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace support {

/// Frames arrive at every fake device after the delay of the line, and so do the answers at the service.
class SimulatedNet final : public anogate::DeviceNet {
public:
    SimulatedNet() { anogate::add_device_routes(routes, service); }

    std::vector<std::unique_ptr<FakeDevice>> fakes;
    LineFaults line{.delay = std::chrono::milliseconds{10}};
    TimePoint time = TimePoint{} + 1h;
    std::map<std::uint8_t, std::string> refuses;    // ids of frames that are never sent, and the reason
    std::map<std::uint8_t, ano::host::RouteInfo> where;
    std::set<std::pair<std::uint8_t, std::uint8_t>> same;    // a port, and the device at it
    std::set<std::pair<std::uint8_t, std::uint8_t>> ways;    // a port, and a device whose frames arrive on its link
    bool learns = false;                                     // the source of each received frame becomes known
    bool listens = false;
    bool stood_still = false;
    bool is_down = false;        // the link to all devices
    TimePoint queued_until{};    // frames queued before this time are sent at this time
    std::string stopped;         // the reason why nothing is sent
    std::vector<Bytes> flushed_before;
    std::map<std::string, std::string> kept, cache_folder;
    anogate::UnitPlace unit{"/run/test.sock", "fc", "serial:/dev/fake"};
    std::vector<std::string> reports;
    std::vector<Bytes> sent;
    std::optional<std::string> keep_fault;
    bool is_disk_slow = false;                                        // keep() never reports its result
    anogate::http::Access access = anogate::http::Access::control;    // the access of requests
    std::string peer;                                                 // the address from which requests are sent
    bool is_foreign = false;                                          // requests are of a page of another site
    anogate::DeviceLimits link_limits;

    FakeDevice& add(std::uint8_t address = 0xDC) {
        fakes.push_back(std::make_unique<FakeDevice>());
        fakes.back()->address = address;
        where[address] = {.is_known = true};
        return *fakes.back();
    }

    std::optional<Duration> flush_takes;    // zero bytes are sent, at most once a second
    std::optional<TimePoint> flushed_at;
    TimePoint now() override { return time; }
    anogate::Unsent send(ano::FrameView frame) override {
        if (const auto why = refuses.find(frame.id()); why != refuses.end()) return {{"other", why->second}};
        if (is_down) return {{"link_down", ano::Fault{"link_named", "fc"}}, true};
        sent.emplace_back(frame.bytes().begin(), frame.bytes().end());
        put(true, sent.back());
        return {};
    }
    ano::Flush flush_parser(ano::FrameView next) override {
        flushed_before.emplace_back(next.bytes().begin(), next.bytes().end());
        if (!flush_takes) return {};
        const Duration later = flushed_at ? *flushed_at + 1s - time : Duration::zero();
        if (later > Duration::zero()) return {.later = later};
        flushed_at = time;
        return {.sent = true, .busy = *flush_takes};
    }
    bool is_waiting(std::uint8_t) override { return time < queued_until; }
    ano::Fault accepts_nothing(std::uint8_t) override { return stopped.empty() ? ano::Fault{} : ano::Fault{"other", stopped}; }
    void listen(bool wants) override { listens = wants; }
    void wake(TimePoint at) override { wake_ = std::min(wake_.value_or(at), at); }
    std::vector<anogate::HeardAddress> heard(TimePoint) override {
        std::vector<anogate::HeardAddress> all;
        for (const auto& fake : fakes) all.push_back({fake->address, "fc", "/dev/fake", time - 200ms});
        return all;
    }
    ano::host::RouteInfo route_info(std::uint8_t address, TimePoint) override { return where[address]; }
    std::vector<std::string> links_in_conflict(std::uint8_t, TimePoint) override { return {"fc", "radio"}; }
    bool is_same_device(std::uint8_t one, std::uint8_t other) override {
        return same.contains({one, other}) || same.contains({other, one});
    }
    bool may_answer_for(std::uint8_t source, std::uint8_t port) override { return ways.contains({port, source}); }
    anogate::DeviceLimits device_limits(std::uint8_t) override { return link_limits; }
    anogate::UnitPlace unit_place(std::uint8_t, TimePoint) override { return unit; }
    std::string cached(const std::string& name) override { return cache_folder[name]; }
    void cache(const std::string& name, const std::string& text) override { cache_folder[name] = text; }
    std::string date_text() override { return "2026-11-26 12:00:00 UTC"; }
    void report(const std::string& text, bool) override { reports.push_back(text); }
    bool may_have_waited(TimePoint) override { return stood_still; }
    void keep(std::string name, std::string text, std::function<void(std::string)> done) override {
        if (text.empty()) kept.erase(name);
        else kept[name] = std::move(text);
        if (!is_disk_slow) done(keep_fault.value_or(""));
    }

    /// Simulates that any frame passes the gateway.
    void passes(const Bytes& bytes) {
        if (listens) service.receive(ano::FrameView{bytes}, time);
    }

    /// Runs until `holds` returns true; false: no event is left within `limit`.
    bool until(const std::function<bool()>& holds, Duration limit = 1h) {
        const TimePoint end = time + limit;
        while (!holds()) {
            const TimePoint next = std::min(wake_.value_or(TimePoint::max()),
                                            events_.empty() ? TimePoint::max() : events_.begin()->first);
            if (next > end) return false;
            time = std::max(time, next);
            deliver();
            if (wake_ && *wake_ <= time) {
                wake_.reset();
                service.run(time);
            }
        }
        return true;
    }
    void pass(Duration duration) {
        const TimePoint end = time + duration;
        until([&] { return false; }, duration);
        time = end;
    }

    struct Answer {
        unsigned status = 0;
        nlohmann::ordered_json json;
    };
    /// The response, which may be sent now or later.
    /// Every error has an id of the table and all its arguments, and so has every clause in it.
    static void expect_ids_in(const nlohmann::ordered_json& json) {
        if (json.is_structured())
            for (const auto& one : json) expect_ids_in(one);
        if (!json.is_object() || (!json.contains("error") && !json.contains("error_id"))) return;
        const auto row = std::find_if(std::begin(ano::fault_rows), std::end(ano::fault_rows),
                                      [id = json.value("error_id", "")](const ano::FaultRow& one) { return one.id == id; });
        ASSERT_NE(row, std::end(ano::fault_rows)) << json;
        for (const std::string_view name : ano::arguments_of(row->english))
            EXPECT_TRUE(json.at("error_args").contains(std::string{name})) << json;
    }

    Answer ask(const std::string& method, const std::string& target, const std::string& body = {}) {
        auto answer = asked(method, target, body);
        EXPECT_TRUE(until([&] { return answer->has_value(); })) << method << ' ' << target << " is never answered";
        return answer->value_or(Answer{});
    }
    std::shared_ptr<std::optional<Answer>> asked(const std::string& method, const std::string& target,
                                                 const std::string& body = {}) {
        auto answer = std::make_shared<std::optional<Answer>>();
        const auto told = [this, answer](anogate::http::Response response) {
            needed_.erase(answer.get());
            *answer = Answer{response.status, nlohmann::ordered_json::parse(response.pop_text(), nullptr, false)};
            expect_ids_in((*answer)->json);
        };
        anogate::http::Response response = routes.answer(own_request(method, target, body));
        if (!response.later) told(std::move(response));
        else response.later(told);
        if (!answer->has_value()) needed_[answer.get()] = std::move(response.needed);
        return answer;
    }
    /// The stream of lines for a request.
    std::unique_ptr<anogate::http::Producer> lines(const std::string& method, const std::string& target,
                                                   const std::string& body = {}) {
        auto asks = own_request(method, target, body);
        asks.headers.push_back({"Accept", "application/x-ndjson"});
        return std::move(routes.answer(asks).producer);
    }
    /// All waiting clients disconnect.
    void leave() { needed_.clear(); }

    static anogate::http::Request request(const std::string& method, const std::string& target, const std::string& body = {}) {
        anogate::http::Request request;
        request.method = method;
        request.target = target;
        request.body = body;
        request.headers.push_back({"User-Agent", "test"});
        if (target.find("/firmware") != std::string::npos)
            request.headers.push_back({"Content-Type", "application/octet-stream"});
        return request;
    }

    anogate::http::Request own_request(const std::string& method, const std::string& target, const std::string& body) const {
        anogate::http::Request asks = request(method, target, body);
        asks.access = access;
        asks.connection_info.is_network = true;
        asks.connection_info.peer = peer;
        asks.is_foreign = is_foreign;
        return asks;
    }

    anogate::DeviceService service{*this};
    anogate::http::Routes routes;

private:
    struct Event {
        bool to_device;
        Bytes frame;
    };

    void put(bool to_device, const Bytes& frame) {
        if (line.loss > 0 && static_cast<double>(random_.below(1'000'000u)) < line.loss * 1e6) return;
        events_.emplace((to_device ? std::max(time, queued_until) : time) + line.delay, Event{to_device, frame});
    }
    void deliver() {
        while (!events_.empty() && events_.begin()->first <= time) {
            const Event event = std::move(events_.begin()->second);
            events_.erase(events_.begin());
            if (!event.to_device) {
                if (learns) where[ano::FrameView{event.frame}.source()].is_known = true;
                passes(event.frame);
                continue;
            }
            for (const auto& fake : fakes)
                for (const Bytes& answer : fake->take(ano::FrameView{event.frame})) put(false, answer);
        }
    }

    Random random_{7};
    std::optional<TimePoint> wake_;
    std::multimap<TimePoint, Event> events_;
    std::map<const void*, std::shared_ptr<void>> needed_;    // by the awaited response
};

}    // namespace support
