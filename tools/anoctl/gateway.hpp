// The gateway that a subcommand asks.
#pragma once
#include "options.hpp"

#include <http/answer.hpp>

#include <string>
#include <string_view>

namespace anoctl {

/// As --control says, or where one is usually found.
struct GatewayOptions {
    std::string control;

    /// Declares --control. `options` live as long as the run.
    static void add(Options& declared, GatewayOptions& options);
    /// The path of its socket. Throws UsageError for one that names none.
    std::string socket() const;
    /// What it answers, when that is a success. Throws Failure: why there is no answer, or the words of the one that refuses.
    std::string ask(const std::string& method, const std::string& target, const std::string& accept = {}) const;
    /// What it answers, whatever that is. Throws Failure when there is none.
    anogate::http::Answer answer(const std::string& method, const std::string& target, const std::string& accept = {}) const;
};

/// A word as a part of a target.
std::string percent_encoded(std::string_view word);

/// The words of an answer that refuses: its "error", or what status it has.
std::string words_of(const anogate::http::Answer& answer);

}    // namespace anoctl
