// Request bodies that are too large for memory.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace anogate::http {

/// A complete body, kept as long as this object lives.
class StoredBody {
public:
    virtual ~StoredBody() = default;
    virtual std::uint64_t size() const = 0;
    /// Fills `into` with the bytes from offset `at`; false: they can't be read, or the body ends before. May be called from any thread.
    virtual bool read(std::uint64_t at, std::span<std::uint8_t> into) const = 0;
};

/// Stores a body while it arrives. Slow work is done outside the loop.
class BodyKeeper {
public:
    virtual ~BodyKeeper() = default;
    /// Stores the next part; the next call must wait for `done`. `done` is called from the loop, never from within put(), with
    /// the reason of a failure or ""; not after the keeper is destroyed.
    virtual void put(std::string part, std::function<void(std::string fault)> done) = 0;
    /// To be called when all parts are stored.
    virtual std::shared_ptr<const StoredBody> whole() const = 0;
};

using MakeKeeper = std::function<std::unique_ptr<BodyKeeper>()>;

}    // namespace anogate::http
