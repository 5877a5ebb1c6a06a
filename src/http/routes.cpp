#include <ano_json/nearest.hpp>
#include <http/routes.hpp>
#include <http/target.hpp>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate::http {
namespace {

/// Removes the first segment with its '/' from `path` and returns it without the '/'.
std::string_view next_segment(std::string_view& path) {
    path.remove_prefix(1);
    const std::string_view segment = path.substr(0, path.find('/'));
    path.remove_prefix(segment.size());
    return segment;
}

bool is_parameter(std::string_view segment) { return segment.starts_with('{') && segment.ends_with('}'); }

/// Calls `visit` with each pair of segments while it returns true. Returns false if it did not, or if the number of segments
/// differs.
template <class Visit>
bool side_by_side(std::string_view pattern, std::string_view path, Visit visit) {
    while (pattern.starts_with('/') && path.starts_with('/')) {
        const std::string_view wanted = next_segment(pattern);
        if (!visit(wanted, next_segment(path))) return false;
    }
    return pattern.empty() && path.empty();
}

bool fits(std::string_view pattern, std::string_view path) {
    return side_by_side(pattern, path, [](std::string_view wanted, std::string_view given) {
        return is_parameter(wanted) ? !given.empty() : wanted == given;
    });
}

/// False: a parameter has a bad encoding.
bool read_parameters(std::string_view pattern, std::string_view path, std::vector<Field>& parameters) {
    return side_by_side(pattern, path, [&](std::string_view wanted, std::string_view given) {
        if (!is_parameter(wanted)) return true;
        auto value = percent_decoded(given);
        if (!value) return false;
        parameters.push_back({std::string{wanted.substr(1, wanted.size() - 2)}, std::move(*value)});
        return true;
    });
}

/// The pattern with its parameters replaced by the segments of `path`, so that these count as equal in a comparison.
std::string filled(std::string_view pattern, std::string_view path) {
    std::string all;
    const std::string_view whole = pattern;
    const bool same_length = side_by_side(pattern, path, [&](std::string_view wanted, std::string_view given) {
        all.append("/").append(is_parameter(wanted) ? given : wanted);
        return true;
    });
    return same_length ? all : std::string{whole};
}

std::string bad_encoding(std::string_view what, std::string_view text) {
    const std::string_view why = text.find("%00") != text.npos ? "%00, which is not allowed in names"
                                                               : "a % that is not followed by two hex digits of a byte";
    return "the " + std::string{what} + " has " + std::string{why};
}

bool answers(const Routes::Row& row, std::string_view method) {
    return row.method == method || (method == "HEAD" && row.method == "GET");
}

void allow(std::vector<std::string_view>& allowed, std::string_view method) {
    if (std::find(allowed.begin(), allowed.end(), method) != allowed.end()) return;
    allowed.push_back(method);
    if (method == "GET") allowed.emplace_back("HEAD");
}

std::string list_of(const std::vector<std::string_view>& methods) {
    std::string list;
    for (const std::string_view method : methods) list.append(list.empty() ? "" : ", ").append(method);
    return list;
}

Response not_allowed(const std::vector<std::string_view>& allowed) {
    const std::string list = list_of(allowed);
    Response response = error(405, "this path supports only " + list);
    response.headers.push_back({"Allow", list});
    return response;
}

}    // namespace

Response not_permitted(Access given, Access needed) {
    if (given == Access::open) return needs_token("this path needs a token");
    return error(403, "this token does not allow this; a token is needed for '" + std::string{text(needed)} + "'");
}

std::string_view text(Access access) noexcept {
    constexpr std::string_view names[] = {"open", "view", "control"};
    return names[static_cast<std::size_t>(access)];
}

bool has_empty_body(const Request& request) {
    std::string body = request.body;
    std::erase_if(body, [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; });
    return !request.stored && (body.empty() || body == "{}");
}

// The methods of the whole server, for `OPTIONS *` (RFC 9110, 9.3.7).
Response Routes::options() const {
    std::vector<std::string_view> allowed;
    for (const Row& row : rows_) allow(allowed, row.method);
    Response response;
    response.headers.push_back({"Allow", list_of(allowed) + ", OPTIONS"});
    return response;
}

Response Routes::answer(Request& request) const {
    if (request.method == "OPTIONS" && request.target == "*") return options();
    const Target target = split(request.target);
    std::vector<std::string_view> allowed;
    for (const Row& row : rows_) {
        if (!fits(row.pattern, target.path)) continue;
        if (!answers(row, request.method)) {
            allow(allowed, row.method);
            continue;
        }
        if (request.is_foreign && (row.starts_job || row.method != "GET"))
            return error(403, "pages of another site may not start or change anything here; add them to control.origins");
        if (request.access < row.access) return not_permitted(request.access, row.access);
        if (!read_parameters(row.pattern, target.path, request.parameters)) return error(400, bad_encoding("path", target.path));
        auto query = parse_query(target.query);
        if (!query) return error(400, bad_encoding("query", target.query));
        request.query = std::move(*query);
        if (!row.accepts_body && !has_empty_body(request))
            return error(400, "this path accepts no body except an empty object: nothing was done");
        return row.function(request);
    }
    return allowed.empty() ? not_found(target.path) : not_allowed(allowed);
}

const Routes::Row* Routes::row_for(const Request& request) const {
    const std::string_view path = split(request.target).path;
    const auto row = std::find_if(rows_.begin(), rows_.end(),
                                  [&](const Row& one) { return fits(one.pattern, path) && answers(one, request.method); });
    return row != rows_.end() ? &*row : nullptr;
}

Response Routes::not_found(std::string_view path) const {
    const std::string nothing = "this path does not exist";
    if (rows_.empty()) return error(404, nothing);
    std::vector<std::string> paths;
    for (const Row& row : rows_) paths.push_back(filled(row.pattern, path));
    const std::vector<std::string_view> candidates{paths.begin(), paths.end()};
    const std::string_view near = ano::nearest(path, candidates);
    if (near.empty()) return error(404, nothing + "; try " + rows_.front().pattern);
    const auto row = static_cast<std::size_t>(std::find(candidates.begin(), candidates.end(), near) - candidates.begin());
    return error(404, nothing + " (did you mean '" + rows_[row].pattern + "'?)");
}

}    // namespace anogate::http
