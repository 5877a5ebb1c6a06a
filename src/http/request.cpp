#include <http/request.hpp>

#include <algorithm>

namespace anogate::http {
namespace {

char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool is_same(std::string_view one, std::string_view other) {
    return std::equal(one.begin(), one.end(), other.begin(), other.end(), [](char a, char b) { return lower(a) == lower(b); });
}

const Field* find(const std::vector<Field>& fields, std::string_view name) {
    const auto found = std::find_if(fields.begin(), fields.end(), [name](const Field& field) { return field.name == name; });
    return found == fields.end() ? nullptr : &*found;
}

std::string_view trimmed(std::string_view word) {
    const auto begin = word.find_first_not_of(" \t");
    if (begin == std::string_view::npos) return {};
    return word.substr(begin, word.find_last_not_of(" \t") - begin + 1);
}

/// Calls `visit` with each word of the headers `name`, which are lists of words, until it returns true.
template <class Visit>
bool any_word(const std::vector<Field>& headers, std::string_view name, Visit visit) {
    for (const Field& field : headers) {
        if (!is_same(field.name, name)) continue;
        for (std::string_view rest = field.value; !rest.empty();) {
            const auto comma = std::min(rest.find(','), rest.size());
            if (visit(trimmed(rest.substr(0, comma)))) return true;
            rest.remove_prefix(std::min(comma + 1, rest.size()));
        }
    }
    return false;
}

}    // namespace

std::string_view field_value(const std::vector<Field>& fields, std::string_view name) noexcept {
    for (const Field& field : fields)
        if (is_same(field.name, name)) return field.value;
    return {};
}

std::string_view Request::parameter(std::string_view name) const noexcept {
    const Field* field = find(parameters, name);
    return field ? std::string_view{field->value} : std::string_view{};
}

std::optional<std::string_view> Request::query_value(std::string_view name) const noexcept {
    const Field* field = find(query, name);
    return field ? std::optional<std::string_view>{field->value} : std::nullopt;
}

std::string_view Request::header(std::string_view name) const noexcept { return field_value(headers, name); }

bool Request::header_has(std::string_view name, std::string_view word) const noexcept {
    return any_word(headers, name, [word](std::string_view one) { return is_same(one, word); });
}

bool is_web_socket(const Request& request) noexcept {
    return request.method == "GET" && request.version == 11 && request.header_has("Connection", "upgrade") &&
           request.header_has("Upgrade", "websocket");
}

std::string_view offered_subprotocol(const Request& request, std::span<const std::string_view> known) noexcept {
    std::string_view chosen;
    any_word(request.headers, "Sec-WebSocket-Protocol", [&](std::string_view one) {
        const auto same = std::find(known.begin(), known.end(), one);    // case-sensitive
        if (same != known.end()) chosen = *same;
        return !chosen.empty();
    });
    return chosen;
}

}    // namespace anogate::http
