// What every link stands on: the loop, the one timer, the gateway, and the room that reading shares.
#pragma once
#include <link/alarm.hpp>
#include <link/datagram_batch.hpp>
#include <link/datagram_sender.hpp>
#include <link/link.hpp>

namespace anogate {

struct LinkContext {
    asio::io_context& io;
    AlarmClock& alarms;
    LinkHost& host;
    DatagramBatch& batch;
    DatagramSender& sender;
};

/// A retry may come this much later than Backoff says: the absent devices of a whole vehicle share one wake-up a second.
inline constexpr Duration retry_slack = std::chrono::milliseconds{250};

}    // namespace anogate
