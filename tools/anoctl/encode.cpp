// anoctl encode NAME FIELD=VALUE...: values to a frame.
#include "anoctl.hpp"
#include "frame_printer.hpp"

#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/syntax_fault.hpp>

#include <nlohmann/json.hpp>

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>
#include <ostream>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using namespace ano;

constexpr std::size_t max_line = 1 << 20;    // several times what the largest frame needs

/// The lines of standard input, each as soon as it is whole.
class Lines {
public:
    explicit Lines(int fd) : fd_{fd} {}

    /// False: there are no more.
    bool next(std::string& line) {
        std::size_t end = 0;
        while ((end = text_.find('\n', seen_)) == std::string::npos) {
            text_.erase(0, begin_);
            begin_ = 0;
            seen_ = text_.size();
            if (seen_ > max_line) throw UsageError{"line " + std::to_string(number_ + 1) + ": longer than 1 MiB"};
            if (!read()) return last(line);
        }
        ++number_;
        line.assign(text_, begin_, end - begin_);
        begin_ = seen_ = end + 1;
        return true;
    }
    std::size_t number() const { return number_; }
    /// Whether the next line is here already.
    bool one_waits() const { return text_.find('\n', seen_) != std::string::npos; }

private:
    bool read() {
        char buffer[16384];
        ssize_t n = 0;
        do n = ::read(fd_, buffer, sizeof buffer);
        while (n < 0 && errno == EINTR);
        if (n < 0) throw Failure{std::string{"standard input: "} + std::strerror(errno)};
        text_.append(buffer, static_cast<std::size_t>(n));
        return n > 0;
    }
    bool last(std::string& line) {
        line = std::exchange(text_, {});
        seen_ = 0;
        if (!line.empty()) ++number_;
        return !line.empty();
    }

    int fd_;
    std::string text_;
    std::size_t begin_ = 0;    // of the next line
    std::size_t seen_ = 0;     // the line does not end before this
    std::size_t number_ = 0;
};

Json parsed(std::string_view text, const std::string& what) {
    try {
        return Json::parse(text);
    } catch (const nlohmann::json::exception& e) {
        throw UsageError{what + ": it is not JSON: " + ano::syntax_fault(text, e)};
    }
}

struct Encode {
    std::string name;
    std::vector<std::string> fields;
    std::string from = "254";
    std::string to = "255";
    std::optional<std::string> data;
    bool raw = false;
    FrameOptions frames;

    int run(Streams& streams) const {
        const FlexibleLayouts layouts = frames.layouts();
        const JsonOptions options = frames.json_options(layouts);
        if (name == "-") return encode_lines(streams, options);
        write(streams, encoded(frame(), options, ""));
        return fine;
    }

private:
    // What `decode --json` prints: one object a line.
    int encode_lines(Streams& streams, const JsonOptions& options) const {
        if (!fields.empty() || data) throw UsageError{"with -, frames come from standard input: no FIELD=VALUE, no --data"};
        Lines lines{streams.in};
        for (std::string line; streams.out && lines.next(line);) {
            if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
            const std::string where = "line " + std::to_string(lines.number());
            const Json json = parsed(line, where);
            if (json.is_object() && json.contains("fault")) continue;    // bytes in which `decode` found no frame
            write(streams, encoded(json, options, where + ": "));
            if (!lines.one_waits()) streams.out.flush();
        }
        return fine;
    }

    Json frame() const {
        Json json{{"from", from}, {"to", to}};
        const std::uint8_t id = message_id_of(name);
        json["id"] = id;
        if (data) json["data"] = *data;
        if (data && !fields.empty()) throw UsageError{"--data is the whole of DATA: no FIELD=VALUE beside it"};
        Json given = Json::object();
        for (const std::string& word : fields) {
            const std::size_t equals = word.find('=');
            if (equals == std::string::npos || equals == 0) throw UsageError{in_quotes(word) + " is not FIELD=VALUE"};
            const std::string field = word.substr(0, equals);
            if (given.contains(field)) throw UsageError{in_quotes(field) + " is given twice"};
            given[field] = value(id, field, word.substr(equals + 1));
        }
        if (!given.empty() || !data) json["fields"] = std::move(given);
        return json;
    }

    static Field field_called(std::uint8_t id, const std::string& name) {
        for (const Message& row : layouts_of(id))
            if (const Field* f = row.field(name)) return *f;
        return {};
    }
    // Numbers stay text: the encoder reads them as C writes them.
    static Json value(std::uint8_t id, const std::string& name, const std::string& text) {
        const Field field = field_called(id, name);
        if (field.type == Type::text || field.type == Type::bytes || field.type == Type::ip) return text;
        if (text.starts_with('[')) return parsed(text, name);
        if (is_number(field.type) && field.count == 1 && text == "null") return nullptr;
        if (!is_number(field.type) || field.count == 1) return text;
        Json list = Json::array();    // 1,4,7
        std::istringstream parts{text};
        for (std::string part; std::getline(parts, part, ',');) list.push_back(part);
        return list;
    }

    static std::vector<std::uint8_t> encoded(const Json& json, const JsonOptions& options, const std::string& where) {
        auto frame = frame_from_json(json, options);
        if (const auto* fault = std::get_if<JsonFault>(&frame)) throw UsageError{where + fault->what};
        return std::move(std::get<0>(frame));
    }
    void write(Streams& streams, const std::vector<std::uint8_t>& bytes) const {
        if (raw) {
            for (const std::uint8_t byte : bytes) streams.out.put(static_cast<char>(byte));
        } else if (frames.json) {
            streams.out << Json{{"hex", hex(bytes)}}.dump() << '\n';
        } else {
            streams.out << spaced_hex(bytes) << '\n';
        }
    }
};

}    // namespace

Run add_encode(Options& options) {
    const auto self = std::make_shared<Encode>();
    options.push_back(
        {"name", &self->name, "NAME", "The message, by name or id; - for JSON frames on standard input, one a line", true});
    options.push_back({"fields", &self->fields, "FIELD=VALUE...",
                       "Values in the unit of the field, or words: cmd=action val=save; what is left out is 0 or empty. "
                       "Typed where a device tells the types: value=f32:1.5 values=u16:100,i32:-5"});
    options.push_back({"--from", &self->from, "ADDRESS", "Who sends it (default 0xFE, the host)"});
    options.push_back({"--to", &self->to, "ADDRESS", "Who it is for (default 0xFF: everybody)"});
    options.push_back({"--data", &self->data, "HEX", "The whole of DATA in hex digits, in place of fields"});
    options.push_back({"--raw", &self->raw, "", "Bytes in place of hex digits", false, {"--json"}});
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
