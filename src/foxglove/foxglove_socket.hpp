// The WebSocket of a client of the Foxglove protocol.
#pragma once
#include <devices/job.hpp>
#include <foxglove/foxglove_session.hpp>
#include <http/web_socket.hpp>
#include <sys/alarm.hpp>
#include <watch/frame_watch.hpp>

#include <cstddef>
#include <string_view>
#include <vector>

namespace anogate {

class FoxgloveStreams;

/// Encodes further messages only after the client has read the earlier ones, so that a slow client causes little work.
class FoxgloveSocket final : public http::WebSocketUser, private Watcher {
public:
    /// `streams` must outlive it.
    FoxgloveSocket(FoxgloveStreams& streams, unsigned number, std::string_view subprotocol, DecodedEncoding encoding,
                   const Requester& requester);
    ~FoxgloveSocket() override;

    /// Unique for each client.
    unsigned number() const noexcept { return number_; }
    const Requester& requester() const noexcept { return requester_; }

    std::string_view subprotocol() const override { return subprotocol_; }
    void opened(http::WebSocket& socket) override;
    void heard(std::string_view message, http::WebSocket::Kind kind) override;
    void sent_all() override { send_next_part(); }

    DecodedEncoding encoding() const noexcept { return encoding_; }
    void learn(const FirstFrame& first);
    void forget(std::string_view link);
    void use(DecodingPtr decoding);
    void answer(const foxglove::GetParameters& question, const std::vector<foxglove::Parameter>& values);
    void changed(const std::vector<foxglove::Parameter>& values);
    void warn(std::string_view words);

private:
    void more() override;
    void work();
    void watch_what_is_wanted();
    void send_if_idle();
    void send_next_part();
    bool read_next();
    void send(FoxgloveSession::Message message);

    FoxgloveStreams& streams_;
    unsigned number_;
    std::string_view subprotocol_;
    DecodedEncoding encoding_;
    Requester requester_;
    FoxgloveSession session_;
    Alarm work_;
    http::WebSocket* socket_ = nullptr;    // nullptr: not open
    bool watches_ = false;
    WatchQueue::Tables tables_;
    WatchQueue::Batch batch_;
    std::string_view rest_;    // of batch_
};

}    // namespace anogate
