#include "frame_printer.hpp"

#include <anoctl/json_file.hpp>
#include "table.hpp"

#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/flexible_json.hpp>
#include <ano_json/syntax_fault.hpp>
#include <ano_json/v7_json.hpp>
#include <ano_json/words.hpp>
#include <gateway/frame_record.hpp>
#include <sys/files/read_file.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <ctime>
#include <ostream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace anoctl {
namespace {

using namespace ano;

constexpr const char* bold = "\x1b[1m";
constexpr const char* dim = "\x1b[2m";
constexpr const char* red = "\x1b[31m";
constexpr const char* cyan = "\x1b[36m";

std::string padded(std::string text, std::size_t columns) {
    std::size_t characters = 0;
    for (const char c : text) characters += (static_cast<unsigned char>(c) & 0xC0) != 0x80;
    if (characters < columns) text.append(columns - characters, ' ');
    return text;
}

std::string format_value(const Json& value) {
    if (value.is_string()) return in_quotes(value.get_ref<const std::string&>(), '"');
    if (value.is_number_float()) return number_text(value.get<double>());
    return value.dump(-1, ' ', true);
}

// Converts ids and addresses to hex, including those of frames contained in this one.
Json with_hex(const Json& value, const Field& field) {
    const auto hexed = [](const Json& byte) { return Json(hex_byte(byte.get<std::uint8_t>())); };
    if (field.role == Role::code && value.is_number_integer()) return hexed(value);
    if (field.type != Type::frames || !value.is_array()) return value;
    Json frames = value;
    for (Json& frame : frames) {
        const Message* message = find_message(frame["id"].get<std::uint8_t>());
        for (const char* key : {"from", "to", "id"}) frame[key] = hexed(frame[key]);
        if (message == nullptr || !frame.contains("fields")) continue;
        for (const auto& [name, inner] : frame["fields"].items())
            if (const Field* f = message->field(name)) inner = with_hex(inner, *f);
    }
    return frames;
}

// As text, without the quotation marks of bytes, addresses and codes.
std::string format_value(const Json& given, const Field* field) {
    const Json value = field != nullptr ? with_hex(given, *field) : given;
    if (field != nullptr && field->role == Role::code && value.is_string()) return value.get<std::string>();
    const bool bare = field != nullptr && (field->type == Type::bytes || field->type == Type::ip) && value.is_string();
    return bare && !value.get_ref<const std::string&>().empty() ? value.get<std::string>() : format_value(value);
}

const Field* field_of(const Reading& reading, const std::string& name) { return reading.field(name); }

// " (airborne)", or empty. For the types of the values of a command: only the types in use.
std::string meaning_of(const Json& value, const Field& field, ValueType7 seven) {
    std::string words;
    const auto add = [&](const Json& number) {
        if (!number.is_number_integer() || number.get<std::int64_t>() < 0) return;
        const std::string_view word = word_of(field, number.get<std::uint64_t>(), seven);
        if (!word.empty()) words.append(words.empty() ? "" : ", ").append(word);
    };
    if (field.role == Role::value_types && value.is_array()) {
        for (const Json& number : value)
            if (number != 0) add(number);
    } else {
        add(value);
    }
    return words.empty() ? words : " (" + words + ")";
}

// Empty: the frame has a layout, or its message has none at all.
std::string unknown_layout(const Reading& reading) {
    const bool has_layouts = reading.message() != nullptr && !reading.message()->fields().empty();
    if (reading.readable() != Readable::unknown_layout || !has_layouts) return {};
    return "unknown layout, LEN " + std::to_string(reading.data().size());
}

std::string with_blank(const std::string& text) { return text.empty() ? text : " " + text; }

}    // namespace

