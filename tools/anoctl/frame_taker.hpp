// The receiver of frames as they come: those of a running gateway (watch.hpp), or of a link of our own (own_link.hpp).
#pragma once
#include <ano/frame.hpp>
#include <record/decoding.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anoctl {

/// When and where a frame passed; without a link this is not known.
struct Passage {
    std::string link{};
    double time = 0;            // seconds since 1970
    std::string peer{};         // empty: not known
    std::string direction{};    // "in", "out", "dropped"; empty: not known
    std::string cause{};        // why it was dropped; empty: it was not dropped
    // Only for frames of a gateway:
    bool is_elsewhere = false;                // it came where its source is not at home
    std::uint64_t time_ns = 0;                // ns since 1970
    std::uint64_t boottime_ns = 0;            // ns since the computer was started
    std::optional<std::uint8_t> channel{};    // the channel with `peer`
};

class FrameTaker {
public:
    /// Takes the next frame. False: it wants no more.
    virtual bool take(ano::FrameView frame, const Passage& passage) = 0;
    /// The frames that follow are decoded with this. Called first, and whenever a gateway has other layouts.
    virtual void use(const anogate::DecodingPtr& /*decoding*/) {}
    /// Called after frames that came together, and some times a second. False: nobody reads its output any more.
    virtual bool flush() = 0;
    /// A gateway had no room for `count` frames; `names`: of which messages; `json`: the report of the gateway.
    virtual void miss(std::uint64_t count, const std::string& names, std::string_view json) = 0;

protected:
    ~FrameTaker() = default;
};

}    // namespace anoctl
