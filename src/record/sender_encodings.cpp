#include <record/sender_encodings.hpp>

namespace anogate {

ano::Encoding SenderEncodings::of(ano::FrameView frame, std::string_view link, bool is_received, const Decoding* decoding) {
    ano::EncodingOfSender& sender = senders_[frame.source()];
    const std::optional<LinkTexts> texts = decoding ? decoding->texts(link) : std::nullopt;
    if (is_received) sender.expect_gbk(texts == LinkTexts::expect_gbk);
    sender.learn(frame);
    std::optional<ano::Encoding> of_link;
    if (texts && texts != LinkTexts::expect_gbk) of_link = texts == LinkTexts::gbk ? ano::Encoding::gbk : ano::Encoding::utf8;
    auto& of_sender = stated_[frame.source()];
    if (is_received) of_sender = of_link;
    return of_sender.value_or(of_link.value_or(sender.for_reading()));
}

}    // namespace anogate
