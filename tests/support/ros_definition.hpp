// Reads a definition in the format `ros2msg` as strictly as ROS 2 does, and decodes data only by it.
#pragma once
#include <ano_json/frame_json.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace support {

struct RosDefinition {
    struct Field {
        std::string type;    // "float64", "geometry_msgs/Vector3"
        std::string name;
        bool is_array = false;
        std::size_t count = 0;    // elements of an array; 0: a sequence
    };
    std::map<std::string, std::vector<Field>> types;    // "" is the message itself
    std::map<std::string, std::int64_t> constants;      // of the message itself

    static bool is_primitive(const std::string& type) {
        static const std::set<std::string> all{"bool",  "int8",   "uint8",   "int16",   "uint16", "int32", "uint32",
                                               "int64", "uint64", "float32", "float64", "string", "byte"};
        return all.contains(type);
    }

    /// Throws std::runtime_error with the line that is wrong.
    explicit RosDefinition(const std::string& text) {
        static const std::regex part{"MSG: ([a-z][a-z0-9_]*/[A-Z][A-Za-z0-9]*)"};
        static const std::regex constant{"(u?int(?:8|16|32|64)) ([A-Z](?:_?[A-Z0-9]+)*)=(-?[0-9]+)"};
        static const std::regex field{"([a-z][a-z0-9_]*(?:/[A-Z][A-Za-z0-9]*)?)(\\[([1-9][0-9]*)?\\])? ([a-z](?:_?[a-z0-9]+)*)"};
        std::istringstream lines{text};
        std::string line, in;
        std::set<std::string> names;
        types[in];
        while (std::getline(lines, line)) {
            const auto wrong = [&](const char* what) { return std::runtime_error{std::string{what} + ": " + line}; };
            std::string code = line.substr(0, line.find('#'));
            code.erase(code.find_last_not_of(' ') + 1);
            std::smatch found;
            if (code.empty()) continue;
            if (code == std::string(80, '=')) {
                if (!std::getline(lines, line) || !std::regex_match(line, found, part)) throw wrong("no message");
                in = found[1];
                if (!types.try_emplace(in).second) throw wrong("defined twice");
                names.clear();
            } else if (std::regex_match(code, found, constant)) {
                if (!names.insert(found[2]).second) throw wrong("named twice");
                if (in.empty()) constants[found[2]] = std::stoll(found[3]);
            } else if (std::regex_match(code, found, field)) {
                if (!names.insert(found[4]).second) throw wrong("named twice");
                types[in].push_back({found[1], found[4], found[2].matched, found[3].matched ? std::stoul(found[3]) : 0});
            } else {
                throw wrong("not understood");
            }
        }
        check();
    }

    /// `reader` has number<T>(), text(), and length() for the length of a sequence.
    template <class Reader>
    ano::Json decode(Reader& reader, const std::string& type = "") const {
        ano::Json json = ano::Json::object();
        for (const Field& f : types.at(type)) {
            if (!f.is_array) {
                json[f.name] = decode_one(reader, f.type);
                continue;
            }
            ano::Json list = ano::Json::array();
            for (std::size_t n = f.count != 0 ? f.count : reader.length(); n > 0; --n) list.push_back(decode_one(reader, f.type));
            json[f.name] = std::move(list);
        }
        return json;
    }

private:
    // Checks that every named message is defined, every other defined one is named, and none contains itself.
    void check() const {
        std::set<std::string> named{""};
        std::vector<std::string> todo{""};
        while (!todo.empty()) {
            const std::string type = todo.back();
            todo.pop_back();
            if (types.at(type).empty()) throw std::runtime_error{"no field: " + type};
            for (const Field& f : types.at(type)) {
                if (is_primitive(f.type)) continue;
                if (!types.contains(f.type)) throw std::runtime_error{"not defined: " + f.type};
                if (named.insert(f.type).second) todo.push_back(f.type);
            }
        }
        if (named.size() != types.size()) throw std::runtime_error{"defined for nothing"};
    }

    template <class Reader>
    ano::Json decode_one(Reader& reader, const std::string& type) const {
        const auto real = [](double value) -> ano::Json { return std::isnan(value) ? ano::Json{} : ano::Json(value); };
        if (type == "bool") return reader.template number<std::uint8_t>() != 0;
        if (type == "int8") return reader.template number<std::int8_t>();
        if (type == "uint8" || type == "byte") return reader.template number<std::uint8_t>();
        if (type == "int16") return reader.template number<std::int16_t>();
        if (type == "uint16") return reader.template number<std::uint16_t>();
        if (type == "int32") return reader.template number<std::int32_t>();
        if (type == "uint32") return reader.template number<std::uint32_t>();
        if (type == "int64") return reader.template number<std::int64_t>();
        if (type == "uint64") return reader.template number<std::uint64_t>();
        if (type == "float32") {
            const float value = reader.template number<float>();
            return std::isfinite(value) ? ano::Json(ano::widened(value)) : real(double{value});
        }
        if (type == "float64") return real(reader.template number<double>());
        if (type == "string") return reader.text();
        return decode(reader, type);
    }
};

/// Reads plain CDR, little-endian, after its head; throws if the data end too early.
class CdrReader {
public:
    explicit CdrReader(std::string_view data) : data_{data} {
        if (!data_.starts_with(std::string_view{"\0\1\0\0", 4})) throw std::runtime_error{"no head of little-endian CDR"};
        data_.remove_prefix(4);
    }
    template <class T>
    T number() {
        at_ = (at_ + sizeof(T) - 1) / sizeof(T) * sizeof(T);
        return ano::load<T>(reinterpret_cast<const std::uint8_t*>(take(sizeof(T)).data()));
    }
    std::string text() {
        const std::string_view text = take(length());
        if (text.empty() || text.back() != '\0') throw std::runtime_error{"a text without NUL"};
        return std::string{text.substr(0, text.size() - 1)};
    }
    std::size_t length() { return number<std::uint32_t>(); }
    bool is_at_end() const noexcept { return at_ == data_.size(); }

private:
    std::string_view take(std::size_t n) {
        if (at_ > data_.size() || data_.size() - at_ < n) throw std::runtime_error{"it ends too early"};
        at_ += n;
        return data_.substr(at_ - n, n);
    }

    std::string_view data_;
    std::size_t at_ = 0;
};

/// Throws if bytes are left.
inline ano::Json decoded_cdr(const std::string& definition, std::string_view data) {
    CdrReader reader{data};
    ano::Json json = RosDefinition{definition}.decode(reader);
    if (!reader.is_at_end()) throw std::runtime_error{"it ends too late"};
    return json;
}

}    // namespace support
