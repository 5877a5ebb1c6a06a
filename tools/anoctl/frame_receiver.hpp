// FrameReceiver receives frames as they arrive, from a running gateway (watch.hpp) or from a link of this process (own_link.hpp).
#pragma once
#include <ano/frame.hpp>
#include <record/decoding.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anoctl {

/// When and where a frame was received, sent or dropped.
struct Passage {
    std::string link{};
    double time = 0;            // seconds since 1970
    std::string peer{};         // empty: not known
    std::string direction{};    // "in", "out", "dropped"; empty: not known
    std::string cause{};        // why it was dropped; empty: not dropped
    // Set only for frames from a gateway:
    bool is_elsewhere = false;                // received on a link other than the route of its source
    std::uint64_t time_ns = 0;                // ns since 1970
    std::uint64_t boottime_ns = 0;            // ns since boot
    std::optional<std::uint8_t> channel{};    // the channel of `peer`
};

class FrameReceiver {
public:
    /// Processes the next frame. False: no more frames are needed.
    virtual bool accept(ano::FrameView frame, const Passage& passage) = 0;
    /// The following frames are decoded with these layouts. Called before the first frame, and whenever the gateway's layouts
    /// change.
    virtual void use(const anogate::DecodingPtr& /*decoding*/) {}
    /// Called after each batch of frames, and several times a second. False: the output can no longer be written.
    virtual bool flush() = 0;
    /// The gateway dropped `count` frames because its buffer was full. `names`: their messages; `json`: the report of the
    /// gateway.
    virtual void miss(std::uint64_t count, const std::string& names, std::string_view json) = 0;

protected:
    ~FrameReceiver() = default;
};

}    // namespace anoctl
