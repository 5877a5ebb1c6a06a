// The gateway to which a subcommand sends requests.
#pragma once
#include "options.hpp"

#include <http/answer.hpp>
#include <http/client/percent_encoded.hpp>

#include <string>
#include <string_view>

namespace anoctl {

/// The gateway given by --control, or the one at a usual socket path.
struct GatewayOptions {
    std::string control;

    /// Declares --control. `options` must live as long as the run.
    static void add(Options& declared, GatewayOptions& options);
    /// The path of its socket. Throws UsageError when --control is not a valid path.
    std::string socket() const;
    /// The body of a successful response. Throws Failure with the text of the error response, or with the reason why there is no
    /// response.
    std::string ask(const std::string& method, const std::string& target, const std::string& accept = {}) const;
    /// The same for a POST with a JSON body.
    std::string post(const std::string& target, const std::string& body) const;
    /// The response, with any status. Throws Failure if there is none.
    anogate::http::Answer answer(const std::string& method, const std::string& target, const std::string& accept = {}) const;
};

using anogate::http::percent_encoded;

/// The text of an error response: its "error", or its status.
std::string format_failure(const anogate::http::Answer& answer);

}    // namespace anoctl
