// Writes JSON on one line, byte for byte as nlohmann-json does, to a text: without a tree, and without memory of its own.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace ano {

/// Commas are added automatically. Values are written in the order of the calls. The caller closes each object and array it
/// opens.
class JsonWriter {
public:
    /// Appends to `out`.
    explicit JsonWriter(std::string& out) noexcept : out_{out} {}

    void begin_object() { open('{'); }
    void end_object() { close('}'); }
    void begin_array() { open('['); }
    void end_array() { close(']'); }
    /// The key of the value that follows.
    void key(std::string_view name) {
        text(name);
        out_ += ':';
        needs_comma_ = false;
    }
    /// Adds a member with the value written by `write`; none if that is null.
    template <class Write>
    void member_unless_null(std::string_view name, Write&& write) {
        const std::size_t before = out_.size();
        const bool needs_comma = needs_comma_;
        key(name);
        const std::size_t at = out_.size();
        write();
        if (std::string_view{out_}.substr(at) != "null") return;
        out_.resize(before);
        needs_comma_ = needs_comma;
    }

    /// UTF-8; other bytes become U+FFFD.
    void text(std::string_view text);
    void text(std::string_view name, std::string_view value) {
        key(name);
        text(value);
    }
    /// null unless it is finite.
    void number(double number);
    void number(std::int64_t number);
    void number(std::uint64_t number);
    void boolean(bool value) { literal(value ? "true" : "false"); }
    void null() { literal("null"); }

private:
    void begin_value() {
        if (needs_comma_) out_ += ',';
        needs_comma_ = true;
    }
    void literal(std::string_view text) {
        begin_value();
        out_ += text;
    }
    void open(char bracket) {
        begin_value();
        out_ += bracket;
        needs_comma_ = false;
    }
    void close(char bracket) {
        out_ += bracket;
        needs_comma_ = true;
    }

    std::string& out_;
    bool needs_comma_ = false;
};

}    // namespace ano
