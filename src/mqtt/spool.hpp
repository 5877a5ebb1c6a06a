// Records that the broker did not acknowledge, on the disk: batches in a SQLite database. Only spool.cpp knows the library.
#pragma once
#include <mqtt/batch.hpp>
#include <sys/expected.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace anogate {

struct SpoolLimits {
    std::uint64_t bytes = std::uint64_t{64} << 20;
    std::uint64_t age_s = std::uint64_t{7} * 24 * 3600;
};

struct SpooledBatch {
    std::int64_t id = 0;
    Batch batch;
};

/// A request with a key that was begun, and its response; empty: it has none.
struct KnownRequest {
    std::string key, response;
    bool operator==(const KnownRequest&) const = default;
};

/// Each function may block on the disk. What a function has done is on the disk when it returns, even after a loss of power.
class Spool {
public:
    /// Opens FOLDER/spool.db or creates it. A damaged one is renamed, and `report` is called with one sentence. Only one program may
    /// use it.
    static Expected<Spool> open(const std::string& folder, const SpoolLimits& limits, std::function<void(std::string)> report);
    Spool(Spool&&) noexcept;
    Spool& operator=(Spool&&) noexcept;
    ~Spool();

    /// In one transaction: removes the batches `done`, adds `batches`, and drops the oldest ones of the lowest class while there are
    /// more than the limits allow. After an error nothing was changed, and `done` is removed later.
    Expected<void> write(std::span<const Batch> batches, std::span<const std::int64_t> done, std::uint64_t now_s);
    /// The batch is not returned by next() any more; the next write() removes it.
    void remove_later(std::int64_t id) { done_.push_back(id); }
    /// The oldest batch of the highest class; std::nullopt: none.
    std::optional<SpooledBatch> next();

    /// Before a request is executed. False: the key is known.
    Expected<bool> begin_request(const std::string& key, std::uint64_t now_s);
    Expected<void> end_request(const std::string& key, const std::string& response);
    std::vector<KnownRequest> requests();

    std::uint64_t records() const noexcept { return records_; }    // waiting
    std::uint64_t dropped() const noexcept { return dropped_; }    // records, by the limits
    std::uint64_t bytes();                                         // of the database, without free pages

private:
    class Database;
    class Statement;
    Spool(std::string folder, const SpoolLimits& limits, std::function<void(std::string)> report);
    Expected<void> open_database();
    Expected<void> write_once(std::span<const Batch> batches, std::span<const std::int64_t> done, std::uint64_t now_s);
    Expected<void> drop_oldest(std::uint64_t now_s);
    void set_aside_if_damaged();
    bool set_aside();

    std::string folder_;
    SpoolLimits limits_;
    std::function<void(std::string)> report_;
    std::unique_ptr<Database> database_;
    std::vector<std::int64_t> done_;    // not removed yet
    std::int64_t last_id_ = 0;          // never used again: a batch that is done may have been dropped already
    std::uint64_t records_ = 0, dropped_ = 0;
};

}    // namespace anogate
