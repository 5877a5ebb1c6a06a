// Reading configurations in tests.
#pragma once
#include <config/config.hpp>
#include <link/kinds.hpp>

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace anogate {

/// With all existing kinds of link.
inline Draft parse_config(std::string_view json, const std::string& file = {}) { return parse_config(json, link_kinds(), file); }

/// From a configuration in JSON without errors.
inline Settings settings_of(std::string_view json) {
    Draft draft = parse_config(json);
    EXPECT_EQ(lines(draft.errors), "");
    return draft.settings;
}

/// All errors of a configuration in JSON, one per line: "/links/0/baud: what is wrong".
inline std::string faults_in(std::string_view json) {
    std::string text;
    for (const ConfigError& error : parse_config(json).errors) text += error.where + ": " + error.what + "\n";
    return text;
}

/// All errors of some LINK texts.
inline std::string faults_of(std::initializer_list<std::string_view> links) {
    Draft draft{link_kinds()};
    for (const std::string_view link : links) read_link(link, "", draft);
    validate(draft);
    std::string text;
    for (const ConfigError& error : draft.errors) text += error.where + ": " + error.what + "\n";
    return text;
}

}    // namespace anogate
