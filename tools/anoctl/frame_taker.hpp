// Who gets frames as they come: those of a gateway that runs (watch.hpp), or by a link of our own (own_link.hpp).
#pragma once
#include <ano/frame.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anoctl {

/// When and where a frame passed; without a link it is not told.
struct Passage {
    std::string link{};
    double time = 0;            // seconds since 1970
    std::string peer{};         // empty: it is not told
    std::string direction{};    // "in", "out", "dropped"; empty as well
    std::string cause{};        // why it was dropped; empty: it was not
    // Of a gateway's frames only.
    std::uint64_t time_ns = 0;                // since 1970
    std::uint64_t boottime_ns = 0;            // since the computer was started
    std::optional<std::uint8_t> channel{};    // that `peer` is the name of
};

class FrameTaker {
public:
    /// False: it wants no more.
    virtual bool take(ano::FrameView frame, const Passage& passage) = 0;
    /// Behind the frames that came at once, and some times a second. False: nobody reads what it writes any more.
    virtual bool flush() = 0;
    /// A gateway had no room for `count` frames; `names` says of what messages, `json` is its own word.
    virtual void miss(std::uint64_t count, const std::string& names, std::string_view json) = 0;

protected:
    ~FrameTaker() = default;
};

}    // namespace anoctl
