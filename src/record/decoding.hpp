// What is needed besides the frames to decode them: the layouts of flexible messages, the links whose devices send Euler angles
// with other signs, and the links with a configured encoding of texts. Every recording contains it.
#pragma once
#include <ano/attitude.hpp>
#include <ano/flexible.hpp>

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

struct Settings;

/// The encoding of the texts that the devices of a link send, if it is not detected from the texts alone.
enum class LinkTexts : std::uint8_t {
    utf8,
    gbk,
    expect_gbk,    // detected, but GBK is likely: profile=vendor
};

/// Immutable, so threads may share it.
class Decoding {
public:
    Decoding() = default;
    /// `lx`: the links of EulerSigns::lx.
    explicit Decoding(std::vector<ano::FlexibleSpec> flexible, std::set<std::string, std::less<>> lx = {},
                      std::map<std::string, LinkTexts, std::less<>> texts = {})
        : flexible_{std::move(flexible)}, layouts_{flexible_}, lx_{std::move(lx)}, texts_{std::move(texts)} {}

    const std::vector<ano::FlexibleSpec>& flexible() const noexcept { return flexible_; }
    const ano::FlexibleLayouts& layouts() const noexcept { return layouts_; }
    const std::set<std::string, std::less<>>& lx() const noexcept { return lx_; }
    ano::EulerSigns attitude(std::string_view link) const {
        return lx_.contains(link) ? ano::EulerSigns::lx : ano::EulerSigns::document;
    }
    /// The configured encoding of the texts of `link`; std::nullopt: it is detected from the texts.
    std::optional<LinkTexts> texts(std::string_view link) const {
        const auto found = texts_.find(link);
        return found == texts_.end() ? std::nullopt : std::optional{found->second};
    }
    const std::map<std::string, LinkTexts, std::less<>>& texts() const noexcept { return texts_; }
    /// Nothing differs from the message table and the protocol text.
    bool is_usual() const noexcept { return flexible_.empty() && lx_.empty() && texts_.empty(); }

    /// As JSON, in one line: {"flexible": [...], "attitude": {"fc": "lx"}, "encoding": {"fc": "gbk"}}
    std::string text() const;
    /// nullptr: `text` was not made by text().
    static std::shared_ptr<const Decoding> parse(std::string_view text);

    friend bool operator==(const Decoding& a, const Decoding& b) {
        return a.flexible_ == b.flexible_ && a.lx_ == b.lx_ && a.texts_ == b.texts_;
    }

private:
    std::vector<ano::FlexibleSpec> flexible_;
    ano::FlexibleLayouts layouts_;
    std::set<std::string, std::less<>> lx_;
    std::map<std::string, LinkTexts, std::less<>> texts_;
};

/// nullptr means the same as a Decoding that is_usual().
using DecodingPtr = std::shared_ptr<const Decoding>;
bool decode_alike(const DecodingPtr& a, const DecodingPtr& b);

/// The decoding of a configuration. `flexible`: the layouts to use instead of those in `settings`.
DecodingPtr decoding_of(const Settings& settings, std::vector<ano::FlexibleSpec> flexible);

}    // namespace anogate
