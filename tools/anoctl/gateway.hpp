// The gateway that a subcommand sends its requests to.
#pragma once
#include "options.hpp"

#include <http/answer.hpp>

#include <string>
#include <string_view>

namespace anoctl {

/// The gateway given by --control, or the one at a usual place.
struct GatewayOptions {
    std::string control;

    /// Declares --control. `options` live as long as the run.
    static void add(Options& declared, GatewayOptions& options);
    /// The path of its socket. Throws UsageError when --control is not a valid path.
    std::string socket() const;
    /// The body of its response when it is a success. Throws Failure with the reason: there is no response, or the text of its refusal.
    std::string ask(const std::string& method, const std::string& target, const std::string& accept = {}) const;
    /// The same for a POST with a body of JSON.
    std::string post(const std::string& target, const std::string& body) const;
    /// Its response, of any status. Throws Failure when there is none.
    anogate::http::Answer answer(const std::string& method, const std::string& target, const std::string& accept = {}) const;
};

/// A word as part of a request target.
std::string percent_encoded(std::string_view word);

/// The text of a refusal: its "error", or its status.
std::string words_of(const anogate::http::Answer& answer);

}    // namespace anoctl
