// The response of a gateway, as the client stores it.
#pragma once
#include <http/request.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

struct Answer {
    unsigned status = 0;    // 0: no answer
    std::vector<Field> headers;
    std::string body;

    /// `name`: upper or lower case; empty: there is no such header.
    std::string_view header(std::string_view name) const noexcept { return field_value(headers, name); }
};

/// How an exchange ended.
struct Outcome {
    std::string fault;    // why the answer is incomplete, in one clause for the user; empty: it is complete
    Answer answer;
};

}    // namespace anogate::http
