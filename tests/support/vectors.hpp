// The golden vectors: tests/vectors/frames.csv, columns name, hex, JSON.
#pragma once
#include <ano/hex.hpp>
#include <ano_json/frame_json.hpp>
#include <support/csv_line.hpp>

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
