#include "hex_text.hpp"

#include <ano/frame.hpp>

#include <algorithm>

namespace anoctl {
namespace {

constexpr std::size_t max_held = 1 << 20;    // bytes; text before the first frame is assumed to be shorter

constexpr std::string_view mark = "\xEF\xBB\xBF";    // Windows editors write it at the beginning of a text

int digit(char c) noexcept {
    if (c >= '0' && c <= '9') return c - '0';
    if (c >= 'a' && c <= 'f') return c - 'a' + 10;
    if (c >= 'A' && c <= 'F') return c - 'A' + 10;
    return -1;
}

/// Whether `c` may be part of a text: no control character but white space. Bytes beyond ASCII may be text.
bool is_of_text(std::uint8_t c) noexcept { return (c >= ' ' && c != 0x7F) || (c >= '\t' && c <= '\r'); }

}    // namespace

bool HexText::read(std::string_view text, std::vector<std::uint8_t>& bytes) {
    for (const char c : text) {
        if (!read(c, bytes)) return false;
        if (c == '\n') ++line_;
    }
    return true;
}

bool HexText::read(char c, std::vector<std::uint8_t>& bytes) {
    if (mark_ < mark.size()) {
        if (c == mark[mark_]) return ++mark_, true;
        if (mark_ > 0) return false;
        mark_ = mark.size();    // no byte order mark
    }
    if (c == ' ' || (c >= '\t' && c <= '\r') || c == ',') return end_word(bytes);
    if ((c == 'x' || c == 'X') && digits_ == 1 && high_ == 0 && !prefixed_) {
        prefixed_ = true;
        digits_ = 0;
        high_ = -1;
        return true;
    }
    const int value = digit(c);
    if (value < 0) return false;
    ++digits_;
    if (high_ < 0) {
        high_ = value;
    } else {
        bytes.push_back(static_cast<std::uint8_t>(high_ << 4 | value));
        high_ = -1;
    }
    return true;
}

bool HexText::end_word(std::vector<std::uint8_t>& bytes) {
    const bool is_whole = high_ < 0 ? !prefixed_ || digits_ > 0 : prefixed_ && digits_ == 1;
    if (!is_whole) return false;
    if (high_ >= 0) bytes.push_back(static_cast<std::uint8_t>(high_));
    high_ = -1;
    prefixed_ = false;
    digits_ = 0;
    return true;
}

bool HexText::finish(std::vector<std::uint8_t>& bytes) {
    if (mark_ > 0 && mark_ < mark.size()) return false;
    return end_word(bytes);
}

std::optional<std::vector<std::uint8_t>> from_hex_text(std::string_view text) {
    HexText reader;
    std::vector<std::uint8_t> bytes;
    if (!reader.read(text, bytes) || !reader.finish(bytes)) return std::nullopt;
    return bytes;
}

std::span<const std::uint8_t> BytesOrText::read(std::span<const std::uint8_t> piece) {
    if (kind_ == Kind::raw) return piece;
    if (bad_line_ != 0) return {};
    if (kind_ == Kind::text) bytes_.clear();
    if (kind_ == Kind::unknown) held_.insert(held_.end(), piece.begin(), piece.end());
    const bool is_text = text_.read({reinterpret_cast<const char*>(piece.data()), piece.size()}, bytes_);
    if (kind_ == Kind::unknown) {
        const bool begins_as_frame = bytes_.size() >= ano::overhead && bytes_.front() == ano::head;
        if (!is_text && !begins_as_frame) return all_raw();
        if (!begins_as_frame && held_.size() < max_held) return {};
        kind_ = Kind::text;
        held_ = {};
    }
    if (!is_text) bad_line_ = text_.line();
    return bytes_;
}

std::span<const std::uint8_t> BytesOrText::finish() {
    if (kind_ == Kind::raw || bad_line_ != 0) return {};
    if (kind_ == Kind::text) bytes_.clear();
    const bool is_whole = text_.finish(bytes_);
    if (kind_ == Kind::unknown && (!is_whole || bytes_.empty())) return all_raw();
    if (!is_whole) bad_line_ = text_.line();
    return bytes_;
}

std::span<const std::uint8_t> BytesOrText::all_raw() {
    kind_ = Kind::raw;
    if (!held_.empty() && held_.front() != ano::head && std::all_of(held_.begin(), held_.end(), is_of_text))
        raw_line_ = text_.line();
    return held_;
}

}    // namespace anoctl
