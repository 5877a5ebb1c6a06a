// A whole gateway in the thread of the test, run until a condition holds.
#pragma once
#include "bytes.hpp"
#include "loop.hpp"
#include "settings.hpp"
#include "wait.hpp"

#include <runtime/gateway.hpp>
#include <sys/asio.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <initializer_list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace support {

anogate::Settings settings_of(std::vector<anogate::LinkSettings> links, anogate::GatewaySettings gateway = {},
                              std::vector<anogate::RouteSettings> routes = {});
/// The settings for LINK texts as a user writes them.
anogate::Settings settings_of_texts(std::vector<std::string> links);

class RunningGateway : private anogate::GatewayEvents {
public:
    explicit RunningGateway(anogate::Settings settings);
    RunningGateway(std::initializer_list<anogate::LinkSettings> links);
    /// In a shared loop, which must outlive it.
    RunningGateway(Loop& loop, anogate::Settings settings);
    RunningGateway(Loop& loop, std::vector<std::string> links);
    virtual ~RunningGateway();

    anogate::asio::io_context& io() { return loop_.io; }
    anogate::Gateway& gateway() { return gateway_; }
    const std::string& missing() const { return missing_; }

    /// Runs the loop until `holds` returns true; false: it did not within `limit`. It is called after each event.
    bool until(const std::function<bool()>& holds, anogate::Duration limit = patience);
    /// Runs the loop for a time. Use it only to show that something does not happen meanwhile.
    void run_for(anogate::Duration time);
    bool up(const std::string& name) { return link(name).at("state") == "up"; }
    bool until_up(const std::string& name);
    bool until_waiting(const std::string& name);
    /// Stops like SIGTERM. Returns the duration, up to the end of the loop if it is its own.
    anogate::Duration stop(
        anogate::Duration flush_for = std::chrono::milliseconds{500}, const std::function<void()>& meanwhile = [] {});

    nlohmann::json status();
    nlohmann::json link(const std::string& name);
    /// A counter of a link, read directly: the status as JSON is too slow for tests that read it after every frame.
    std::uint64_t count(const std::string& name, const std::string& counter);
    std::uint16_t port(const std::string& name);
    /// The entry of an address in the status; null: there is none.
    nlohmann::json route(const std::string& address);

    /// The invariant of the counters: frames that were offered to a channel and are in no other counter are `waiting`.
    bool counters_add_up();

private:
    void required_missing(const std::string& link) override { missing_ = link; }
    RunningGateway(std::unique_ptr<Loop> own, anogate::Settings settings);
    std::optional<std::uint64_t> figure(const anogate::LinkState& state, const std::string& counter);

    std::unique_ptr<Loop> own_loop_;    // null: it uses a shared one
    Loop& loop_;
    anogate::Gateway gateway_;
    std::string missing_;
    bool stopped_ = false;
};

}    // namespace support
