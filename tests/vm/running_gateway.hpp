// The gateway in the test's own process, made from LINK texts as a user writes them; its loop runs while the test waits.
#pragma once
#include <daemon/command_line.hpp>
#include <daemon/gateway.hpp>
#include <daemon/status.hpp>
#include <link/asio.hpp>

#include <nlohmann/json.hpp>

#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

namespace support {

class Loop {
public:
    /// Runs until `done` or `patience` is over; says whether it is done.
    bool until(const std::function<bool()>& done, std::chrono::seconds patience = std::chrono::seconds{30}) {
        const auto end = std::chrono::steady_clock::now() + patience;
        while (!done()) {
            if (std::chrono::steady_clock::now() > end) return false;
            io.restart();
            io.run_for(std::chrono::milliseconds{2});
        }
        return true;
    }
    /// Handles what is there now.
    void turn() {
        io.restart();
        io.poll();
    }
    boost::asio::io_context io{1};
};

class RunningGateway {
public:
    RunningGateway(Loop& loop, std::vector<std::string> links) : loop_{loop}, gateway_{loop.io, settings(std::move(links))} {
        gateway_.start([](const std::string&) {});
    }
    ~RunningGateway() {
        bool stopped = false;
        gateway_.stop(std::chrono::milliseconds{500}, [&] { stopped = true; });
        loop_.until([&] { return stopped; });
    }

    nlohmann::json status() { return nlohmann::json::parse(anogate::status_json(gateway_)); }
    nlohmann::json link(const std::string& name) {
        const auto now = status();
        for (const auto& link : now.at("links"))
            if (link["name"] == name) return link;
        throw std::runtime_error("no link " + name);
    }
    bool up(const std::string& name) { return link(name)["state"] == "up"; }
    std::uint16_t port(const std::string& name) { return link(name)["port"]; }
    std::uint64_t count(const std::string& name, const std::string& counter) { return link(name)[counter]; }

private:
    static anogate::Settings settings(std::vector<std::string> links) {
        links.insert(links.begin(), {"anogated", "--control", "none"});
        std::vector<const char*> words;
        for (const std::string& link : links) words.push_back(link.c_str());
        auto line = anogate::parse_command_line(static_cast<int>(words.size()), words.data());
        if (const auto* exit = std::get_if<anogate::Exit>(&line)) throw std::runtime_error(exit->text);
        return std::get<anogate::CommandLine>(line).settings;
    }

    Loop& loop_;
    anogate::Gateway gateway_;
};

}    // namespace support
