// Determines from samples of the frames which channels (topics) exist. No I/O.
#pragma once
#include <ano/messages.hpp>
#include <record/decoded_channels.hpp>

#include <compare>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

/// Frames of the same kind have the same link, sender and id.
struct FrameKind {
    std::string link;
    std::uint8_t source = 0, id = 0;
    auto operator<=>(const FrameKind&) const = default;
};
FrameKind kind_of(const RecordedFrame& frame);

/// A channel, and one kind of frames that contains messages for it. Valid as long as the FoundChannels that made it.
struct FoundChannel {
    const DecodedChannel* channel;
    const DecodedSchema* schema;
    FrameKind kind;
};

/// The new channels for which a frame contains messages.
class FirstFrame {
public:
    /// `is_of_new_link`: the frame is the first of its link, and is stored.
    FirstFrame(const RecordedFrame& frame, std::vector<FoundChannel> found, bool is_of_new_link);
    /// The frame, if it is the first of its link; otherwise std::nullopt. A decoder that receives these frames in the same order
    /// names the links in the same way. Valid as long as this object.
    std::optional<RecordedFrame> frame() const;
    const std::vector<FoundChannel>& found() const noexcept { return found_; }
    /// The channels no longer exist.
    void forget() noexcept { found_.clear(); }
    /// The channels of flexible messages no longer exist.
    void forget_flexible() {
        std::erase_if(found_, [](const FoundChannel& found) { return ano::is_flexible(found.kind.id); });
    }

private:
    std::string link_, bytes_;
    std::uint64_t time_ns_;
    std::vector<FoundChannel> found_;
};

class FoundChannels {
public:
    FoundChannels(DecodedEncoding encoding, DecodingPtr decoding) : decoded_{encoding, std::move(decoding)} {}

    /// nullptr: no new channel.
    const FirstFrame* look_at(const RecordedFrame& frame);
    const std::deque<FirstFrame>& first_frames() const noexcept { return first_frames_; }
    /// Decodes the following frames with `decoding`: channels of flexible messages found later are new ones.
    void use(DecodingPtr decoding);
    /// The link was removed: channels of a later link of the same name are new ones.
    void forget(std::string_view link);

private:
    DecodedChannels decoded_;
    std::set<std::pair<std::size_t, FrameKind>> known_;    // of each channel
    std::set<std::string, std::less<>> links_;
    std::deque<FirstFrame> first_frames_;
};

}    // namespace anogate