void FrameOptions::add_encoding(Options& options, FrameOptions& self) {
    const auto read_encoding = [&self](const std::string& word) -> std::string {
        std::string name = word;
        std::transform(name.begin(), name.end(), name.begin(),
                       [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
        if (name != "utf8" && name != "gbk") return in_quotes(word) + " is neither utf8 nor gbk";
        self.encoding = name == "gbk" ? Encoding::gbk : Encoding::utf8;
        return {};
    };
    options.push_back({"--encoding", Option::Read{read_encoding}, "utf8|gbk",
                       "Text encoding in frames (default: UTF-8; received text that is not valid UTF-8 is read as GBK)"});
}

void FrameOptions::add(Options& options, FrameOptions& self) {
    const auto read_value_type = [&self](const std::string& word) -> std::string {
        if (word != "f32" && word != "u64") return in_quotes(word) + " is neither f32 nor u64";
        self.value_type_7 = word == "u64" ? ValueType7::u64 : ValueType7::f32;
        return {};
    };
    options.push_back({"--json", &self.json, "", "Print one JSON object per line"});
    add_encoding(options, self);
    options.push_back({"--value-type-7", Option::Read{read_value_type}, "f32|u64",
                       "Meaning of value type 7 in commands: f32 (default), or u64 as on current devices"});
    options.push_back({"--config", &self.config, "FILE", "Gateway configuration with the layouts of flexible messages"});
}

std::string FrameOptions::config_text() const {
    std::error_code error;
    std::string text = anogate::read_file(config, anogate::max_config_size, error);
    if (error == std::errc::operation_not_supported)
        throw UsageError{"--config " + config + ": not a regular file, but a pipe, socket or device"};
    if (error) throw UsageError{"--config " + config + ": cannot read: " + error.message()};
    return text;
}

std::vector<FlexibleSpec> FrameOptions::specs() const {
    if (config.empty()) return known;
    const nlohmann::json whole = json_with_comments(config_text(), "--config " + config);
    if (!whole.is_object()) throw UsageError{"--config " + config + ": not a JSON object"};
    std::vector<FlexibleSpec> specs;
    if (!whole.contains("flexible")) return specs;
    for (const JsonFault& fault : read_flexible(whole["flexible"], "/flexible", specs))
        throw UsageError{"--config " + config + ": " + fault.pointer + ": " + fault.what};
    return specs;
}

FramePrinter::FramePrinter(Streams& streams, const FrameOptions& options)
    : streams_{streams},
      json_{options.json},
      layouts_{options.layouts()},
      options_{options.json_options(layouts_)},
      finds_encoding_{!options.encoding},
      finds_layouts_{options.config.empty()} {}

void FramePrinter::use(const anogate::DecodingPtr& decoding) {
    decoding_ = decoding;
    if (finds_layouts_) options_.flexible = &decoding->layouts();
}

namespace {

void add(const Passage& passage, Json& json) {
    if (passage.link.empty()) return;
    json["time"] = passage.time;
    json["link"] = passage.link;
    for (const auto& [key, text] :
         {std::pair{"peer", &passage.peer}, {"direction", &passage.direction}, {"cause", &passage.cause}})
        if (!text->empty()) json[key] = *text;
    if (passage.is_elsewhere) json["elsewhere"] = true;
}

}    // namespace

void FramePrinter::print(FrameView frame, const Passage& passage) {
    if (finds_encoding_)
        options_.encoding = encodings_.of(frame, passage.link, passage.direction == text(anogate::Direction::in),
                                          decoding_.get());
    Json json = frame_to_json(frame, options_);
    if (json_) {
        add(passage, json);
        streams_.out << ano::json_text(json) << '\n';
        return;
    }
    const Reading reading = read(frame, &layouts());
    if (!streams_.terminal) {
        if (!passage.link.empty()) print(passage, streams_.out);
        streams_.out << hex_byte(frame.source()) << ' ' << hex_byte(frame.destination()) << ' ';
        return plain(reading, json, !passage.link.empty());
    }
    std::ostringstream line;
    if (!passage.link.empty()) print(passage, line);
    const auto who = [](std::uint8_t a) { return padded(hex_byte(a) + " " + std::string{address::who(a)}, 22); };
    line << who(frame.source()) << " → " << who(frame.destination()) << ' ';
    columns(reading, json, line);
    // Live frames take one line each; a frame given on the command line is shown completely.
    streams_.out << (passage.link.empty() ? line.str() : cut_line(line.str(), streams_.width)) << '\n';
}

void FramePrinter::print(v7::FrameView frame, const Passage& passage) {
    Json json = v7_frame_to_json(frame, options_);
    if (json_) {
        add(passage, json);
        streams_.out << ano::json_text(json) << '\n';
        return;
    }
    const Reading reading = v7::read(frame, &layouts());
    if (!passage.link.empty()) print(passage, streams_.out);
    if (!streams_.terminal) {
        streams_.out << hex_byte(frame.destination()) << ' ';
        return plain(reading, json, false);
    }
    const std::string who = hex_byte(frame.destination()) + " " + std::string{v7::address::who(frame.destination())};
    streams_.out << "→ " << padded(who, 22) << ' ';
    columns(reading, json, streams_.out);
    streams_.out << '\n';
}

// 14:03:07.123 ground 192.168.1.20:6000 dropped limited; with "elsewhere" if the source has its route on another link.
void FramePrinter::print(const Passage& passage, std::ostream& out) const {
    out << colored(dim, clock_text(passage.time)) << ' ' << passage.link << ' ';
    if (!passage.peer.empty() && passage.peer != passage.link) out << passage.peer << ' ';
    if (!passage.cause.empty()) out << colored(red, passage.direction + ' ' + passage.cause) << ' ';
    else if (!passage.direction.empty()) out << passage.direction << ' ';
    if (passage.is_elsewhere) out << colored(red, "elsewhere") << ' ';
}

// 0xDC 0xFE 0x03 euler rol=1.23 pit=0 yaw=0 fusion_sta=1: `encode` accepts the part after the id. For a live frame shown as
// bytes, the reason is added.
void FramePrinter::plain(const Reading& reading, const Json& json, bool passes) {
    streams_.out << hex_byte(json["id"].get<std::uint8_t>()) << ' ' << json.value("name", "-");
    if (json.contains("fields"))
        for (const auto& [name, value] : json["fields"].items())
            streams_.out << ' ' << name << '=' << format_value(value, field_of(reading, name));
    if (passes) streams_.out << with_blank(unknown_layout(reading));
    for (const char* key : {"extra", "data"})
        if (json.contains(key)) streams_.out << ' ' << key << '=' << format_value(json[key]);
    streams_.out << '\n';
}

void FramePrinter::columns(const Reading& reading, const Json& json, std::ostream& out) const {
    out << colored(dim, hex_byte(json["id"].get<std::uint8_t>())) << ' ' << colored(cyan, padded(json.value("name", "-"), 18));
    if (json.contains("fields")) {
        for (const auto& [name, value] : json["fields"].items()) {
            const Field* f = field_of(reading, name);
            std::string text = format_value(value, f);
            if (f != nullptr && !value.is_null() && !f->unit.empty()) text.append(" ").append(f->unit);
            if (f != nullptr) text += meaning_of(value, *f, options_.value_type_7);
            const std::size_t room = f != nullptr && is_number(f->type) ? 9 : 0;
            const std::string of = f != nullptr && !f->label.empty() ? " (" + std::string{f->label} + ")" : "";
            out << ' ' << colored(dim, name + of) << ' ' << colored(bold, padded(text, room));
        }
    }
    const std::string unknown = unknown_layout(reading), wrong = unknown.empty() ? undecoded(reading) : "";
    if (!unknown.empty()) out << ' ' << colored(red, unknown);
    for (const char* key : {"extra", "data"})
        if (json.contains(key)) out << ' ' << colored(dim, key) << ' ' << json[key].get<std::string>();
    if (!wrong.empty()) out << ' ' << colored(red, wrong);
}

std::string FramePrinter::colored(const char* color, const std::string& text) const {
    return streams_.color ? color + text + "\x1b[0m" : text;
}

std::string clock_text(double time) {
    const auto seconds = static_cast<std::time_t>(time);
    std::tm local{};
    localtime_r(&seconds, &local);
    std::array<char, 40> text{};
    std::snprintf(text.data(), text.size(), "%02d:%02d:%02d.%03d", local.tm_hour, local.tm_min, local.tm_sec,
                  static_cast<int>((time - static_cast<double>(seconds)) * 1000));
    return text.data();
}

std::string undecoded(const Reading& reading) {
    const std::string size = std::to_string(reading.data().size());
    if (!unknown_layout(reading).empty()) return "unknown layout of " + std::string{reading.message()->name} + ", LEN " + size;
    if (reading.readable() != Readable::too_short) return {};
    return "malformed " + std::string{reading.message()->name} + ": " + size + " bytes of data, expected at least " +
           std::to_string(reading.fixed_size());
}

}    // namespace anoctl
