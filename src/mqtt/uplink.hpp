// Publishes the records of a gateway: live ones from memory, and the spool's when the connection has time. Between the loop, the broker's
// thread and the spool's thread.
#pragma once
#include <mqtt/backlog_pace.hpp>
#include <mqtt/broker.hpp>
#include <mqtt/delivery.hpp>
#include <mqtt/presence.hpp>
#include <mqtt/spool_thread.hpp>
#include <mqtt/topics.hpp>
#include <sys/asio.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

namespace anogate {

class Uplink {
public:
    /// All must outlive it.
    Uplink(asio::io_context& io, const Topics& topics, std::uint64_t backlog_rate, Broker& broker, SpoolThread& spool)
        : topics_{topics}, broker_{broker}, spool_{spool}, pace_{backlog_rate}, backlog_timer_{io} {}

    void add(Record record);
    void on_connected(std::size_t window);
    void on_disconnected();
    /// `reason`: of PUBACK, for a publication of this object.
    void on_answered(std::uint64_t id, std::uint8_t reason);
    void on_spooled(SpooledBatch batch);
    void on_spool_state(const SpoolState& state);
    /// At least four times per second.
    void on_time();
    /// Stores everything that was not acknowledged.
    void store_all() { spool_.store(delivery_.take_all()); }

    bool is_connected() const noexcept { return is_connected_; }
    const DeliveryCounts& counts() const noexcept { return counts_; }

private:
    void publish();
    void publish_backlog();
    void on_backlog_answered(Fate fate);
    void count(Fate fate);

    const Topics& topics_;
    Broker& broker_;
    SpoolThread& spool_;
    Delivery delivery_;
    BacklogPace pace_;
    asio::steady_timer backlog_timer_;
    DeliveryCounts counts_;
    bool is_connected_ = false;
    std::size_t window_ = 0;
    ano::TimePoint paused_until_{}, stored_at_{};
    std::optional<SpooledBatch> batch_;    // the next one of the spool
    bool is_asked_ = false, is_in_flight_ = false;
};

}    // namespace anogate
