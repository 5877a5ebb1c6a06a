// MCAP recordings of the gateway: by its configuration, on request, of the most recent frames, and after SIGKILL.
#include <record/mcap/mcap_format.hpp>
#include <support/recorded.hpp>
#include <support/recording_gateway.hpp>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <thread>

namespace recordings_mcap_tests {
namespace {

using namespace support;
namespace mcap = anogate::mcap;

/// The number of messages of each topic according to the summary of the file; a file without an end has no summary.
std::map<std::string, std::uint64_t> messages_of(std::string_view file) {
    std::map<std::uint16_t, std::string> topics;
    std::map<std::string, std::uint64_t> messages;
    std::string_view rest = file.substr(mcap::magic.size());
    while (const auto record = mcap::next_record(rest)) {
        if (record->opcode == mcap::Opcode::channel) {
            const auto channel = mcap::channel_of(record->body);
            if (channel) topics[channel->id] = channel->topic;
        }
        if (record->opcode != mcap::Opcode::statistics) continue;
        constexpr std::size_t before_counts = 8 + 2 + 4 + 4 + 4 + 4 + 8 + 8;
        mcap::Fields fields{record->body.substr(before_counts)};
        for (mcap::Fields counts{fields.text()}; !counts.rest().empty() && !counts.is_bad();) {
            const auto channel = counts.number<std::uint16_t>();
            messages[topics[channel]] = counts.number<std::uint64_t>();
        }
    }
    return messages;
}

/// The encoding of the messages of each topic according to the summary of the file.
std::map<std::string, std::string> encodings_of(std::string_view file) {
    std::map<std::string, std::string> encodings;
    std::string_view rest = file.substr(mcap::magic.size());
    while (const auto record = mcap::next_record(rest)) {
        if (record->opcode != mcap::Opcode::channel) continue;
        const auto channel = mcap::channel_of(record->body);
        if (channel) encodings[std::string{channel->topic}] = channel->encoding;
    }
    return encodings;
}

class RecordingsAsMcap : public RecordingGateway {
protected:
    /// Sends `count` of them; returns when the gateway has received `all` frames in total.
    void send_eulers(int count, std::uint64_t all) {
        for (int i = 0; i < count; ++i) send(euler);
        ASSERT_TRUE(gateway->until([&](const json&) { return gateway->count("a", "frames_in") == all; }));
    }
    static void holds_numbered(const ReadRecording& read, std::size_t least) {
        ASSERT_GE(read.items.size(), least);
        for (std::size_t i = 0; i < least; ++i) EXPECT_EQ(read.items[i].frame, numbered(0xDC, 0xFF, static_cast<int>(i)));
    }
};

TEST_F(RecordingsAsMcap, contain_every_frame_and_its_decoded_message) {
    start();
    EXPECT_EQ(begin({{"name", "m"}, {"format", "mcap"}}).at("file"), "m.mcap");
    send_numbered(50);
    send_eulers(20, 70);
    EXPECT_EQ(file_called("m.mcap").at("state"), "recording");
    EXPECT_EQ(end("m").at("frames"), 70);
    const json file = file_called("m.mcap");
    EXPECT_EQ(file.at("state"), "ended");
    EXPECT_EQ(file.at("format"), "mcap");
    EXPECT_EQ(file.at("frames"), 70);

    const std::string fetched = ask("GET", "/recordings/m.mcap").body;
    EXPECT_EQ(fetched, content("m.mcap"));
    const ReadRecording read = read_recording(fetched);
    EXPECT_TRUE(read.has_end);
    EXPECT_EQ(read.fault, "");
    ASSERT_EQ(read.items.size(), 70u);
    holds_numbered(read, 50);
    EXPECT_EQ(read.items[69].frame, euler);
    EXPECT_EQ(read.items[69].link, "a");
    EXPECT_EQ(read.items[69].description, "udp");
    const auto messages = messages_of(fetched);
    EXPECT_EQ(messages.at("/anogate/frames"), 70u);
    EXPECT_EQ(messages.at("/a/device_220/euler"), 20u) << json(messages);
    EXPECT_EQ(ask("DELETE", "/recordings/m.mcap").status, 200u);
    EXPECT_TRUE(names().empty());
}

TEST_F(RecordingsAsMcap, of_recent_frames_are_fetched_and_saved) {
    start(R"(, "record": {"start": false, "keep_last": "60s"})");
    send_numbered(40);
    send_eulers(5, 45);
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("frames") == 45; }));
    const auto is_all_of_it = [](const std::string& file) {
        const ReadRecording read = read_recording(file);
        EXPECT_TRUE(read.has_end) << read.fault;
        EXPECT_EQ(read.items.size(), 45u);
        holds_numbered(read, 40);
        EXPECT_EQ(messages_of(file).at("/a/device_220/euler"), 5u);
    };
    const auto fetched = ask("GET", "/recordings/last?format=mcap");
    EXPECT_EQ(fetched.status, 200u);
    is_all_of_it(fetched.body);
    const auto saved = ask("POST", "/recordings", R"({"last": true, "name": "incident", "format": "mcap"})");
    EXPECT_EQ(saved.status, 200u) << saved.body;
    EXPECT_EQ(names(), std::vector<std::string>{"incident.mcap"});
    is_all_of_it(content("incident.mcap"));
    EXPECT_EQ(file_called("incident.mcap").at("frames"), 45);
}

