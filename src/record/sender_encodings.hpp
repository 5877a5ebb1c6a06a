// The encoding of the texts of each sender of a gateway.
#pragma once
#include <ano_json/encoding_of_sender.hpp>
#include <record/decoding.hpp>

#include <array>
#include <optional>
#include <string_view>

namespace anogate {

/// The encoding configured for the link on which a sender was received; otherwise it is detected from the texts of the sender.
/// For a frame sent to a device by a sender without either, the encoding configured for the link to the device.
class SenderEncodings {
public:
    /// The encoding of the texts in `frame`, which passed `link`. Must be called for every frame, in order. `decoding` nullptr:
    /// no encoding is configured.
    ano::Encoding of(ano::FrameView frame, std::string_view link, bool is_received, const Decoding* decoding);

private:
    std::array<ano::EncodingOfSender, 256> senders_{};
    std::array<std::optional<ano::Encoding>, 256> stated_{};
};

}    // namespace anogate
