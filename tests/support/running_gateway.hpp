// A whole gateway in the test's own thread, driven until something holds.
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
/// Of LINK texts, as a user writes them.
anogate::Settings settings_of_texts(std::vector<std::string> links);

class RunningGateway {
public:
    explicit RunningGateway(anogate::Settings settings);
    RunningGateway(std::initializer_list<anogate::LinkSettings> links);
    /// In a loop that it shares with others, which outlives it.
    RunningGateway(Loop& loop, anogate::Settings settings);
    RunningGateway(Loop& loop, std::vector<std::string> links);
    ~RunningGateway();

    anogate::asio::io_context& io() { return loop_.io; }
    anogate::Gateway& gateway() { return gateway_; }
    const std::string& missing() const { return missing_; }

    /// Runs the loop until `holds` does; false when it does not within `limit`. It is asked after each thing that happens.
    bool until(const std::function<bool()>& holds, anogate::Duration limit = patience);
    /// Runs the loop for a time: only to show that something does not happen meanwhile.
    void run_for(anogate::Duration time);
    bool up(const std::string& name) { return link(name).at("state") == "up"; }
    bool until_up(const std::string& name);
    bool until_waiting(const std::string& name);
    /// As SIGTERM does. Returns how long it took, up to the end of a loop of its own.
    anogate::Duration stop(
        anogate::Duration flush_for = std::chrono::milliseconds{500}, const std::function<void()>& meanwhile = [] {});

    nlohmann::json status();
    nlohmann::json link(const std::string& name);
    /// A counter of a link, read directly: the status as JSON would be too slow for tests that ask after every frame.
    std::uint64_t count(const std::string& name, const std::string& counter);
    std::uint16_t port(const std::string& name);
    /// The entry of an address in the status; null when there is none.
    nlohmann::json route(const std::string& address);

    /// The invariant of the counters: what was offered to a channel and is in no other counter is `waiting`.
    bool counters_add_up();

private:
    RunningGateway(std::unique_ptr<Loop> own, anogate::Settings settings);
    std::optional<std::uint64_t> figure(const anogate::LinkState& state, const std::string& counter);

    std::unique_ptr<Loop> own_loop_;    // null: it shares one
    Loop& loop_;
    anogate::Gateway gateway_;
    std::string missing_;
    bool stopped_ = false;
};

}    // namespace support
