#include "gateway_process.hpp"

#include "processes.hpp"

#include <csignal>
#include <fstream>
#include <stdexcept>

namespace bench {
namespace {

/// The arguments after the first word of the command line.
std::vector<std::string> arguments_of(const std::string& program, const std::string& socket,
                                      const std::vector<std::string>& arguments, std::vector<std::string> words) {
    words.push_back(program);
    words.insert(words.end(), arguments.begin(), arguments.end());
    words.insert(words.end(), {"--control", socket, "--log-level", "error"});
    words.erase(words.begin());
    return words;
}

}    // namespace

GatewayProcess::GatewayProcess(const std::string& program, const std::vector<std::string>& arguments,
                               const std::vector<std::string>& tracer)
    : process_{tracer.empty() ? program : tracer.front(),
               arguments_of(program, folder_ / "control", arguments, tracer),
               {},
               stay_on_second_processor} {
    if (!support::wait_until([this] { return status().is_object(); }))
        throw std::runtime_error(program + " does not start. " + process_.output());
}

GatewayProcess::~GatewayProcess() {
    process_.signal(SIGTERM);    // a tracer prints its report at the end
    process_.wait();
}

nlohmann::json GatewayProcess::status() const {
    return nlohmann::json::parse(support::body_of(support::http(folder_ / "control", "GET /status HTTP/1.0\r\n\r\n")), nullptr,
                                 false);
}

GatewayProcess::HttpAddress GatewayProcess::http_address() const {
    const nlohmann::json http = status().at("http");
    HttpAddress address{http.at("port"), {}};
    if (!http.at("token_needed")) return address;
    std::ifstream file{http.at("token_file").get<std::string>()};
    for (std::string access, token; file >> access >> token;)
        if (access == "control") address.token = token;
    return address;
}

nlohmann::json GatewayProcess::link(const std::string& name) const {
    const nlohmann::json now = status();
    for (const auto& link : now.at("links"))
        if (link.at("name") == name) return link;
    throw std::runtime_error("no link " + name);
}

}    // namespace bench
