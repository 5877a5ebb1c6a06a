#include "running_gateway.hpp"

#include <daemon/command_line.hpp>
#include <status/status.hpp>

#include <csignal>
#include <stdexcept>
#include <utility>

namespace support {

anogate::Settings settings_of(std::vector<anogate::LinkSettings> links, anogate::GatewaySettings gateway,
                              std::vector<anogate::RouteSettings> routes) {
    anogate::Settings s;
    s.gateway = std::move(gateway);
    s.links = std::move(links);
    s.routes = std::move(routes);
    return s;
}

anogate::Settings settings_of_texts(std::vector<std::string> links) {
    links.insert(links.begin(), {"anogated", "--control", "none"});
    std::vector<const char*> words;
    for (const std::string& link : links) words.push_back(link.c_str());
    auto line = anogate::parse_command_line(static_cast<int>(words.size()), words.data());
    if (const auto* exit = std::get_if<anogate::Exit>(&line)) throw std::runtime_error{exit->text};
    return std::get<anogate::CommandLine>(std::move(line)).settings;
}

RunningGateway::RunningGateway(anogate::Settings settings) : RunningGateway{std::make_unique<Loop>(), std::move(settings)} {}
RunningGateway::RunningGateway(std::initializer_list<anogate::LinkSettings> links) : RunningGateway{settings_of(links)} {}
RunningGateway::RunningGateway(std::unique_ptr<Loop> own, anogate::Settings settings)
    : RunningGateway{*own, std::move(settings)} {
    own_loop_ = std::move(own);
}
RunningGateway::RunningGateway(Loop& loop, anogate::Settings settings) : loop_{loop}, gateway_{loop.io, std::move(settings)} {
    std::signal(SIGPIPE, SIG_IGN);    // as anogated does
    gateway_.parts().enter(*this);
    gateway_.start();
}
RunningGateway::RunningGateway(Loop& loop, std::vector<std::string> links)
    : RunningGateway{loop, settings_of_texts(std::move(links))} {}
RunningGateway::~RunningGateway() {
    if (!stopped_) stop(std::chrono::milliseconds{own_loop_ ? 0 : 500});
}

bool RunningGateway::until(const std::function<bool()>& holds, anogate::Duration limit) {
    return wait_until(holds, limit, [this] {
        io().restart();
        io().run_one_for(std::chrono::milliseconds{2});
    });
}
void RunningGateway::run_for(anogate::Duration time) {
    const auto end = anogate::Clock::now() + time;
    until([&] { return anogate::Clock::now() >= end; }, time);
}
bool RunningGateway::until_up(const std::string& name) {
    return until([&] { return up(name); });
}
bool RunningGateway::until_waiting(const std::string& name) {
    return until([&] { return link(name).at("state") == "waiting"; });
}
anogate::Duration RunningGateway::stop(anogate::Duration flush_for, const std::function<void()>& meanwhile) {
    const auto begin = anogate::Clock::now();
    stopped_ = true;
    bool done = false;
    gateway_.stop(flush_for, [&] { done = true; });
    io().restart();
    while (own_loop_ ? !io().stopped() : !done) {
        io().run_one_for(std::chrono::milliseconds{2});
        meanwhile();
        if (anogate::Clock::now() - begin > support::patience) {
            ADD_FAILURE() << "the loop does not end";
            break;
        }
    }
    return anogate::Clock::now() - begin;
}

nlohmann::json RunningGateway::status() { return nlohmann::json::parse(anogate::status_json(gateway_)); }
nlohmann::json RunningGateway::link(const std::string& name) {
    const auto now = status();
    for (const auto& link : now.at("links"))
        if (link.at("name") == name) return link;
    throw std::out_of_range{"no link " + name};
}
std::uint64_t RunningGateway::count(const std::string& name, const std::string& counter) {
    for (const anogate::LinkState& state : gateway_.links())
        if (state.link->name() == name)
            if (const auto counted = figure(state, counter)) return *counted;
    return link(name).at(counter);
}
std::uint16_t RunningGateway::port(const std::string& name) {
    for (const anogate::LinkState& state : gateway_.links())
        if (const auto* bound = state.link->as<anogate::LocalPort>();
            bound && state.link->name() == name && bound->local_port() != 0)
            return bound->local_port();
    return link(name).at("port");
}
nlohmann::json RunningGateway::route(const std::string& address) {
    const auto now = status();
    for (const auto& route : now.at("routes"))
        if (route.at("address") == address) return route;
    return nullptr;
}

bool RunningGateway::counters_add_up() {
    for (const anogate::LinkState& state : gateway_.links()) {
        const anogate::LinkTraffic& traffic = gateway_.forwarder().traffic(state.link->id());
        if (anogate::unaccounted(traffic.gone_sent) != 0) return false;
        for (const anogate::ChannelId id : traffic.channels) {
            const anogate::Channel& channel = gateway_.forwarder().channel(id);
            if (anogate::unaccounted(channel.sent()) != channel.waiting()) return false;
        }
    }
    return true;
}

std::optional<std::uint64_t> RunningGateway::figure(const anogate::LinkState& state, const std::string& counter) {
    const anogate::LinkTraffic& traffic = gateway_.forwarder().traffic(state.link->id());
    auto received = traffic.gone_received;
    auto sent = traffic.gone_sent;
    std::size_t waiting = 0;
    if (const auto* receiver = state.link->as<anogate::UnassignedReceiver>())
        add(received, receiver->unassigned_traffic().received);
    for (const anogate::ChannelId id : traffic.channels) {
        const anogate::Channel& channel = gateway_.forwarder().channel(id);
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

}    // namespace support
