#include <control/sign_in_codes.hpp>

#include <gtest/gtest.h>

#include <string>

namespace anogate::sign_in_codes_tests {
namespace {

using namespace std::chrono_literals;
using Form = SignInCodes::Form;
using State = SignInCodes::State;
using http::Access;

TEST(SignInCodes, have_the_requested_form) {
    SignInCodes codes;
    EXPECT_EQ(codes.make(Form::link, Access::control, {}).value().size(), 32u);
    for (int i = 0; i < 50; ++i) {
        const std::string digits = codes.make(Form::digits, Access::view, {}).value();
        EXPECT_TRUE(SignInCodes::is_digits(digits)) << digits;
    }
    for (const std::string other : {"", "12345", "1234567", "12345a", " 12345", "-12345"})
        EXPECT_FALSE(SignInCodes::is_digits(other)) << other;
}

TEST(SignInCodes, grant_their_access_only_once) {
    SignInCodes codes;
    EXPECT_EQ(text(codes.state(Form::link, {})), "none");
    for (const Form form : {Form::link, Form::digits})
        for (const Access access : {Access::view, Access::control}) {
            const std::string code = codes.make(form, access, {}).value();
            EXPECT_EQ(codes.state(form, {}), State::valid);
            EXPECT_EQ(codes.use(code, {}).access, access);
            EXPECT_FALSE(codes.use(code, {}).access);
            EXPECT_EQ(codes.state(form, {}), State::used);
        }
}

TEST(SignInCodes, of_two_links_only_the_newer_one_is_valid) {
    SignInCodes codes;
    const std::string older = codes.make(Form::link, Access::control, {}).value();
    const std::string newer = codes.make(Form::link, Access::control, {}).value();
    const std::string digits = codes.make(Form::digits, Access::control, {}).value();
    EXPECT_FALSE(codes.use(older, {}).access);
    EXPECT_TRUE(codes.use(newer, {}).access);
    EXPECT_TRUE(codes.use(digits, {}).access) << "the other form is a code of its own";
}

TEST(SignInCodes, wrong_links_do_not_void_the_valid_one) {
    SignInCodes codes;
    const std::string link = codes.make(Form::link, Access::control, {}).value();
    for (int i = 0; i < 100; ++i) EXPECT_FALSE(codes.use(std::string(32, '0'), {}).voids);
    EXPECT_TRUE(codes.use(link, {}).access);
}

}    // namespace
}    // namespace anogate::sign_in_codes_tests
