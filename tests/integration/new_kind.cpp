// A link kind is one file and one row: a test kind is read, printed, explained, checked and run without any other code that
// mentions it.
#include <config/config.hpp>
#include <config/help.hpp>
#include <link/kinds.hpp>
#include <support/running_gateway.hpp>
#include <support/toy_link.hpp>
#include <support/udp_peer.hpp>

#include <gtest/gtest.h>

namespace new_kind_tests {
namespace {

using namespace anogate;
using namespace support;
using nlohmann::json;

const LinkKind* const serial_row = find_link_kind("serial");
const LinkKind* const udp_row = find_link_kind("udp");
const LinkKind* const kinds[] = {serial_row, udp_row, &toy_kind};

LinkSettings read(std::string_view text) {
    Draft draft{kinds};
    read_link(text, "", draft);
    validate(draft);
    EXPECT_EQ(lines(draft.errors), "");
    return draft.settings.links.at(0);
}

std::string faults(std::string_view link) {
    Draft draft{kinds};
    read_link(link, "", draft);
    validate(draft);
    return lines(draft.errors);
}

TEST(NewKind, is_read_from_text_and_from_json_alike) {
    const LinkSettings link = read("toy:hello,times=3,id=5");
    EXPECT_EQ(link.kind, &toy_kind);
    EXPECT_EQ(link.name, "toy-hello");
    EXPECT_EQ(link.as<ToySettings>(), (ToySettings{"hello", 3}));
    const Draft draft = parse_config(R"({"links": [{"kind": "toy", "word": "hello", "times": 3, "id": 5}]})", kinds);
    EXPECT_EQ(lines(draft.errors), "");
    EXPECT_EQ(draft.settings.links, std::vector{link});
}

TEST(NewKind, is_printed_as_it_is_read) {
    Settings settings;
    settings.links = {read("toy:hello,times=3"), read("udp:127.0.0.1:9")};
    const std::string printed = print_config(settings);
    const json link = json::parse(printed)["links"][0];
    EXPECT_EQ(link["kind"], "toy");
    EXPECT_EQ(link["word"], "hello");
    EXPECT_EQ(link["times"], 3);
    EXPECT_FALSE(link.contains("rate")) << "of kinds that may be paced";
    EXPECT_EQ(parse_config(printed, kinds).settings, settings);
}

TEST(NewKind, is_explained) {
    const std::string help = links_and_keys_help(kinds);
    EXPECT_NE(help.find("  toy:hello "), std::string::npos);
    EXPECT_NE(help.find("    times=NUMBER "), std::string::npos);
    EXPECT_NE(help.find("how often the toy says it (default 1)"), std::string::npos);
    EXPECT_NE(help.find(R"({"kind": "toy", "word": "hello"})"), std::string::npos);
    const json rows = json::parse(config_schema(kinds))["properties"]["links"]["items"]["anyOf"];
    EXPECT_EQ(rows.back()["properties"]["kind"]["const"], "toy");
    EXPECT_EQ(rows.back()["properties"]["times"]["maximum"], 9);
    EXPECT_EQ(rows.back()["required"], (json{"kind", "word"}));
}

TEST(NewKind, is_checked) {
    EXPECT_EQ(faults("toy:no"), "anogated: LINK 'toy:no': 'word' can't be 'no': toys are friendly\n");
    EXPECT_EQ(faults("toy:hello,times=10"),
              "anogated: LINK 'toy:hello,times=10': 'times' must be a whole number from 1 to 9, not '10'\n");
    EXPECT_EQ(faults("toy:hello,tims=1"), "anogated: LINK 'toy:hello,tims=1': unknown key 'tims' (did you mean 'times'?)\n");
    EXPECT_EQ(faults("serial:/dev/x,times=1"),
              "anogated: LINK 'serial:/dev/x,times=1': 'times' is not a key of serial, but of toy\n");
    EXPECT_EQ(faults("toi:hello"),
              "anogated: LINK 'toi:hello': unknown kind 'toi' (did you mean 'toy'?); the kinds are serial, udp, toy\n");
}

TEST(NewKind, runs) {
    UdpPeer host;
    RunningGateway daemon{read("udp:127.0.0.1:" + std::to_string(host.port())), read("toy:hello,times=2")};
    ASSERT_TRUE(daemon.until([&] { return daemon.count("toy-hello", "frames_in") == 2; }));
    ASSERT_TRUE(daemon.until([&] { return !host.heard().empty(); }));
    EXPECT_EQ(daemon.link("toy-hello")["kind"], "toy");
    EXPECT_EQ(daemon.link("toy-hello")["word"], "hello");
}

}    // namespace
}    // namespace new_kind_tests
