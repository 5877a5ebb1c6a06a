// The table of what the server answers.
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

/// 401 or 403 for a client who may `given` where `needed` is asked.
Response not_permitted(Access given, Access needed);

/// Rows of method, pattern and function, and what there is to say of them. A pattern is a path such as /links/{name}, where {name}
/// stands for any one segment that is not empty. Where several patterns fit, the one that was added first counts. Who answers GET
/// answers HEAD as well.
class Routes {
public:
    using Function = std::function<Response(const Request& request)>;
    struct Row {
        std::string method, pattern;
        Access access = Access::control;    // what a client must be allowed
        std::string answers;                // with what, in a clause for people
        Function function;
        std::uint64_t body = 0;    // bytes that the body of a request may have; 0: as usual
    };

    void add(Row row) { rows_.push_back(std::move(row)); }
    /// One that nothing is told of, for those who may do everything.
    void add(std::string method, std::string pattern, Function function) {
        rows_.push_back({std::move(method), std::move(pattern), Access::control, {}, std::move(function), 0});
    }
    const std::vector<Row>& rows() const noexcept { return rows_; }

    /// What the function of the row that fits says, or, in words: 400 for a path or query with a bad encoding, 404 with the nearest
    /// pattern, 405 with what the path does answer, 401 or 403 for a client who may not ask this.
    Response answer(Request& request) const;
    Response answer(Request&& request) const { return answer(request); }
    /// The one that answers it; nullptr: none does.
    const Row* row_for(const Request& request) const;

private:
    Response not_found(std::string_view path) const;

    std::vector<Row> rows_;
};

}    // namespace anogate::http
