// Which channels there are, found by looking at frames now and then. No I/O.
#pragma once
#include <ano/flexible.hpp>
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

/// What frames that say the same have in common: the link by which they come, who sends them, and their id.
struct FrameKind {
    std::string link;
    std::uint8_t source = 0, id = 0;
    auto operator<=>(const FrameKind&) const = default;
};
FrameKind kind_of(const RecordedFrame& frame);

/// A channel, and one of the kinds of frames that it comes of. It refers to what found it.
struct FoundChannel {
    const DecodedChannel* channel;
    const DecodedSchema* schema;
    FrameKind kind;
};

/// What a frame showed that was new.
class FirstFrame {
public:
    /// `is_of_new_link`: the frame is kept.
    FirstFrame(const RecordedFrame& frame, std::vector<FoundChannel> found, bool is_of_new_link);
    /// The first of its link: whoever decodes these, in their order, calls the links as they are called here. Valid as long as this.
    std::optional<RecordedFrame> frame() const;
    const std::vector<FoundChannel>& found() const noexcept { return found_; }
    /// What it showed is no more.
    void forget() noexcept { found_.clear(); }

private:
    std::string link_, bytes_;
    std::uint64_t time_ns_;
    std::vector<FoundChannel> found_;
};

class FoundChannels {
public:
    /// `flexible` outlives it.
    FoundChannels(DecodedEncoding encoding, const ano::FlexibleLayouts& flexible) : decoded_{encoding, &flexible} {}

    /// Null: it showed nothing new.
    const FirstFrame* look_at(const RecordedFrame& frame);
    const std::deque<FirstFrame>& first_frames() const noexcept { return first_frames_; }
    /// There is no such link any more: what comes by one of that name later is new.
    void forget(std::string_view link);

private:
    DecodedChannels decoded_;
    std::set<std::pair<std::size_t, FrameKind>> known_;    // of each channel
    std::set<std::string, std::less<>> links_;
    std::deque<FirstFrame> first_frames_;
};

}    // namespace anogate
