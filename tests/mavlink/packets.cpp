// Packets of every message, for oracle.mjs:
//   mavlink_packets list                  the names of the table
//   mavlink_packets encode                a line "VERSION NAME field=value,value field=value" → the packet in hex
//   mavlink_packets decode                a line of hex → "VERSION SYSTEM COMPONENT SEQUENCE NAME field=value …" of each packet in it
#include <mavlink/packet_parser.hpp>

#include <ano/wire.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace {

using namespace anogate::mavlink;

void store_value(const Field& field, const std::string& text, std::uint8_t* at) {
    ano::with_type(field.type, [&]<class T>(T) {
        if constexpr (std::is_floating_point_v<T>) ano::store(at, static_cast<T>(std::strtod(text.c_str(), nullptr)));
        else if constexpr (std::is_signed_v<T>) ano::store(at, static_cast<T>(std::strtoll(text.c_str(), nullptr, 10)));
        else ano::store(at, static_cast<T>(std::strtoull(text.c_str(), nullptr, 10)));
    });
}

std::string value_text(const Field& field, const std::uint8_t* at) {
    return ano::with_type(field.type, [&]<class T>(T) -> std::string {
        const T value = ano::load<T>(at);
        if constexpr (!std::is_floating_point_v<T>) return std::to_string(value);
        std::array<char, 40> text{};
        std::snprintf(text.data(), text.size(), "%.9g", static_cast<double>(value));
        return text.data();
    });
}

void fill(const Field& field, const std::string& text, std::uint8_t* at) {
    if (field.type == ano::Type::text) {
        std::copy_n(text.begin(), std::min<std::size_t>(text.size(), field.count), at);
        return;
    }
    std::istringstream values{text};
    std::string value;
    for (std::size_t i = 0; i < field.count && std::getline(values, value, ','); ++i)
        store_value(field, value, at + i * ano::width(field.type));
}

int encode_lines() {
    for (std::string line; std::getline(std::cin, line);) {
        std::istringstream words{line};
        std::string version, name, word;
        words >> version >> name;
        const auto row = std::find_if(messages.begin(), messages.end(), [&](const Message& one) { return one.name == name; });
        if (row == messages.end()) return 1;
        std::array<std::uint8_t, max_payload> payload{};
        while (words >> word) {
            const std::size_t equals = word.find('=');
            const Field* const field = row->field(word.substr(0, equals));
            if (field == nullptr) return 1;
            fill(*field, word.substr(equals + 1), payload.data() + field->offset);
        }
        std::array<std::uint8_t, max_packet> packet{};
        const std::size_t size = encode(packet, version == "1" ? Version::v1 : Version::v2, {42, 7}, 5, *row, payload);
        for (std::size_t i = 0; i < size; ++i) std::printf("%02x", packet[i]);
        std::puts("");
    }
    return 0;
}

void print(PacketView packet) {
    const Message& row = *find_message(packet.id());
    std::array<std::uint8_t, max_payload> payload{};
    std::copy_n(packet.payload().begin(), packet.payload().size(), payload.begin());
    std::printf("%d %d %d %d %s", static_cast<int>(packet.version()), packet.system(), packet.component(), packet.sequence(),
                std::string{row.name}.c_str());
    for (const Field& field : row.fields()) {
        const std::uint8_t* const at = payload.data() + field.offset;
        std::string text;
        if (field.type == ano::Type::text) text.assign(at, std::find(at, at + field.count, std::uint8_t{0}));
        else
            for (std::size_t i = 0; i < field.count; ++i)
                text += (i == 0 ? "" : ",") + value_text(field, at + i * ano::width(field.type));
        std::printf(" %s=%s", std::string{field.name}.c_str(), text.c_str());
    }
    std::puts("");
}

int decode_lines() {
    PacketParser parser{Transport::lossy};
    for (std::string line; std::getline(std::cin, line);) {
        const auto room = parser.prepare();
        std::size_t size = 0;
        for (; 2 * size + 1 < line.size() && size < room.size(); ++size)
            room[size] = static_cast<std::uint8_t>(std::stoi(line.substr(2 * size, 2), nullptr, 16));
        parser.commit(size);
        while (const auto packet = parser.next()) print(*packet);
    }
    return parser.counters().skipped_bytes + parser.waiting() == 0 ? 0 : 1;
}

}    // namespace

int main(int argc, char** argv) {
    const std::string what = argc > 1 ? argv[1] : "";
    if (what == "encode") return encode_lines();
    if (what == "decode") return decode_lines();
    for (const Message& row : messages) std::printf("%s\n", std::string{row.name}.c_str());
    return 0;
}