TEST_F(RecordingsAsMcap, encode_decoded_messages_as_configured_or_requested) {
    start(R"(, "record": {"start": false, "format": "mcap", "message_encoding": "json", "keep_last": "60s"})");
    begin({{"name", "usual"}});
    begin({{"name", "asked"}, {"message_encoding", "cdr"}});
    send_eulers(5, 5);
    ASSERT_TRUE(until([](const json& all) { return all.at("keep_last").at("frames") == 5; }));
    const auto is_in = [](const std::string& file, const std::string& encoding) {
        const auto encodings = encodings_of(file);
        EXPECT_EQ(encodings.at("/a/device_220/euler"), encoding);
        EXPECT_EQ(encodings.at("/a/device_220/orientation"), encoding);
        EXPECT_EQ(encodings.at("/anogate/frames"), "cdr");
    };
    end("usual");
    end("asked");
    is_in(content("usual.mcap"), "json");
    is_in(content("asked.mcap"), "cdr");
    is_in(ask("GET", "/recordings/last").body, "json");
    is_in(ask("GET", "/recordings/last?message_encoding=cdr").body, "cdr");
    EXPECT_EQ(ask("POST", "/recordings", R"({"last": true, "name": "last"})").status, 200u);
    is_in(content("last.mcap"), "json");
    EXPECT_EQ(ask("POST", "/recordings", R"({"last": true, "name": "last-cdr", "message_encoding": "cdr"})").status, 200u);
    is_in(content("last-cdr.mcap"), "cdr");
    EXPECT_EQ(ask("GET", "/recordings/last?message_encoding=xml").status, 400u);
    EXPECT_EQ(ask("GET", "/recordings/last?format=pcapng&message_encoding=cdr").status, 400u);
}

TEST_F(RecordingsAsMcap, begin_with_the_gateway_and_end_with_it) {
    start(R"(, "record": {"format": "mcap"})");
    ASSERT_TRUE(until([](const json& all) { return all.at("running").size() == 1 && all.at("running")[0].at("files") == 1; }));
    send_numbered(20);
    stop();
    ASSERT_EQ(names().size(), 1u);
    EXPECT_TRUE(names()[0].ends_with(".mcap"));
    const ReadRecording read = read_recording(content(names()[0]));
    EXPECT_TRUE(read.has_end) << "what waited was written";
    EXPECT_EQ(read.items.size(), 20u);
    holds_numbered(read, 20);
}

TEST_F(RecordingsAsMcap, lose_at_most_a_second_when_the_gateway_is_killed_and_are_repaired_at_the_next_start) {
    start(R"(, "record": {"format": "mcap"})");
    send_numbered(30);
    send_eulers(5, 35);
    std::this_thread::sleep_for(std::chrono::seconds{1});    // until no earlier frame can be missing
    send_numbered(10);
    gateway->signal(SIGKILL);
    gateway->wait();
    ASSERT_EQ(names().size(), 1u);
    const std::string name = names()[0];
    EXPECT_FALSE(read_recording(content(name)).has_end);
    start(R"(, "record": {"start": false})");
    ASSERT_TRUE(wait_until([&] { return file_called(name).at("state") == "ended"; })) << gateway->output();
    EXPECT_TRUE(gateway->until_says("repaired the truncated " + name));
    const ReadRecording read = read_recording(content(name));
    EXPECT_TRUE(read.has_end) << read.fault;
    ASSERT_GE(read.items.size(), 35u);
    holds_numbered(read, 30);
    EXPECT_EQ(file_called(name).at("frames"), read.items.size());
    EXPECT_EQ(messages_of(content(name)).at("/a/device_220/euler"), 5u);
}

}    // namespace
}    // namespace recordings_mcap_tests
