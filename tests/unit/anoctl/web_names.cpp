#include <gtest/gtest.h>
#include <anoctl/web/web_names.hpp>

#include <http/client/certificate.hpp>

#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
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

TEST(WebNames, of_a_host_name_with_a_domain_are_that_name_alone) {
    EXPECT_EQ(names_of({"gw.local", {}}), std::vector<std::string>{"gw.local"});
    EXPECT_EQ(names_of({"gw", {}}), (std::vector<std::string>{"gw", "gw.local"}));
}

struct Certificate : testing::Test {
    support::AnoctlResult make(std::vector<std::string> words) const {
        words.insert(words.begin(), {"certificate", "--into", into});
        return support::anoctl(words);
    }
    std::string read(const std::string& file) const {
        std::ifstream in{into + file};
        return {std::istreambuf_iterator<char>{in}, {}};
    }
    const support::TempDir dir;
    const std::string into = std::filesystem::canonical(dir.path()).string() + "/";
};

TEST_F(Certificate, for_another_computer_says_which_files_to_copy_and_prints_its_links) {
    EXPECT_EQ(make({}).out.find("Copy "), std::string::npos);
    const auto other = make({"vehicle2.example"});
    EXPECT_EQ(other.exit, 0) << other.err;
    const std::string files =
        "certificate=/etc/anogate/vehicle2.example.pem,key=/etc/anogate/vehicle2.example-key.pem,ca=/etc/anogate/ca.pem\n";
    EXPECT_EQ(
        other.out.find("Copy vehicle2.example.pem, vehicle2.example-key.pem and ca.pem from " + into.substr(0, into.size() - 1) +
                       " to /etc/anogate on vehicle2.example.\nIf the gateway there is a service, let it read the key, on "
                       "vehicle2.example:\n    sudo chown anogate: /etc/anogate/vehicle2.example-key.pem\nLinks on "
                       "vehicle2.example:\n    "
                       "tls-listen:0.0.0.0:12334," +
                       files + "    tls:"),
        0u)
        << other.out;
    EXPECT_NE(other.out.find(":12334," + files, other.out.find("    tls:")), std::string::npos) << other.out;
}

TEST_F(Certificate, for_another_computer_says_how_its_service_can_read_the_key) {
    const auto made = make({"vehicle2"});
    EXPECT_NE(made.out.find("sudo chown anogate: /etc/anogate/vehicle2-key.pem\n"), std::string::npos) << made.out;
    const auto renewed = make({"vehicle2", "--renew"});
    EXPECT_NE(renewed.out.find("sudo chown anogate: /etc/anogate/vehicle2-key.pem\n"), std::string::npos) << renewed.out;
}

TEST_F(Certificate, has_a_long_name_of_which_the_subject_is_a_part) {
    const std::string name = std::string(40, 'a') + "." + std::string(40, 'b') + ".example";
    const auto made = make({name});
    EXPECT_EQ(made.exit, 0) << made.err;
    const auto names = anogate::http::names_in(into + name + ".pem");
    ASSERT_TRUE(names);
    EXPECT_EQ(names->hosts, std::vector<std::string>{name});
}

TEST_F(Certificate, is_made_without_the_dot_at_the_end_of_a_name) {
    EXPECT_EQ(make({"vehicle2.example."}).exit, 0);
    EXPECT_TRUE(std::filesystem::exists(into + "vehicle2.example.pem"));
    const auto names = anogate::http::names_in(into + "vehicle2.example.pem");
    ASSERT_TRUE(names);
    EXPECT_EQ(names->hosts, std::vector<std::string>{"vehicle2.example"});
    EXPECT_EQ(make({"ca."}).exit, 2);
}

TEST_F(Certificate, is_not_made_for_what_is_no_address_of_one_computer) {
    for (const char* name : {"0.0.0.0", "::", "224.0.0.1", "ff02::1", "255.255.255.255"}) {
        const auto made = make({name});
        EXPECT_EQ(made.exit, 2) << name;
        EXPECT_NE(made.err.find("is not the address of one computer"), std::string::npos) << made.err;
    }
    const auto with_interface = make({"fe80::1%eth0"});
    EXPECT_EQ(with_interface.exit, 2);
    EXPECT_NE(with_interface.err.find("a certificate can't contain an interface: omit %eth0"), std::string::npos)
        << with_interface.err;
    EXPECT_TRUE(std::filesystem::is_empty(into));
}

TEST_F(Certificate, leaves_no_authority_behind_if_it_can_not_be_made) {
    const std::string name(240, 'a');    // its files would have too long names
    std::string labels = name;
    for (std::size_t i = 60; i < labels.size(); i += 61) labels[i] = '.';
    EXPECT_EQ(make({labels + ".example.org"}).exit, 1);
    EXPECT_TRUE(std::filesystem::is_empty(into));
}

