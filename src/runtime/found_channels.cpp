#include <runtime/found_channels.hpp>

#include <span>

namespace anogate {

FrameKind kind_of(const RecordedFrame& frame) { return {std::string{frame.link}, frame.frame.source(), frame.frame.id()}; }

FirstFrame::FirstFrame(const RecordedFrame& frame, std::vector<FoundChannel> found, bool is_of_new_link)
    : time_ns_{frame.time_ns}, found_{std::move(found)} {
    if (!is_of_new_link) return;
    link_ = frame.link;
    bytes_.assign(frame.frame.bytes().begin(), frame.frame.bytes().end());
}

std::optional<RecordedFrame> FirstFrame::frame() const {
    if (bytes_.empty()) return std::nullopt;
    const std::span<const std::uint8_t> bytes{reinterpret_cast<const std::uint8_t*>(bytes_.data()), bytes_.size()};
    RecordedFrame recorded{.link = link_, .frame = ano::FrameView{bytes}};
    recorded.time_ns = time_ns_;
    return recorded;
}

const FirstFrame* FoundChannels::look_at(const RecordedFrame& frame) {
    std::vector<FoundChannel> found;
    for (const DecodedMessage& message : decoded_.decode(frame)) {
        FrameKind kind = kind_of(frame);
        if (!known_.emplace(message.channel, kind).second) continue;
        const DecodedChannel& channel = decoded_.channels()[message.channel];
        found.push_back({&channel, &decoded_.schemas()[channel.schema], std::move(kind)});
    }
    if (found.empty()) return nullptr;
    const bool is_of_new_link = links_.emplace(frame.link).second;
    return &first_frames_.emplace_back(frame, std::move(found), is_of_new_link);
}

void FoundChannels::use(DecodingPtr decoding) {
    decoded_.use(std::move(decoding));
    std::erase_if(known_, [](const auto& known) { return ano::is_flexible(known.second.id); });
    for (FirstFrame& first : first_frames_) first.forget_flexible();
}

void FoundChannels::forget(std::string_view link) {
    std::erase_if(known_, [link](const auto& known) { return known.second.link == link; });
    for (FirstFrame& first : first_frames_)
        if (!first.found().empty() && first.found().front().kind.link == link) first.forget();
}

}    // namespace anogate
