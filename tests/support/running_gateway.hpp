// A whole gateway in the test's own thread, driven until something holds.
#pragma once
#include "bytes.hpp"
#include "settings.hpp"
#include "wait.hpp"

#include <daemon/gateway.hpp>
#include <daemon/status.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <initializer_list>
#include <optional>
#include <string>

namespace support {

inline anogate::Settings settings_of(std::vector<anogate::LinkSettings> links, anogate::GatewaySettings gateway = {},
                                     std::vector<anogate::RouteSettings> routes = {}) {
    anogate::Settings s;
    s.gateway = std::move(gateway);
    s.links = std::move(links);
    s.routes = std::move(routes);
    return s;
}

class RunningGateway {
public:
    explicit RunningGateway(anogate::Settings settings) : gateway_{io_, std::move(settings)} {
        spdlog::set_level(spdlog::level::off);
        gateway_.start([this](const std::string& name) { missing_ = name; });
    }
    RunningGateway(std::initializer_list<anogate::LinkSettings> links) : RunningGateway{settings_of(links)} {}
    ~RunningGateway() {
        if (!stopped_) stop(std::chrono::milliseconds{0});
    }

    anogate::asio::io_context& io() { return io_; }
    anogate::Gateway& gateway() { return gateway_; }
    const std::string& missing() const { return missing_; }

    /// Runs the loop until `holds` does; false when it does not within `limit`.
    bool until(const std::function<bool()>& holds, anogate::Duration limit = patience) {
        return wait_until(holds, limit, [this] {
            io_.restart();
            io_.run_one_for(std::chrono::milliseconds{2});
        });
    }
    /// Runs the loop for a time: only for what must not happen meanwhile.
    void run_for(anogate::Duration time) {
        const auto end = anogate::Clock::now() + time;
        until([&] { return anogate::Clock::now() >= end; }, time);
    }
    bool until_up(const std::string& name) {
        return until([&] { return link(name).at("state") == "up"; });
    }
    bool until_waiting(const std::string& name) {
        return until([&] { return link(name).at("state") == "waiting"; });
    }
    /// As SIGTERM does. Returns how long it took, up to the end of the loop.
    anogate::Duration stop(anogate::Duration flush_for = std::chrono::milliseconds{500},
                           const std::function<void()>& meanwhile = [] {}) {
        const auto begin = anogate::Clock::now();
        stopped_ = true;
        gateway_.stop(flush_for, [] {});
        io_.restart();
        while (!io_.stopped()) {
            io_.run_one_for(std::chrono::milliseconds{2});
            meanwhile();
            if (anogate::Clock::now() - begin > support::patience) {
                ADD_FAILURE() << "the loop does not end";
                break;
            }
        }
        return anogate::Clock::now() - begin;
    }

    nlohmann::json status() { return nlohmann::json::parse(anogate::status_json(gateway_)); }
    nlohmann::json link(const std::string& name) {
        const auto now = status();
        for (const auto& link : now.at("links"))
            if (link.at("name") == name) return link;
        throw std::out_of_range{"no link " + name};
    }
    /// A counter of a link. Many tests ask after every frame: no detour by the status, where what is counted is known.
    std::uint64_t count(const std::string& name, const std::string& counter) {
        for (const anogate::LinkState& state : gateway_.links())
            if (state.link->name() == name)
                if (const auto counted = figure(state, counter)) return *counted;
        return link(name).at(counter);
    }
    std::uint16_t port(const std::string& name) {
        for (const anogate::LinkState& state : gateway_.links())
            if (state.link->name() == name && state.link->local_port() != 0) return state.link->local_port();
        return link(name).at("port");
    }
    /// What the status knows of an address; null when nothing.
    nlohmann::json route(const std::string& address) {
        const auto now = status();
        for (const auto& route : now.at("routes"))
            if (route.at("address") == address) return route;
        return nullptr;
    }

    /// The law of the counters: what was offered to a channel and is not accounted for, waits.
    bool counters_add_up() {
        for (const anogate::LinkState& state : gateway_.links()) {
            if (anogate::unaccounted(state.gone_sent) != 0) return false;
            for (const anogate::ChannelId id : state.channels) {
                const anogate::Channel& channel = gateway_.channel(id);
                if (anogate::unaccounted(channel.sent()) != channel.waiting()) return false;
            }
        }
        return true;
    }

private:
    std::optional<std::uint64_t> figure(const anogate::LinkState& state, const std::string& counter) {
        auto received = state.gone_received;
        auto sent = state.gone_sent;
        std::size_t waiting = 0;
        add(received, state.link->stray().received);
        for (const anogate::ChannelId id : state.channels) {
            const anogate::Channel& channel = gateway_.channel(id);
            add(received, channel.received());
            add(sent, channel.sent());
            waiting += channel.waiting();
        }
        if (counter == "waiting") return waiting;
        for (const auto& row : anogate::receive_counters)
            if (row.name == counter) return received.*row.value;
        for (const auto& row : anogate::send_counters)
            if (row.name == counter) return sent.*row.value;
        return std::nullopt;
    }

    anogate::asio::io_context io_{1};
    anogate::Gateway gateway_;
    std::string missing_;
    bool stopped_ = false;
};

}    // namespace support
