// Formats the raw bytes of a link as lines for people: text or hex digits, with time and direction.
#pragma once
#include <ano/time.hpp>
#include <ano_json/text.hpp>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

/// `text` (UTF-8) without effects on a terminal: control characters, invisible characters and those that change the direction of
/// text are written as \x1B or \u{202E}.
std::string harmless(std::string_view text);

class RawText {
public:
    struct Options {
        bool hex = false;
        ano::Encoding encoding = ano::Encoding::utf8;
    };
    static constexpr std::size_t max_line = 1000;    // in bytes; longer lines are broken
    /// A line without a line end, such as a prompt, is shown after this time.
    static constexpr ano::Duration patience = std::chrono::milliseconds{200};

    explicit RawText(const Options& options) : options_{options} {}

    /// Adds bytes that passed at `time` (seconds since 1970): '<' received, '>' sent. Returns the complete lines.
    std::vector<std::string> add(char direction, double time, std::string_view bytes, ano::TimePoint now);
    /// When expire() will return an unfinished line; std::nullopt: there is none.
    std::optional<ano::TimePoint> due() const noexcept;
    std::vector<std::string> expire(ano::TimePoint now);

private:
    struct Line {
        std::string bytes{};
        double time = 0;
        ano::TimePoint since{};       // time of its newest byte
        bool after_return = false;    // a following line feed belongs to the previous line
    };
    void add_hex(char direction, double time, std::string_view bytes, std::vector<std::string>& lines) const;
    std::string format_line(char direction, const Line& line) const;

    Options options_;
    std::array<Line, 2> lines_;    // received, sent
};

}    // namespace anoctl
