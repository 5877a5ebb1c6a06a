// A measured anogated, queried over its control socket.
#pragma once
#include <support/process.hpp>
#include <support/temp_dir.hpp>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace bench {

class GatewayProcess {
public:
    /// Runs `program LINK...`, under `tracer` if given; returns when it answers a status request.
    GatewayProcess(const std::string& program, const std::vector<std::string>& arguments,
                   const std::vector<std::string>& tracer = {});
    ~GatewayProcess();

    nlohmann::json link(const std::string& name) const;
    std::uint16_t port(const std::string& link_name) const { return link(link_name).at("port").get<std::uint16_t>(); }
    /// The HTTP port on 127.0.0.1 and its token; empty: none is needed.
    struct HttpAddress {
        std::uint16_t port;
        std::string token;
    };
    HttpAddress http_address() const;
    /// The path of its control socket.
    std::string control() const { return folder_ / "control"; }
    pid_t pid() const noexcept { return process_.pid(); }

private:
    nlohmann::json status() const;    // discarded while there is no answer

    support::TempDir folder_;    // must be destroyed after the programs that use it
    support::Process process_;
};

}    // namespace bench
