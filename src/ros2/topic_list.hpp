// The text of anogate-ros2 --list.
#pragma once
#include <ano/time.hpp>
#include <ros2/device_publisher.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class TopicList {
public:
    /// `watched`: for how long frames were received.
    explicit TopicList(ano::Duration watched) : watched_{watched} {}

    void add(const DevicePublisher& device);
    void add_input(const std::string& prefix, Input input);
    void add_refused(const std::string& link, std::uint8_t address, const std::string& why);
    void add_note(std::string note) { notes_.push_back(std::move(note)); }

    /// A table with a line for each topic, and notes below.
    std::string text() const;

private:
    std::string rate(std::uint64_t count) const;

    using Row = std::array<std::string, 5>;    // topic, type, source, rate, why it is silent
    ano::Duration watched_;
    std::vector<Row> rows_;
    std::vector<std::string> notes_;
};

}    // namespace anogate
