// Finds out in which encoding a sender writes its texts.
#pragma once
#include <ano/frame.hpp>
#include <ano_json/shown_text.hpp>

#include <string_view>

namespace ano {

/// UTF-8 until a text of the sender is not UTF-8 and may be GBK; then GBK.
///
/// A short text may be valid in both: 模 (C4 A3 in GBK) is ģ in UTF-8. A text whose letters are all of this sort, each a character of
/// level 1 of GB 2312, is taken for GBK unless another text of the sender can only be UTF-8. With ASCII letters beside ("café") it is that
/// only where GBK is usual.
class EncodingOfSender {
public:
    /// GBK is usual for this sender: it is behind a link of profile=vendor.
    void expect_gbk(bool expected) noexcept { expects_gbk_ = expected; }
    /// A text as received. Its last character may be cut off.
    void learn(std::string_view text) noexcept;
    /// All texts in `frame`.
    void learn(FrameView frame) noexcept;

    Encoding encoding() const noexcept { return is_gbk() ? Encoding::gbk : Encoding::utf8; }
    /// The same for a text that may not have been learned.
    Encoding for_reading() const noexcept { return is_gbk() ? Encoding::gbk : Encoding::automatic; }
    /// A text of it is no UTF-8, and can be GBK.
    bool has_shown_gbk() const noexcept { return has_gbk_; }

private:
    bool is_gbk() const noexcept { return has_gbk_ || (!has_utf8_ && (has_both_ || (has_both_with_ascii_ && expects_gbk_))); }

    bool expects_gbk_ = false;
    bool has_gbk_ = false;     // a text that can't be UTF-8
    bool has_utf8_ = false;    // a text that can be UTF-8 alone
    bool has_both_ = false, has_both_with_ascii_ = false;
};

}    // namespace ano
