// Requests to the HTTP server, as bytes: the result must not depend on how the bytes were split, and every response is valid.
#include <http/request_reader.hpp>
#include <http/routes.hpp>
#include <http/target.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

using namespace anogate::http;

void require(bool holds) {
    if (!holds) std::abort();
}

struct Read {
    std::size_t used = 0;
    std::string request, answer;
    unsigned status = 0;    // of an error response
    bool operator==(const Read&) const = default;
};

const Routes& routes() {
    static const Routes all = [] {
        Routes table;
        const auto say = [](const Request& request) {
            Response response;
            for (const Field& field : request.parameters) {
                require(!field.value.empty() && field.value.find('\0') == std::string::npos);
                response.body += field.value + "\n";
            }
            for (const Field& field : request.query) response.body += field.name + "=" + field.value + "\n";
            return response;
        };
        table.add("GET", "/status", say);
        table.add("GET", "/links/{name}", say);
        table.add("POST", "/devices/{device}/commands/{command}", say);
        return table;
    }();
    return all;
}

Read read(std::string_view bytes, std::size_t step) {
    RequestReader reader{{.header = 1024, .body = 256}};
    Read result;
    std::string waiting;
    while (!reader.is_done() && !reader.fault() && !bytes.empty()) {
        waiting.append(bytes.substr(0, step));
        bytes.remove_prefix(std::min(step, bytes.size()));
        const std::size_t used = reader.put(waiting);
        require(used <= waiting.size());
        waiting.erase(0, used);
        result.used += used;
    }
    if (reader.fault()) return {0, {}, reader.fault()->words, reader.fault()->status};
    if (!reader.is_done()) return {};
    Request request = reader.pop_request();
    require(request.body.size() <= 256);
    result.request = request.method + " " + request.target + "\n" + request.body;
    const Response response = routes().answer(std::move(request));
    require(response.status == 200 || response.status == 400 || response.status == 404 || response.status == 405);
    result.answer = head_of(response, {}) + response.body;
    return result;
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes{reinterpret_cast<const char*>(data), size};
    const Read whole = read(bytes, std::max<std::size_t>(size, 1));
    for (const std::size_t step : {1u, 7u}) {
        const Read cut = read(bytes, step);
        // Beast detects some errors, limits among them, depending on the size of the pieces. Requests that are accepted both ways
        // are equal.
        require(cut == whole || cut.status != 0 || whole.status != 0);
    }
    return 0;
}
