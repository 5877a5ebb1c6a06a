// An anogated under measurement, asked over its control socket.
#pragma once
#include "processes.hpp"

#include <nlohmann/json.hpp>

namespace bench {

class GatewayProcess {
public:
    /// Runs `program LINK...`, under `tracer` if given; returns when it answers for its status.
    GatewayProcess(const std::string& program, const std::vector<std::string>& arguments,
                   const std::vector<std::string>& tracer = {});

    nlohmann::json status() const;
    nlohmann::json link(const std::string& name) const;
    std::uint16_t port(const std::string& link_name) const { return link(link_name).at("port").get<std::uint16_t>(); }
    const Child& process() const noexcept { return child_; }

private:
    struct Folder {
        std::string path;
        ~Folder();
    };
    Folder folder_;    // must be destroyed after what runs in it
    Child child_;
};

}    // namespace bench
