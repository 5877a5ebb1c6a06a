// Records in memory: published first, and passed to the spool only if they are not acknowledged within `patience`. No I/O, no clock.
#pragma once
#include <ano/time.hpp>
#include <mqtt/puback.hpp>
#include <mqtt/telemetry.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <vector>

namespace anogate {

class Delivery {
public:
    /// With a look four times per second, a record is on the disk before it is one second old.
    static constexpr ano::Duration patience = std::chrono::milliseconds{700};
    static constexpr std::size_t max_bytes = 4 * 1024 *
                                             1024;    // of records in memory; above, the oldest go to the spool at once

    /// The seq of each record is one above that of the record before.
    void add(Record record);

    /// The next record to publish, which is in flight from now on; nullptr: none, or `window` records are in flight. Valid until the
    /// next call of another function.
    const Record* next(std::size_t window);
    /// For the record with this seq; no effect if it is not in memory any more.
    void on_answer(std::uint64_t seq, Fate fate);
    /// Records in flight are published again after the next connection.
    void on_disconnected();

    /// Removes the records to be stored now: those older than `patience`, and the oldest ones while there are more than max_bytes.
    std::vector<Record> take_old(ano::TimePoint now);
    /// Removes all records that were not acknowledged: the program ends.
    std::vector<Record> take_all() { return take(entries_.size()); }

    std::size_t in_flight() const noexcept { return in_flight_; }
    std::size_t bytes() const noexcept { return bytes_; }

private:
    enum class State : std::uint8_t { waiting, in_flight, done };
    struct Entry {
        Record record;
        State state = State::waiting;
    };
    std::vector<Record> take(std::size_t count);
    void pop_done();

    std::deque<Entry> entries_;    // by seq, without gaps
    std::size_t next_ = 0;         // index of the first entry that may be waiting
    std::size_t in_flight_ = 0;
    std::size_t bytes_ = 0;
};

}    // namespace anogate
