// The vectors of the older protocol V7: tests/vectors/v7.txt. Its first lines and the note "protocol-v7", section 9, describe it.
#pragma once
#include <ano/v7.hpp>
#include <support/bytes.hpp>

#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace support {

inline Bytes v7_frame(std::uint8_t destination, std::uint8_t id, const Bytes& data = {}) {
    Bytes bytes(ano::v7::overhead + data.size());
    bytes.resize(ano::v7::encode(bytes, destination, id, data));
    return bytes;
}

struct V7Vectors {
    struct Valid {
        int number;
        Bytes frame;
        std::string meaning;
    };
    struct Pair {
        Bytes v7, v8;
        std::string meaning;
    };
    struct Bad {
        Bytes bytes;
        std::string meaning;
    };
    std::vector<Valid> valid;
    std::vector<Pair> pairs;
    std::vector<Bad> bad;

    const Bytes& frame(int number) const {
        for (const Valid& row : valid)
            if (row.number == number) return row.frame;
        throw std::out_of_range{"no valid vector of this number"};
    }
};

inline V7Vectors v7_vectors() {
    std::ifstream file{ANOGATE_SOURCE_DIR "/tests/vectors/v7.txt"};
    if (!file) throw std::runtime_error{"no tests/vectors/v7.txt"};
    V7Vectors vectors;
    for (std::string line; std::getline(file, line);) {
        std::istringstream words{line};
        std::string kind, origin, one, other, meaning;
        int number = 0;
        words >> kind;
        if (kind == "valid") {
            words >> number >> origin >> one;
            std::getline(words >> std::ws, meaning);
            vectors.valid.push_back({number, hex(one), meaning});
        } else if (kind == "pair") {
            words >> one >> other;
            std::getline(words >> std::ws, meaning);
            vectors.pairs.push_back({hex(one), hex(other), meaning});
        } else if (kind == "bad") {
            words >> one;
            std::getline(words >> std::ws, meaning);
            vectors.bad.push_back({hex(one), meaning});
        }
    }
    return vectors;
}

}    // namespace support
