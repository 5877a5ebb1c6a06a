// One-time codes: a browser signs in with one instead of a token.
#pragma once
#include <ano/time.hpp>
#include <http/doors/door.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// Of each form at most one code is valid: for five minutes, for one use, and until another one is made. Three wrong tries void the digits,
/// whichever clients they came from; login() tries none from a client that is slowed down. Wrong codes of links void nothing: these are
/// too long to be guessed.
class SignInCodes {
public:
    enum class Form : std::uint8_t {
        link,      // 32 hex digits, in a link
        digits,    // six decimal digits, typed by a person
    };
    enum class State : std::uint8_t { none, valid, used, expired, voided };

    /// Whether a text is six digits. A token is never so short.
    static bool is_digits(std::string_view code);

    /// std::nullopt: the system has no random numbers.
    std::optional<std::string> make(Form form, http::Access access, ano::TimePoint now);

    struct Use {
        std::optional<http::Access> access{};    // what the code allows; empty: it is not valid
        bool voids = false;                      // this wrong one was the third
    };
    Use use(std::string_view code, ano::TimePoint now);

    State state(Form form, ano::TimePoint now) const;

    static constexpr ano::Duration lifetime = std::chrono::minutes{5};
    static constexpr unsigned max_wrong = 3;

private:
    struct Code {
        State state = State::none;
        std::string text{};
        http::Access access = http::Access::view;
        ano::TimePoint made_at{};
        unsigned wrong = 0;
    };
    std::array<Code, 2> codes_{};    // by Form
};

/// "none", "valid", "used", "expired", "void"
std::string_view text(SignInCodes::State state) noexcept;

}    // namespace anogate
