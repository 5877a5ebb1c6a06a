// A body that is too large for memory.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

namespace anogate::http {

/// The whole of one, kept as long as this lives.
class StoredBody {
public:
    virtual ~StoredBody() = default;
    virtual std::uint64_t size() const = 0;
    /// Fills `into` with what is from `at` on; false: it can't be read, or ends before. From any thread.
    virtual bool read(std::uint64_t at, std::span<std::uint8_t> into) const = 0;
};

/// Keeps one while it comes. What it does that may take long is done beside the loop.
class BodyKeeper {
public:
    virtual ~BodyKeeper() = default;
    /// The next part, of which there is one at a time. `done` is called from the loop, never at once, with why it can't be kept or with
    /// nothing; no more when the keeper is gone.
    virtual void put(std::string part, std::function<void(std::string fault)> done) = 0;
    /// When all parts were put.
    virtual std::shared_ptr<const StoredBody> whole() const = 0;
};

using MakeKeeper = std::function<std::unique_ptr<BodyKeeper>()>;

}    // namespace anogate::http
