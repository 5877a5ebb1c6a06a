// A bus whose messages are decoded as by a program that has the definitions, and an output that keeps what it is given.
#pragma once
#include <ros2/bridge.hpp>
#include <support/bytes.hpp>
#include <support/ros_definition.hpp>

#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

namespace ros2_tests {

class FakeBus final : public anogate::Bus {
public:
    struct Advertised {
        anogate::TopicSpec spec;
        bool is_withdrawn = false;
        std::vector<ano::Json> messages{};
    };
    Topic advertise(anogate::TopicSpec spec) override {
        topics.push_back({std::move(spec)});
        return topics.size() - 1;
    }
    void withdraw(Topic topic) override { topics[topic].is_withdrawn = true; }
    bool has_subscribers(Topic) const override { return someone_subscribes; }
    void publish(Topic topic, std::string_view cdr) override {
        Advertised& to = topics[topic];
        to.messages.push_back(support::decoded_cdr(definition_of(*to.spec.type), cdr));
    }
    std::size_t subscribe(anogate::TopicSpec spec) override {
        subscriptions.push_back(std::move(spec));
        return subscriptions.size() - 1;
    }

    /// The messages on the topic `name`; empty: none, or there is no such topic.
    std::vector<ano::Json> on(const std::string& name) const {
        for (const Advertised& topic : topics)
            if (topic.spec.name == name && !topic.is_withdrawn) return topic.messages;
        return {};
    }
    bool has(const std::string& name) const {
        for (const Advertised& topic : topics)
            if (topic.spec.name == name && !topic.is_withdrawn) return true;
        return false;
    }

    bool someone_subscribes = true;
    std::vector<Advertised> topics;
    std::vector<anogate::TopicSpec> subscriptions;
};

class KeptOutput final : public anogate::BridgeOutput {
public:
    bool send(ano::Bytes frame) override {
        if (is_connected) frames.emplace_back(frame.begin(), frame.end());
        return is_connected;
    }
    bool call(std::uint8_t address, const anogate::CommandText& command,
              std::function<void(const anogate::http::Outcome&)> done) override {
        calls.push_back({address, command, std::move(done)});
        return has_room;
    }
    void log(std::string_view line) override { lines.emplace_back(line); }
    void warn(std::string_view line) override { warnings.emplace_back(line); }

    struct Call {
        std::uint8_t address;
        anogate::CommandText command;
        std::function<void(const anogate::http::Outcome&)> done;
    };
    bool is_connected = true, has_room = true;
    std::vector<support::Bytes> frames;
    std::vector<Call> calls;
    std::vector<std::string> lines, warnings;
};

}    // namespace ros2_tests
