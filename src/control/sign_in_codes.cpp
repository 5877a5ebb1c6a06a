#include <control/sign_in_codes.hpp>
#include <http/listeners/same_token.hpp>
#include <sys/random.hpp>

#include <utility>

namespace anogate {
namespace {

constexpr std::size_t link_bytes = 16, digit_count = 6;

std::size_t place_of(SignInCodes::Form form) { return static_cast<std::size_t>(form); }

}    // namespace

bool SignInCodes::is_digits(std::string_view code) {
    return code.size() == digit_count && code.find_first_not_of("0123456789") == code.npos;
}

std::optional<std::string> SignInCodes::make(Form form, http::Access access, ano::TimePoint now) {
    auto made = form == Form::link ? random_hex(link_bytes) : random_digits(digit_count);
    if (made) codes_[place_of(form)] = {State::valid, *made, access, now, 0};
    return made;
}

SignInCodes::Use SignInCodes::use(std::string_view code, ano::TimePoint now) {
    const Form form = is_digits(code) ? Form::digits : Form::link;
    Code& known = codes_[place_of(form)];
    if (state(form, now) != State::valid) return {};
    if (http::is_same_token(known.text, code)) {
        known.state = State::used;
        return {known.access, false};
    }
    if (form == Form::link || ++known.wrong < max_wrong) return {};
    known.state = State::voided;
    return {std::nullopt, true};
}

SignInCodes::State SignInCodes::state(Form form, ano::TimePoint now) const {
    const Code& code = codes_[place_of(form)];
    return code.state == State::valid && now - code.made_at >= lifetime ? State::expired : code.state;
}

std::string_view text(SignInCodes::State state) noexcept {
    constexpr std::string_view words[] = {"none", "valid", "used", "expired", "void"};
    return words[static_cast<std::size_t>(state)];
}

}    // namespace anogate
