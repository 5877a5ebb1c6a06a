// Determines the encoding of the texts of a sender.
#pragma once
#include <ano/frame.hpp>
#include <ano_json/shown_text.hpp>

#include <string_view>

namespace ano {

/// UTF-8 until a text of the sender is not UTF-8 and may be GBK; from then on GBK.
///
/// A short text may be valid in both: 模 (C4 A3 in GBK) is ģ in UTF-8. If all letters of a text are ambiguous in this way, each a
/// character of level 1 of GB 2312, GBK is assumed, unless another text of the sender can only be UTF-8. If the text also has
/// ASCII letters ("café"), this applies only to senders that usually use GBK.
class EncodingOfSender {
public:
    /// The sender usually uses GBK: it is on a link with profile=vendor.
    void expect_gbk(bool expected) noexcept { expects_gbk_ = expected; }
    /// A received text. Its last character may be incomplete.
    void learn(std::string_view text) noexcept;
    /// All texts in `frame`.
    void learn(FrameView frame) noexcept;

    Encoding encoding() const noexcept { return is_gbk() ? Encoding::gbk : Encoding::utf8; }
    /// The same for a text that may not have been passed to learn().
    Encoding for_reading() const noexcept { return is_gbk() ? Encoding::gbk : Encoding::automatic; }
    /// One of its texts is not UTF-8, and can be GBK.
    bool has_shown_gbk() const noexcept { return has_gbk_; }

private:
    bool is_gbk() const noexcept { return has_gbk_ || (!has_utf8_ && (has_both_ || (has_both_with_ascii_ && expects_gbk_))); }

    bool expects_gbk_ = false;
    bool has_gbk_ = false;     // a text that can't be UTF-8
    bool has_utf8_ = false;    // a text that can only be UTF-8
    bool has_both_ = false, has_both_with_ascii_ = false;
};

}    // namespace ano
