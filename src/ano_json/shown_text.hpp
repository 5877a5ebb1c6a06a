// Texts of devices, whose last character may be truncated by the size of a field.
#pragma once
#include <ano_json/text.hpp>

#include <string>
#include <string_view>

namespace ano {

/// Whether `text` can be GBK; its last character may be incomplete.
bool may_be_gbk(std::string_view text) noexcept;

/// `text` without an incomplete last character. `encoding` must not be `automatic`.
std::string_view without_cut_character(std::string_view text, Encoding encoding) noexcept;

/// `text` as UTF-8, without an incomplete last character; otherwise like to_utf8(). Does not throw.
std::string display_text(std::string_view text, Encoding encoding);

}    // namespace ano
