// Says what is in MCAP files, as our reader has it: for each FILE, whose names stand on standard input, a line of JSON with its schemas,
// channels and messages, whoever wrote them; what it holds of frames and losses; and whether its index tells the same as all of it.
#include <record/mcap/mcap_chunk.hpp>
#include <record/mcap/mcap_index.hpp>
#include <record/mcap/mcap_records.hpp>
#include <record/recording_counts.hpp>
#include <support/files.hpp>
#include <support/recorded.hpp>

#include <nlohmann/json.hpp>

#include <fstream>
#include <iostream>
#include <string>
#include <string_view>

namespace {

namespace mcap = anogate::mcap;
using Json = nlohmann::ordered_json;
using mcap::Opcode;

template <class Text>
std::string hex_of(const Text& bytes) {
    constexpr std::string_view digits = "0123456789abcdef";
    std::string hex;
    for (const auto byte : bytes) {
        const auto value = static_cast<std::uint8_t>(byte);
        hex += digits[value >> 4];
        hex += digits[value & 15];
    }
    return hex;
}

// What records say, those of a chunk where it stands.
class Content {
public:
    Json json{{"schemas", Json::array()},
              {"channels", Json::array()},
              {"messages", Json::array()},
              {"attachments", 0},
              {"metadata", 0}};

    void process_outer(const mcap::Record& record, mcap::Records& records) {
        if (record.opcode == Opcode::data_end) is_data_over_ = true;
        if (is_data_over_) return;
        if (record.opcode == Opcode::attachment) json["attachments"] = json["attachments"].get<int>() + 1;
        if (record.opcode == Opcode::metadata) json["metadata"] = json["metadata"].get<int>() + 1;
        if (record.opcode != Opcode::chunk) return process(record);
        std::string inner;
        if (const auto fault = opener_.open(record.body, inner); fault.why != nullptr) return records.refuse(fault.why, record);
        std::string_view rest = inner;
        while (const auto one = mcap::next_record(rest)) process(*one);
    }

private:
    void process(const mcap::Record& record) {
        mcap::Fields fields{record.body};
        if (record.opcode == Opcode::schema) {
            const auto id = fields.number<std::uint16_t>();
            const std::string name{fields.text()}, encoding{fields.text()};
            json["schemas"].push_back({{"id", id}, {"name", name}, {"encoding", encoding}, {"text", hex_of(fields.text())}});
        }
        if (record.opcode == Opcode::channel) {
            const auto channel = mcap::channel_of(record.body);
            if (channel)
                json["channels"].push_back({{"id", channel->id},
                                            {"schema", channel->schema},
                                            {"topic", channel->topic},
                                            {"encoding", channel->encoding}});
        }
        const auto message = record.opcode == Opcode::message ? mcap::message_of(record.body) : std::nullopt;
        if (message)
            json["messages"].push_back({{"channel", message->channel},
                                        {"sequence", message->sequence},
                                        {"log_time", std::to_string(message->log_time)},
                                        {"publish_time", std::to_string(message->publish_time)},
                                        {"data", hex_of(message->data)}});
    }

    mcap::ChunkOpener opener_;
    bool is_data_over_ = false;
};

Json items_of(const support::ReadRecording& read) {
    Json items = Json::array();
    for (const support::KeptItem& item : read.items) {
        if (item.frame.empty()) items.push_back({{"lost", item.lost}, {"names", item.names}});
        else items.push_back({{"time", std::to_string(item.time_ns)}, {"link", item.link}, {"hex", hex_of(item.frame)}});
    }
    return items;
}

// Nothing: the index does not tell.
Json index_agrees(const std::string& file, const support::ReadRecording& read) {
    const auto index = anogate::read_mcap_index(file.size(), [&](std::uint64_t at, std::size_t size) {
        return at < file.size() ? file.substr(static_cast<std::size_t>(at), size) : std::string{};
    });
    if (!index) return nullptr;
    anogate::RecordingCounts counts;
    for (const support::KeptItem& item : read.items) {
        if (item.frame.empty()) counts.add(anogate::RecordedLoss{item.lost, item.names});
        else counts.add(support::frame_of(item));
    }
    return counts == index->counts;
}

Json content_of(const std::string& file) {
    Content content;
    mcap::Records records;
    records.feed(file);
    while (const auto record = records.next()) content.process_outer(*record, records);
    const support::ReadRecording read = support::read_recording(file);
    Json json = content.json;
    json["fault"] = records.fault() != nullptr ? records.fault() : read.fault;
    json["ended"] = records.is_ended() && read.has_end;
    json["unread"] = file.size() - read.position;
    json["foreign"] = read.foreign;
    json["items"] = items_of(read);
    json["index_agrees"] = index_agrees(file, read);
    return json;
}

}    // namespace

int main() {
    std::string path;
    while (std::getline(std::cin, path)) {
        if (!std::ifstream{path}) return std::cerr << path << " can't be read\n", 1;
        std::cout << content_of(support::file_text(path)).dump() << '\n';
    }
    return 0;
}
