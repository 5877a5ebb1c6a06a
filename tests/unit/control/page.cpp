#include <control/page.hpp>

#include <gtest/gtest.h>
#include <support/temp_dir.hpp>

#include <filesystem>
#include <utility>

namespace page_tests {
namespace {

using anogate::Page;
using anogate::http::Request;
using anogate::http::Response;
namespace fs = std::filesystem;

Request browser() {
    Request request;
    request.headers = {{"Accept", "text/html,application/xhtml+xml,*/*;q=0.8"}, {"Accept-Encoding", "gzip, deflate"}};
    return request;
}

std::string header(const Response& response, std::string_view name) {
    return std::string{anogate::http::field_value(response.headers, name)};
}

class PageFiles : public testing::Test {
protected:
    support::TempDir dir;
    Page page() {
        (void)dir.write("index.html.gz", "the front page");
        (void)dir.write("page-0123.js.gz", "a script");
        return Page::read(dir.path());
    }
};

TEST_F(PageFiles, are_served_compressed_with_a_strict_policy) {
    const Page all = page();
    const Response front = all.file("", browser());
    EXPECT_EQ(front.status, 200u);
    EXPECT_EQ(front.body, "the front page");
    EXPECT_EQ(front.type, "text/html; charset=utf-8");
    EXPECT_EQ(header(front, "Content-Encoding"), "gzip");
    EXPECT_EQ(header(front, "Cache-Control"), "no-cache");
    EXPECT_TRUE(header(front, "Content-Security-Policy").starts_with("default-src 'none'; script-src 'self';"));
    const Response script = all.file("page-0123.js", browser());
    EXPECT_EQ(script.body, "a script");
    EXPECT_EQ(script.type, "text/javascript; charset=utf-8");
    EXPECT_NE(header(script, "Cache-Control").find("immutable"), std::string::npos) << "its name tells its content";
}

TEST_F(PageFiles, include_only_files_that_existed_at_the_start) {
    const Page all = page();
    (void)dir.write("late.js.gz", "later");
    for (const char* name : {"late.js", "../etc/passwd", "/etc/passwd", ".", "index.html.gz", "none.js"})
        EXPECT_EQ(all.file(name, browser()).status, 404u) << name;
}

TEST_F(PageFiles, are_sent_only_to_clients_that_accept_them) {
    const Page all = page();
    EXPECT_TRUE(all.is_wanted_by(browser()));
    Request program;
    program.headers = {{"Accept", "*/*"}};
    EXPECT_FALSE(all.is_wanted_by(program)) << "curl gets the list of routes";
    EXPECT_EQ(all.file("page-0123.js", program).status, 406u);
    for (const auto& [encodings, status] :
         {std::pair{"*", 200u}, {"br, gzip;q=0.5", 200u}, {"gzip;q=0, *", 406u}, {"*;q=0", 406u}, {"br", 406u}}) {
        program.headers = {{"Accept-Encoding", encodings}};
        EXPECT_EQ(all.file("page-0123.js", program).status, status) << encodings;
    }
}

TEST_F(PageFiles, without_a_front_page_are_not_used_as_a_page) {
    (void)dir.write("page-0123.js.gz", "a script");
    EXPECT_TRUE(Page::read(dir.path()).empty());
    EXPECT_TRUE(Page::read("/nowhere/at/all").empty());
    EXPECT_FALSE(Page{}.is_wanted_by(browser()));
    EXPECT_EQ(Page{}.file("", browser()).status, 404u);
}

TEST_F(PageFiles, that_exceed_the_size_limit_are_not_used_as_a_page) {
    (void)dir.write("big.js.gz", std::string(2 * 1024 * 1024, 'x'));
    EXPECT_TRUE(page().empty());
}

TEST(PageFolder, is_found_relative_to_the_program) {
    EXPECT_EQ(anogate::page_folder_of("/usr/bin/anogated"), "/usr/share/anogate/web");
    EXPECT_EQ(anogate::page_folder_of("/opt/anogate/sbin/anogated"), "/opt/anogate/share/anogate/web");
    EXPECT_EQ(anogate::page_folder_of("/home/me/anogate/build/run/src/anogated"), "/home/me/anogate/build/run/web");
}

}    // namespace
}    // namespace page_tests
