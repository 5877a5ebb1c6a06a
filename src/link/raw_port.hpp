// The bytes of a link as they are on the wire, for people who look at them and write some by hand.
#pragma once
#include <cstdint>
#include <span>

namespace anogate {

/// Is called for what is read from the wire and what the wire takes. It must not change the link in a call.
class RawTap {
public:
    virtual void received(std::span<const std::uint8_t> bytes) = 0;
    virtual void sent(std::span<const std::uint8_t> bytes) = 0;

protected:
    ~RawTap() = default;
};

class RawPort {
public:
    /// nullptr, as at first: nobody is called, and no byte costs anything.
    virtual void set_tap(RawTap* tap) = 0;
    /// Sends the bytes as they are, between two frames. False: the link is down, or what was given before still waits.
    virtual bool write_raw(std::span<const std::uint8_t> bytes) = 0;

protected:
    ~RawPort() = default;
};

}    // namespace anogate
