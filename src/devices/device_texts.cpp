#include <devices/device_texts.hpp>

#include <stdexcept>
#include <utility>
#include <variant>

namespace anogate {
namespace {

constexpr std::string_view replacement = "\xEF\xBF\xBD";    // U+FFFD

}    // namespace

std::optional<std::string> DeviceTexts::bytes(std::string_view text) const noexcept {
    try {
        return ano::from_utf8(text, encoding());
    } catch (const std::runtime_error&) {    // this system can't convert GBK
        return std::nullopt;
    }
}

std::optional<ano::host::AnyValue> DeviceTexts::wire(ano::host::AnyValue value) const noexcept {
    const auto* const text = std::get_if<std::string>(&value);
    if (text == nullptr) return value;
    auto converted = bytes(*text);
    if (!converted) return std::nullopt;
    return ano::host::AnyValue{*std::move(converted)};
}

ano::Fault DeviceTexts::misfit() const { return {"not_encodable", encoding() == ano::Encoding::gbk ? "GBK" : "UTF-8"}; }

bool DeviceTexts::is(std::string_view bytes, std::string_view text) const {
    return bytes == text || display_text(bytes) == text || is_once_exported(bytes, text);
}

bool DeviceTexts::is_once_exported(std::string_view bytes, std::string_view text) {
    if (text.find(replacement) == std::string_view::npos) return false;
    return ano::to_utf8({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, ano::Encoding::utf8) == text;
}

}    // namespace anogate
