#include "refused_lengths.hpp"

#include <anoctl/anoctl.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>

namespace anoctl {

std::vector<std::string> refused_lengths(const ano::Json& before, const ano::Json& now) {
    std::vector<std::string> sentences;
    for (const ano::Json& link : at(now, "links")) {
        const std::string name = text_at(link, "name");
        const ano::Json& others = at(before, "links");
        const auto was = std::find_if(others.begin(), others.end(),
                                      [&](const ano::Json& l) { return text_at(l, "name") == name; });
        const auto growth = [&](std::string_view counter) {
            const double then = was == others.end() ? 0 : number_at(*was, counter);
            return static_cast<std::size_t>(std::max(0.0, number_at(link, counter) - then));
        };
        const std::string quoted = ano::in_quotes(name);
        const std::string image = text_at(link, "longest_image");    // of those that were refused
        if (const std::size_t n = growth("bad_length"); n > 0)
            sentences.push_back("the link " + quoted + " refused " + plural(n, "header") +
                                " due to LEN (bad_length); if pictures are missing, set max_data" +
                                (image.empty() ? " on it to their LEN, at most 65535" : "=" + image + " on it"));
        if (const std::size_t n = growth("too_big"); n > 0)
            sentences.push_back(plural(n, "frame") + " did not fit the link " + quoted +
                                " (too_big); set max_data_out on it to their LEN, at most 65535, and queue to twice that");
    }
    return sentences;
}

std::vector<std::string> RefusedLengths::look() {
    const std::string before = std::exchange(before_, status());
    if (before.empty() || before_.empty()) return {};
    return refused_lengths(parse_answer(before), parse_answer(before_));
}

// No error if the gateway does not respond: the caller, which receives its frames, reports that.
std::string RefusedLengths::status() const {
    try {
        return gateway_.ask("GET", "/status");
    } catch (const Failure&) {
        return {};
    }
}

}    // namespace anoctl
