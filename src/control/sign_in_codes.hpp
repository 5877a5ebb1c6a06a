// One-time codes for signing in without a token.
#pragma once
#include <ano/time.hpp>
#include <http/listeners/connection_info.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

/// At most one code of each form is valid: for five minutes, for one use, and until another one is made. Three wrong tries void
/// the digits, from whatever clients; login() does not try the code of a client that is slowed down. Wrong codes of links void
/// nothing, because these are too long to be guessed.
class SignInCodes {
public:
    enum class Form : std::uint8_t {
        link,      // 32 hex digits, in a link
        digits,    // six decimal digits, typed by a person
    };
    enum class State : std::uint8_t { none, valid, used, expired, voided };

    /// Whether a text is six digits. Tokens are longer.
    static bool is_digits(std::string_view code);

    /// std::nullopt: no random numbers are available.
    std::optional<std::string> make(Form form, http::Access access, ano::TimePoint now);

    struct Use {
        std::optional<http::Access> access{};    // the rights of the code; empty: it is not valid
        bool voids = false;                      // this was the third wrong try
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
