#include <ano/wire.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/typed_values.hpp>
#include <ano_json/words.hpp>

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <span>

namespace ano {
namespace {

constexpr std::size_t max_values = 8;    // command_info contains this number of types
constexpr std::array<std::string_view, 11> type_words{"u8",  "i8",  "u16", "i16", "u32",   "i32",
                                                      "u64", "i64", "f32", "f64", "string"};
constexpr std::size_t string_word = 10;

class Reader {
public:
    Reader(Role role, Encoding encoding) : role_{role}, encoding_{encoding} {}

    /// Returns the error; empty: none.
    std::string read(std::string_view text) {
        if (role_ == Role::value && text.starts_with("string:")) return read_string(text.substr(7));
        while (true) {
            const std::size_t comma = text.find(',');
            if (std::string wrong = read_number(text.substr(0, comma)); !wrong.empty()) return wrong;
            if (comma == text.npos) break;
            text.remove_prefix(comma + 1);
        }
        if (role_ == Role::value && values_.types.size() > 1)
            return "a parameter has one value, not " + std::to_string(values_.types.size());
        if (values_.types.size() > max_values)
            return "a command has " + std::to_string(max_values) + " values at most, not " + std::to_string(values_.types.size());
        return {};
    }
    TypedValues result() { return std::move(values_); }

private:
    std::string read_string(std::string_view text) {
        const auto encoded = from_utf8(text, encoding_);
        if (!encoded) return in_quotes(text) + " can't be written in " + (encoding_ == Encoding::gbk ? "GBK" : "UTF-8");
        values_.bytes.assign(encoded->begin(), encoded->end());
        values_.types.push_back(Type::text);
        return {};
    }
    std::string read_number(std::string_view text) {
        const std::size_t colon = text.find(':');
        if (colon == text.npos) return in_quotes(text) + " has no type, such as in u16:100";
        const std::string_view word = text.substr(0, colon);
        const std::span<const std::string_view> known{type_words.data(), role_ == Role::value ? type_words.size() : string_word};
        const auto it = std::find(known.begin(), known.end(), word);
        if (it == known.end()) return "there is no type " + in_quotes(word) + did_you_mean(word, known) + all_of(known);
        const std::string_view digits = text.substr(colon + 1);
        const auto number = parse_number(digits);
        if (!number) return in_quotes(digits) + " is not a number";
        Field f;
        f.type = static_cast<Type>(std::distance(known.begin(), it));
        std::array<std::uint8_t, 8> room{};
        switch (store_number(f, *number, room.data())) {
        case Stored::ok: break;
        case Stored::not_whole: return in_quotes(digits) + " is not a whole number (" + carried(f) + ")";
        case Stored::out_of_range: return in_quotes(digits) + " is out of range (" + carried(f) + ")";
        }
        values_.bytes.insert(values_.bytes.end(), room.data(), room.data() + width(f.type));
        values_.types.push_back(f.type);
        return {};
    }
    static std::string all_of(std::span<const std::string_view> known) {
        std::string all = "; the types are";
        for (const std::string_view word : known) all.append(word == known.front() ? " " : ", ").append(word);
        return all;
    }

    Role role_;
    Encoding encoding_;
    TypedValues values_;
};

}    // namespace

std::variant<TypedValues, std::string> typed_values(std::string_view text, Role role, Encoding encoding) {
    Reader reader{role, encoding};
    if (std::string wrong = reader.read(text); !wrong.empty()) return wrong;
    return reader.result();
}

}    // namespace ano
