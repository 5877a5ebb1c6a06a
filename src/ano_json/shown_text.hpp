// Texts of devices, whose last character may be cut off by the size of a field.
#pragma once
#include <ano_json/text.hpp>

#include <string>
#include <string_view>

namespace ano {

/// Whether `text` can be GBK; its last character may be cut off.
bool may_be_gbk(std::string_view text) noexcept;

/// `text` without a last character that is cut off. `encoding` is not `automatic`.
std::string_view without_cut_character(std::string_view text, Encoding encoding) noexcept;

/// As UTF-8, without a last character that is cut off; otherwise as to_utf8(). Does not throw.
std::string shown_text(std::string_view text, Encoding encoding);

}    // namespace ano