TEST_F(Certificate, is_not_made_for_an_empty_name) {
    const auto made = make({""});
    EXPECT_EQ(made.exit, 2);
    EXPECT_EQ(made.err, "anoctl: NAME is an empty name; for the certificate of this computer, omit it\n");
    EXPECT_TRUE(std::filesystem::is_empty(into));
}

TEST_F(Certificate, that_exists_is_replaced_on_request_by_one_of_the_same_authority) {
    ASSERT_EQ(make({"vehicle"}).exit, 0);
    const std::string authority = read("ca.pem"), first = read("vehicle.pem"), key = read("vehicle-key.pem");
    std::filesystem::permissions(into + "vehicle-key.pem", std::filesystem::perms{0640});
    const auto again = make({"vehicle"});
    EXPECT_EQ(again.exit, 1);
    EXPECT_EQ(again.err, "anoctl: " + into +
                             "vehicle.pem already exists; to replace the certificate and its key by new ones, use "
                             "--renew\n");
    EXPECT_EQ(read("vehicle.pem"), first);
    const auto renewed = make({"vehicle", "--renew"});
    ASSERT_EQ(renewed.exit, 0) << renewed.err;
    EXPECT_NE(renewed.out.find("Copy both to vehicle"), std::string::npos) << renewed.out;
    EXPECT_NE(read("vehicle.pem"), first);
    EXPECT_NE(read("vehicle-key.pem"), key);
    EXPECT_EQ(read("ca.pem"), authority);
    EXPECT_EQ(std::filesystem::status(into + "vehicle-key.pem").permissions(), std::filesystem::perms{0640});
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator{dir.path()}, {}), 4) << "nothing else is left";
}

TEST_F(Certificate, never_replaces_the_files_of_the_authority_and_renews_only_what_exists) {
    ASSERT_EQ(make({"vehicle"}).exit, 0);
    const std::string authority = read("ca.pem"), key = read("ca-key.pem");
    for (const char* name : {"ca", "ca-key", "vehicle-key"}) {
        const auto made = make({name, "--renew"});
        EXPECT_EQ(made.exit, 2) << made.err;
        EXPECT_NE(made.err.find("choose another name"), std::string::npos) << made.err;
    }
    const auto absent = make({"vehicle3", "--renew"});
    EXPECT_EQ(absent.exit, 1);
    EXPECT_EQ(absent.err, "anoctl: " + into + "vehicle3.pem not found; to make a new certificate, omit --renew\n");
    EXPECT_EQ(read("ca.pem"), authority);
    EXPECT_EQ(read("ca-key.pem"), key);
}

TEST_F(Certificate, keeps_the_addresses_of_networks_that_are_not_connected_when_it_is_renewed) {
    char name[256] = {};
    ASSERT_EQ(::gethostname(name, sizeof name - 1), 0);
    ASSERT_EQ(make({}).exit, 0);
    const anogate::http::CertificateFiles own{into + name + ".pem", into + name + "-key.pem"};
    const auto replaced = anogate::http::Existing::replaced;
    ASSERT_TRUE(make_signed_certificate({{"other.example"}, {"203.0.113.9", "2001:db8::9"}}, own,
                                        {into + "ca.pem", into + "ca-key.pem"}, replaced));
    const auto renewed = make({"--renew"});
    ASSERT_EQ(renewed.exit, 0) << renewed.err;
    const auto names = anogate::http::names_in(own.certificate);
    ASSERT_TRUE(names);
    const auto has = [](const std::vector<std::string>& all, const char* one) {
        return std::count(all.begin(), all.end(), one) == 1;
    };
    EXPECT_TRUE(has(names->hosts, "localhost") && has(names->hosts, "other.example"));
    EXPECT_TRUE(has(names->addresses, "127.0.0.1") && has(names->addresses, "203.0.113.9") &&
                has(names->addresses, "2001:db8::9"));
}

TEST_F(Certificate, needs_the_key_of_its_authority) {
    const auto none = make({"vehicle", "--renew"});
    EXPECT_EQ(none.exit, 1);
    EXPECT_EQ(none.err.find("anoctl: authority not found: " + into + "ca.pem; "), 0u) << none.err;
    ASSERT_EQ(make({"vehicle"}).exit, 0);
    std::filesystem::rename(into + "ca.pem", into + "moved");
    const auto lost = make({"other"});
    EXPECT_EQ(lost.exit, 1);
    EXPECT_EQ(lost.err.find("anoctl: " + into + "ca-key.pem is here without its certificate ca.pem; copy ca.pem back"), 0u)
        << lost.err;
    std::filesystem::rename(into + "moved", into + "ca.pem");
    std::filesystem::remove(into + "ca-key.pem");
    const auto without = make({"other"});
    EXPECT_EQ(without.exit, 1);
    EXPECT_NE(without.err.find("ca-key.pem: No such file or directory; run this on the computer that has this key"),
              std::string::npos)
        << without.err;
}

}    // namespace
}    // namespace web_names_tests
