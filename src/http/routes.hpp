// The table of paths of the server.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate::http {

/// 401 or 403 for a client with the access `given` where `needed` is required.
Response not_permitted(Access given, Access needed);

/// True if the body is empty or an empty JSON object.
bool has_empty_body(const Request& request);

/// Rows of method, pattern and function, with their documentation. A pattern is a path such as /links/{name}, where {name} stands for
/// any non-empty segment. If several patterns fit, the one added first counts. A row for GET answers HEAD as well.
class Routes {
public:
    using Function = std::function<Response(const Request& request)>;
    struct Row {
        std::string method, pattern;
        Access access = Access::control;    // the access that a client needs
        std::string answers;                // the content of its response, in a clause for the documentation
        Function function;
        std::uint64_t body = 0;      // maximum bytes of a request's body; 0: the default
        bool starts_job = false;     // a GET that sends frames, or may send some: not for pages of other sites
        bool accepts_body = true;    // false: a body is refused unless has_empty_body(), since it would have no effect
    };

    void add(Row row) { rows_.push_back(std::move(row)); }
    /// A row that takes no body.
    void add_without_body(Row row) {
        row.accepts_body = false;
        add(std::move(row));
    }
    /// A row without documentation, for clients that may do everything.
    void add(std::string method, std::string pattern, Function function) {
        rows_.push_back({std::move(method), std::move(pattern), Access::control, {}, std::move(function), 0, false, true});
    }
    const std::vector<Row>& rows() const noexcept { return rows_; }

    /// The response of the matching row's function, or an error: 400 for a bad encoding in path or query, 404 with the nearest
    /// pattern, 405 with the methods of the path, 401 or 403 for a client without the needed access, 403 for a page of another
    /// site that starts or changes something. The function may move from `request`.
    Response answer(Request& request) const;
    Response answer(Request&& request) const { return answer(request); }
    /// The row that matches the request; nullptr: there is none.
    const Row* row_for(const Request& request) const;

private:
    Response not_found(std::string_view path) const;
    Response options() const;

    std::vector<Row> rows_;
};

}    // namespace anogate::http
