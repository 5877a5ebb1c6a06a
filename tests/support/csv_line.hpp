// The fields of a line of CSV.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

namespace support {

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

}    // namespace support
