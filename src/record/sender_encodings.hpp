// In which encoding the senders of a gateway write their texts.
#pragma once
#include <ano_json/encoding_of_sender.hpp>
#include <record/decoding.hpp>

#include <array>
#include <optional>
#include <string_view>

namespace anogate {

/// What is stated for the link by which a sender was received, otherwise by its texts; of a frame for a device, what is stated for the link to
/// it.
class SenderEncodings {
public:
    /// That of the texts in `frame`, which passed `link`. Every frame must be given, in order. nullptr: nothing is stated.
    ano::Encoding of(ano::FrameView frame, std::string_view link, bool is_received, const Decoding* decoding);

private:
    std::array<ano::EncodingOfSender, 256> senders_{};
    std::array<std::optional<ano::Encoding>, 256> stated_{};
};

}    // namespace anogate
