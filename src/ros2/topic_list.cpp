#include <ano/hex.hpp>
#include <ros/standard_types.hpp>
#include <ros2/topic_list.hpp>

#include <algorithm>
#include <cmath>

namespace anogate {
namespace {

std::string why_silent(const DevicePublisher& device, const TopicRow& row) {
    if (row.name == "joy" && !device.publishes_joy()) return "it is an input";
    std::uint64_t received = 0;
    for (const std::uint8_t id : row.sources) received += device.received(id);
    if (received > 0) return row.needs.empty() ? "" : "needs " + std::string{row.needs};
    return "the device does not send " + format_sources(row);
}

}    // namespace

std::string TopicList::rate(std::uint64_t count) const {
    const double seconds = std::chrono::duration<double>(watched_).count();
    const double tenths = std::round(10 * static_cast<double>(count) / seconds) / 10;
    return ano::number_text(tenths) + " Hz";
}

void TopicList::add(const DevicePublisher& device) {
    const std::string prefix = '/' + device.prefix() + '/';
    const auto rows = topic_table();
    for (std::size_t i = 0; i < rows.size(); ++i) {
        const std::uint64_t count = device.count(i);
        rows_.push_back({prefix + std::string{rows[i].name}, full_name(*rows[i].type), format_sources(rows[i]), rate(count),
                         count > 0 ? "" : why_silent(device, rows[i])});
    }
    device.for_each_raw([&](const std::string& name, const RosMessage& type, const PublishedTopic& published) {
        rows_.push_back({prefix + name, full_name(type), name.substr(name.rfind('/') + 1), rate(published.count), ""});
    });
}

void TopicList::add_input(const std::string& prefix, Input input) {
    const auto& types = standard_types();
    const std::array of_input{types.twist, types.joy, types.string};
    constexpr std::array becomes{"becomes 0x41", "becomes 0x40", "becomes 0xC0"};
    const auto i = static_cast<std::size_t>(input);
    rows_.push_back({'/' + prefix + '/' + std::string{input_names[i]}, full_name(*of_input[i]), becomes[i], "input", ""});
}

void TopicList::add_refused(const std::string& link, std::uint8_t address, const std::string& why) {
    notes_.push_back("no topics for device " + ano::hex_byte(address) + " on link " + link + ": " + why);
}

std::string TopicList::text() const {
    const Row titles{"TOPIC", "TYPE", "SOURCE", "RATE", "SILENT BECAUSE"};
    std::array<std::size_t, 5> widths{};
    std::vector<Row> all{titles};
    all.insert(all.end(), rows_.begin(), rows_.end());
    for (const Row& row : all)
        for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
    std::string text;
    for (const Row& row : all) {
        std::string line;
        for (std::size_t i = 0; i < row.size(); ++i) line += row[i] + std::string(widths[i] - row[i].size() + 2, ' ');
        line.erase(line.find_last_not_of(' ') + 1);
        text += line + '\n';
    }
    if (rows_.empty())
        text = "no device was heard in " + ano::number_text(std::chrono::duration<double>(watched_).count()) + " s\n";
    for (const std::string& note : notes_) text += note + '\n';
    return text;
}

}    // namespace anogate
