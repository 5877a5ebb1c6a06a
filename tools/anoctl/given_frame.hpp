// A frame given on the command line: NAME FIELD=VALUE... --from A --to B.
#pragma once
#include "options.hpp"

#include <ano_json/frame_json.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anoctl {

struct GivenFrame {
    std::string name;
    std::vector<std::string> fields;
    std::string from = "254";
    std::string to = "255";
    std::optional<std::string> data;
    bool v7 = false;    // a frame of protocol version 7

    /// `given` must live as long as the run; `help` is the text for NAME.
    static void add(Options& options, GivenFrame& given, const std::string& help);
    /// The complete frame. Throws UsageError.
    std::vector<std::uint8_t> bytes(const ano::JsonOptions& options) const;

private:
    ano::Json json() const;
};

/// The complete frame. Throws UsageError, whose text begins with `where`. `v7`: of protocol version 7.
std::vector<std::uint8_t> frame_bytes(const ano::Json& json, const ano::JsonOptions& options, const std::string& where,
                                      bool v7 = false);

}    // namespace anoctl
