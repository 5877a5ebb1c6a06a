// What a gateway answers, as its client has it.
#pragma once
#include <http/request.hpp>

#include <string>
#include <string_view>
#include <vector>

namespace anogate::http {

struct Answer {
    unsigned status = 0;    // 0: there is none
    std::vector<Field> headers;
    std::string body;

    /// Whatever the case of its name; empty: it is not there.
    std::string_view header(std::string_view name) const noexcept { return field_value(headers, name); }
};

/// How an exchange ended.
struct Outcome {
    std::string fault;    // why nothing more comes, in one clause for the user; empty: all came
    Answer answer;
};

}    // namespace anogate::http
