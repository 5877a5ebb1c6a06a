// A real gateway with one UDP peer, and its folder of recordings.
#pragma once
#include "asked.hpp"
#include "bytes.hpp"
#include "files.hpp"
#include "numbered_frames.hpp"
#include "process.hpp"
#include "temp_dir.hpp"
#include "udp_peer.hpp"
#include "wait.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

namespace support {

class RecordingGateway : public testing::Test {
protected:
    using json = nlohmann::json;
    static inline const Bytes euler = frame(0xDC, 0xFF, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});

    /// `record`: the section with its leading comma; empty: none.
    void start(const std::string& record = {}, const std::string& more = {}) {
        write_config(record, more);
        gateway = std::make_unique<Daemon>(ANOGATED, socket, std::vector<std::string>{"--config", dir / "anogate.json"});
        ASSERT_TRUE(gateway->until_answers()) << gateway->output();
    }
    void write_config(const std::string& record, const std::string& more = {}) {
        dir.write("anogate.json", R"({"links": [")" + a.link("a") + "\"" + more + "]" + record + "}");
    }
    anogate::http::Answer ask(const std::string& method, const std::string& target, const std::string& body = {}) const {
        return asked(socket, method, target, body);
    }
    json get() const { return json::parse(ask("GET", "/recordings").body, nullptr, false); }
    json begin(const json& body) const {
        const anogate::http::Answer answer = ask("POST", "/recordings", body.dump());
        EXPECT_EQ(answer.status, 200u) << answer.body;
        return json::parse(answer.body, nullptr, false);
    }
    json end(const std::string& name) const {
        const anogate::http::Answer answer = ask("POST", "/recordings/" + name + "/end");
        EXPECT_EQ(answer.status, 200u) << answer.body;
        return json::parse(answer.body, nullptr, false);
    }
    void refuses(unsigned status, const std::string& method, const std::string& target, const std::string& body,
                 const std::string& words) const {
        const anogate::http::Answer answer = ask(method, target, body);
        EXPECT_EQ(answer.status, status) << answer.body;
        EXPECT_NE(answer.body.find(words), std::string::npos) << answer.body;
    }
    void send(const Bytes& bytes = euler) { a.send(gateway->port("a"), bytes); }
    /// Sends numbered frames, each in a datagram, and waits until the gateway has received them: at most 100 at a time, since its
    /// socket holds only some hundred.
    void send_numbered(int count) {
        const auto port = gateway->port("a");
        std::uint64_t taken = gateway->count("a", "frames_in");
        while (count > 0) {
            const int some = std::min(count, 100);
            for (int i = 0; i < some; ++i) a.send(port, numbered(0xDC, 0xFF, sent_++));
            taken += static_cast<std::uint64_t>(some);
            count -= some;
            ASSERT_TRUE(gateway->until([&](const json&) { return gateway->count("a", "frames_in") >= taken; }));
        }
    }
    bool until(const std::function<bool(const json&)>& holds) const {
        return wait_until([&] { return holds(get()); });
    }
    /// The content of a file in the folder of recordings.
    std::string content(const std::string& name) const { return file_text(folder + "/" + name); }
    std::vector<std::string> names() const {
        std::vector<std::string> all;
        std::error_code none;
        for (const auto& entry : std::filesystem::directory_iterator{folder, none}) all.push_back(entry.path().filename());
        std::sort(all.begin(), all.end());
        return all;
    }
    void stop() {
        gateway->signal(SIGTERM);
        EXPECT_EQ(gateway->wait(), 0) << gateway->output();
    }
    json file_called(const std::string& name) const {
        const json all = get();
        for (const json& file : all.at("recordings"))
            if (file.at("name") == name) return file;
        return {};
    }

    TempDir dir;
    std::string socket = dir / "control.sock", folder = socket + ".state/recordings";
    UdpPeer a;
    std::unique_ptr<Daemon> gateway;
    int sent_ = 0;
};

}    // namespace support
