// The names and texts of one device: bytes in the encoding of the device, UTF-8 for clients. The host engine (include/host) has
// the bytes; texts from and for clients are converted here.
#pragma once
#include <ano/fault.hpp>
#include <ano/frame.hpp>
#include <ano_json/encoding_of_sender.hpp>
#include <ano_json/shown_text.hpp>
#include <host/value.hpp>

#include <optional>
#include <string>
#include <string_view>

namespace anogate {

class DeviceTexts {
public:
    /// The key `encoding` of its link; std::nullopt: detected from its texts. `expects_gbk`: the link has profile=vendor.
    void configure(std::optional<ano::Encoding> given, bool expects_gbk = false) noexcept {
        given_ = given;
        expects_gbk_ = expects_gbk;
        learned_.expect_gbk(expects_gbk);
    }
    /// To be called with every frame of the device.
    void learn(ano::FrameView frame) noexcept { learned_.learn(frame); }
    void learn(std::string_view text) noexcept { learned_.learn(text); }
    /// It may be another device now.
    void forget() noexcept {
        learned_ = {};
        learned_.expect_gbk(expects_gbk_);
    }
    /// Whether the link states UTF-8, but a text of the device is not valid UTF-8 and can be GBK.
    bool contradicts() const noexcept { return given_ == ano::Encoding::utf8 && learned_.has_shown_gbk(); }

    ano::Encoding encoding() const noexcept { return given_.value_or(learned_.encoding()); }

    /// For clients. Leaves out a last character that the device has truncated.
    std::string display_text(std::string_view bytes) const {
        return ano::display_text(bytes, given_.value_or(learned_.for_reading()));
    }
    /// The same for the texts in its arguments.
    ano::Fault display_fault(const ano::Fault& fault) const {
        return fault.converted([this](std::string_view bytes) { return display_text(bytes); });
    }
    /// For the device; std::nullopt: its encoding lacks a character.
    std::optional<std::string> bytes(std::string_view text) const noexcept;
    /// The same for a value; numbers are returned unchanged.
    std::optional<ano::host::AnyValue> wire(ano::host::AnyValue value) const noexcept;
    /// Why bytes() returns std::nullopt.
    ano::Fault misfit() const;

    /// Whether `text` from a client is the name with these bytes.
    bool is(std::string_view bytes, std::string_view text) const;
    /// Whether `text` is the form of `bytes` in a file of an older version, which contains U+FFFD.
    static bool is_once_exported(std::string_view bytes, std::string_view text);

private:
    std::optional<ano::Encoding> given_;
    bool expects_gbk_ = false;
    ano::EncodingOfSender learned_;
};

}    // namespace anogate
