#include <http/routes.hpp>

#include <gtest/gtest.h>

namespace anogate::http::routes_tests {
namespace {

/// Rows whose functions return the name of the row and the parameters that they received.
class Table : public testing::Test {
protected:
    void add(const std::string& method, const std::string& pattern) {
        routes.add({method, pattern, Access::view, "what it was asked", [=](const Request& request) {
                        Response response;
                        response.body = method + " " + pattern;
                        for (const Field& field : request.parameters) response.body += " " + field.name + "=" + field.value;
                        for (const Field& field : request.query) response.body += " ?" + field.name + "=" + field.value;
                        return response;
                    }});
    }
    Response ask(const std::string& method, const std::string& target) const {
        Request request;
        request.method = method;
        request.target = target;
        return routes.answer(request);
    }
    std::string said(const std::string& method, const std::string& target) const { return ask(method, target).body; }
    std::string not_there(const std::string& path) const {
        const Response response = ask("GET", path);
        EXPECT_EQ(response.status, 404u) << path;
        return response.body;
    }

    Routes routes;
};

class RoutesTest : public Table {
protected:
    void SetUp() override {
        add("GET", "/status");
        add("GET", "/links/{name}");
        add("DELETE", "/links/{name}");
        add("POST", "/gpio");
        add("GET", "/devices/{device}/parameters/{parameter}");
        add("GET", "/devices/{device}/parameters");
    }
};

TEST_F(RoutesTest, the_row_of_method_and_path_is_used) {
    EXPECT_EQ(said("GET", "/status"), "GET /status");
    EXPECT_EQ(said("HEAD", "/status"), "GET /status");
    EXPECT_EQ(said("POST", "/gpio"), "POST /gpio");
    EXPECT_EQ(said("GET", "http://anogate/status"), "GET /status");
    EXPECT_EQ(said("DELETE", "/links/fc"), "DELETE /links/{name} name=fc");
}

TEST_F(RoutesTest, parameters_and_query_are_decoded) {
    EXPECT_EQ(said("GET", "/links/my%20link%2F1+2"), "GET /links/{name} name=my link/1+2");
    EXPECT_EQ(said("GET", "/devices/0xDC/parameters/7"), "GET /devices/{device}/parameters/{parameter} device=0xDC parameter=7");
    EXPECT_EQ(said("GET", "/devices/0xDC/parameters?n=a%26b+c&d"), "GET /devices/{device}/parameters device=0xDC ?n=a&b c ?d=");
}

TEST_F(RoutesTest, the_first_matching_row_is_used) {
    add("GET", "/links/all");
    EXPECT_EQ(said("GET", "/links/all"), "GET /links/{name} name=all");
}

TEST_F(RoutesTest, an_invalid_percent_encoding_is_rejected_with_an_explanation) {
    for (const char* target : {"/links/%", "/links/a%2", "/links/%zz"}) {
        EXPECT_EQ(ask("GET", target).status, 400u) << target;
        EXPECT_NE(said("GET", target).find("the path has a %"), std::string::npos) << target;
    }
    EXPECT_EQ(ask("GET", "/links/a%00b").status, 400u);
    EXPECT_NE(said("GET", "/links/a%00b").find("the path has %00, which is not allowed in names"), std::string::npos);
    EXPECT_EQ(ask("GET", "/status?a=%").status, 400u);
    EXPECT_NE(said("GET", "/status?a=%").find("the query has a %"), std::string::npos);
}

TEST_F(RoutesTest, the_response_for_an_unsupported_method_lists_the_supported_ones) {
    const Response posted = ask("POST", "/status");
    EXPECT_EQ(posted.status, 405u);
    EXPECT_EQ(posted.headers, (std::vector<Field>{{"Allow", "GET, HEAD"}}));
    EXPECT_EQ(posted.body, error(405, "this path supports only GET, HEAD").body);
    EXPECT_EQ(ask("PUT", "/links/fc").headers, (std::vector<Field>{{"Allow", "GET, HEAD, DELETE"}}));
    add("GET", "/links/last");
    EXPECT_EQ(ask("PUT", "/links/last").headers, (std::vector<Field>{{"Allow", "GET, HEAD, DELETE"}})) << "each once";
    EXPECT_EQ(ask("HEAD", "/gpio").headers, (std::vector<Field>{{"Allow", "POST"}}));
    EXPECT_EQ(ask("get", "/status").status, 405u) << "methods have capitals";
}

TEST_F(RoutesTest, the_response_for_an_unknown_path_suggests_the_nearest_one) {
    const auto nothing = [](const std::string& rest) { return error(404, "this path does not exist" + rest).body; };
    EXPECT_EQ(not_there("/statsu"), nothing(" (did you mean '/status'?)"));
    EXPECT_EQ(not_there("/status/"), nothing(" (did you mean '/status'?)"));
    EXPECT_EQ(not_there("/link/a-long-name"), nothing(" (did you mean '/links/{name}'?)"));
    EXPECT_EQ(not_there("/devices/0xDC/paramters"), nothing(" (did you mean '/devices/{device}/parameters'?)"));
    EXPECT_EQ(not_there("/something/else"), nothing("; try /status"));
    EXPECT_EQ(not_there("/"), nothing("; try /status"));
}

TEST_F(RoutesTest, a_target_that_only_resembles_a_path_is_not_found) {
    for (const char* target : {"", "*", "status", "//status", "/status//", "/links/", "/links", "/links/a/b", "http://status"})
        EXPECT_EQ(ask("GET", target).status, 404u) << target;
    EXPECT_EQ(ask("GET", "/" + std::string(8000, '/')).status, 404u);
}

TEST_F(Table, without_rows_finds_no_path) { EXPECT_EQ(not_there("/status"), error(404, "this path does not exist").body); }

}    // namespace
}    // namespace anogate::http::routes_tests
