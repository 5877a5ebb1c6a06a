#include <gtest/gtest.h>
#include <anoctl/web/web_names.hpp>

#include <filesystem>
#include <string>
#include <vector>

#include <support/anoctl.hpp>
#include <support/temp_dir.hpp>

namespace web_names_tests {
namespace {

using namespace anoctl;
using anogate::IpAddress;
using Urls = std::vector<std::string>;

IpAddress address(const char* text) { return IpAddress::parse(text).value(); }

WebAddress address_at(const char* where, bool is_encrypted = false) {
    WebAddress web_address;
    static_cast<anogate::Endpoint&>(web_address) = anogate::Endpoint::parse(where).value();
    web_address.is_encrypted = is_encrypted;
    return web_address;
}

Computer vehicle() {
    return {"vehicle",
            {address("127.0.0.1"), address("192.168.1.5"), address("::1"), address("2001:db8::5"), address("fe80::1%lo")}};
}

TEST(WebNames, of_all_interfaces_are_those_that_others_can_reach) {
    EXPECT_EQ(urls_of(address_at("0.0.0.0:8088"), vehicle()),
              (Urls{"http://192.168.1.5:8088/", "http://vehicle:8088/", "http://vehicle.local:8088/"}));
    EXPECT_EQ(urls_of(address_at("[::]:8088", true), vehicle()), (Urls{"https://192.168.1.5:8088/", "https://[2001:db8::5]:8088/",
                                                                       "https://vehicle:8088/", "https://vehicle.local:8088/"}));
}

TEST(WebNames, of_one_address_are_the_address_and_the_host_names) {
    EXPECT_EQ(urls_of(address_at("192.168.1.5:80"), vehicle()),
              (Urls{"http://192.168.1.5:80/", "http://vehicle:80/", "http://vehicle.local:80/"}));
    EXPECT_EQ(url_here(address_at("192.168.1.5:80")), "http://192.168.1.5:80/");
}

TEST(WebNames, of_a_loopback_address_are_for_this_computer) {
    EXPECT_EQ(urls_of(address_at("127.0.0.1:80"), vehicle()), (Urls{"http://127.0.0.1:80/", "http://localhost:80/"}));
    EXPECT_EQ(urls_of(address_at("[::1]:80"), vehicle()), (Urls{"http://[::1]:80/", "http://localhost:80/"}));
    EXPECT_EQ(url_here(address_at("0.0.0.0:80", true)), "https://localhost:80/");
}

TEST(WebNames, for_phones_prefer_an_ipv4_address) {
    EXPECT_EQ(url_for_phones(address_at("[::]:8088"), {"vehicle", {address("2001:db8::5"), address("10.0.0.2")}}),
              "http://10.0.0.2:8088/");
    EXPECT_EQ(url_for_phones(address_at("[::]:8088"), {"", {address("2001:db8::5")}}), "http://[2001:db8::5]:8088/");
}

TEST(WebNames, include_configured_hosts_and_skip_a_missing_host_name) {
    WebAddress web_address = address_at("0.0.0.0:80");
    web_address.hosts = {"vehicle.lan"};
    EXPECT_EQ(urls_of(web_address, {"", {address("10.0.0.2")}}), (Urls{"http://10.0.0.2:80/", "http://vehicle.lan:80/"}));
}

TEST(Certificate, for_another_computer_says_which_files_to_copy) {
    const support::TempDir dir;
    const std::string into = std::filesystem::canonical(dir.path()).string() + "/";
    EXPECT_EQ(support::anoctl({"certificate", "--into", into}).out.find("Copy "), std::string::npos);
    const auto other = support::anoctl({"certificate", "vehicle2.example", "--into", into});
    EXPECT_EQ(other.exit, 0) << other.err;
    EXPECT_NE(other.out.find("\nCopy " + into + "vehicle2.example.pem, " + into + "vehicle2.example-key.pem and " + into +
                             "ca.pem to vehicle2.example, and adapt the paths there.\nLinks:\n"),
              std::string::npos)
        << other.out;
}

}    // namespace
}    // namespace web_names_tests
