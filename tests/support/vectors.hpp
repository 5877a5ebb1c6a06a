// The golden vectors: tests/vectors/frames.csv, columns name, hex, JSON.
#pragma once
#include <ano/hex.hpp>
#include <ano_json/frame_json.hpp>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>

namespace support {

struct Vector {
    std::string name;
    std::vector<std::uint8_t> bytes;
    ano::Json json;
};

/// Fields in quotation marks may contain commas; a quotation mark in them is doubled.
inline std::vector<std::string> split_csv_line(const std::string& line) {
    std::vector<std::string> fields(1);
    bool quoted = false;
    for (std::size_t i = 0; i < line.size(); ++i) {
        if (line[i] == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') fields.back() += line[i++];
        else if (line[i] == '"') quoted = !quoted;
        else if (line[i] == ',' && !quoted) fields.emplace_back();
        else fields.back() += line[i];
    }
    return fields;
}

inline std::vector<Vector> golden_vectors() {
    std::ifstream file{ANOGATE_SOURCE_DIR "/tests/vectors/frames.csv"};
    if (!file) throw std::runtime_error("no " ANOGATE_SOURCE_DIR "/tests/vectors/frames.csv");
    std::vector<Vector> vectors;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        const auto fields = split_csv_line(line);
        if (fields.size() != 3) throw std::runtime_error("not three columns: " + line);
        const auto bytes = ano::from_hex(fields[1]);
        if (!bytes) throw std::runtime_error("not hex: " + line);
        vectors.push_back({fields[0], *bytes, ano::Json::parse(fields[2])});
    }
    return vectors;
}

}    // namespace support
