// The raw bytes of a link, for the tools that show them and write some by hand.
#pragma once
#include <cstdint>
#include <span>

namespace anogate {

/// Is called for the bytes read from and written to the wire. A call must not change the link.
class RawTap {
public:
    virtual void received(std::span<const std::uint8_t> bytes) = 0;
    virtual void sent(std::span<const std::uint8_t> bytes) = 0;

protected:
    ~RawTap() = default;
};

class RawPort {
public:
    /// nullptr (the default): no calls and no cost per byte.
    virtual void set_tap(RawTap* tap) = 0;
    /// Sends the bytes unchanged, between two frames. False: the link is down, or the bytes of the previous call are still
    /// waiting.
    virtual bool write_raw(std::span<const std::uint8_t> bytes) = 0;

protected:
    ~RawPort() = default;
};

}    // namespace anogate
