// The vectors of V7: tests/vectors/v7.csv, columns kind, V7 bytes, V8 bytes of a pair, meaning.
#pragma once
#include <support/bytes.hpp>
#include <support/csv_line.hpp>

#include <ano/v7.hpp>

#include <fstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace support {

struct V7Vector {
    Bytes v7;
    Bytes v8;    // only of a pair
    std::string meaning;
};

/// The vectors of `kind`: valid, pair (V7 and its translation), bad (bytes without a valid frame).
inline std::vector<V7Vector> v7_vectors(std::string_view kind) {
    std::ifstream file{ANOGATE_SOURCE_DIR "/tests/vectors/v7.csv"};
    if (!file) throw std::runtime_error("no " ANOGATE_SOURCE_DIR "/tests/vectors/v7.csv");
    std::vector<V7Vector> vectors;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        const auto fields = split_csv_line(line);
        if (fields.size() != 4) throw std::runtime_error("not four columns: " + line);
        if (fields[0] == kind) vectors.push_back({hex(fields[1]), hex(fields[2]), fields[3]});
    }
    return vectors;
}

inline Bytes v7_frame(std::uint8_t destination, std::uint8_t id, const Bytes& data = {}) {
    Bytes bytes(ano::v7::overhead + data.size());
    bytes.resize(ano::v7::encode(bytes, destination, id, data));
    return bytes;
}

}    // namespace support
