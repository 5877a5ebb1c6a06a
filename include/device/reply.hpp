// The answer to a frame: at most one (protocol text, section 3).
#pragma once
#include <ano/frame.hpp>
#include <ano/typed.hpp>
#include <device/outgoing.hpp>

#include <cstdint>
#include <string_view>

namespace ano::device {

/// The result for a frame.
enum class Outcome : std::uint8_t {
    answered,
    later,         // the answer is sent when the work is done
    unanswered,    // frames with this id are never answered
    unknown,       // an id, a number or a code that the device does not have
    malformed,     // shorter than its layout, or than the type of its value
    refused,       // by the limits, or by a function of the user
};

/// The receiver of a late answer.
struct Asker {
    std::uint8_t address;
    Link link;
    friend constexpr bool operator==(const Asker&, const Asker&) = default;
};

/// Sends the answer to the sender of the request, on the link on which the request was received. A second answer to the same
/// frame is not sent. If Outgoing is full, the answer is lost, as it may be lost on a line, and the sender repeats the request.
class Reply {
public:
    Reply(FrameView request, Link link, std::uint8_t self, Outgoing& out) noexcept
        : request_{request}, asker_{request.source(), link}, self_{self}, out_{out} {}

    FrameView request() const noexcept { return request_; }
    const Asker& asker() const noexcept { return asker_; }
    /// How many answers were lost: 0 or 1.
    unsigned lost() const noexcept { return lost_; }

    /// 0x00 with the id and both check bytes of the request.
    Outcome acknowledge() noexcept;
    /// `zeros`: the number of bytes 0 to append to DATA, for devices whose layout is longer.
    template <Name M, Name Label>
    Outcome send(const Draft<M, Label>& draft, std::size_t zeros = 0) noexcept {
        if (sent_) return Outcome::answered;
        sent_ = true;
        std::uint8_t* memory = out_.prepare();
        if (memory == nullptr) ++lost_;
        else out_.commit(lengthen(memory, draft.encode({memory, Outgoing::room}, self_, asker_.address), zeros), asker_.link);
        return Outcome::answered;
    }

private:
    static std::size_t lengthen(std::uint8_t* frame, std::size_t size, std::size_t zeros) noexcept;

    FrameView request_;
    Asker asker_;
    std::uint8_t self_;
    bool sent_ = false;
    std::uint8_t lost_ = 0;
    Outgoing& out_;
};

/// The beginning of `text` that leaves room for `before` bytes of DATA in a frame.
constexpr std::string_view what_fits(std::string_view text, std::size_t before) noexcept {
    return text.substr(0, max_sent - before);
}

}    // namespace ano::device
