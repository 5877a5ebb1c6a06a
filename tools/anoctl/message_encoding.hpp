// The option --message-encoding: the encoding of decoded messages in MCAP.
#pragma once
#include <record/decoded_channels.hpp>

#include <ano_json/text.hpp>

#include <optional>
#include <string>

namespace anoctl {

/// Returns empty, or the reason why `word` is not valid.
inline std::string read_message_encoding(const std::string& word, std::optional<anogate::DecodedEncoding>& encoding) {
    encoding = anogate::decoded_encoding_called(word);
    if (encoding) return {};
    return ano::in_quotes(word) + " is neither cdr nor json";
}

}    // namespace anoctl
