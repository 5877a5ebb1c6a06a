// The Foxglove WebSocket protocol on the port of the control interface: shows its clients the frames and the parameters of devices.
#pragma once
#include <foxglove/foxglove_messages.hpp>
#include <foxglove/parameter_book.hpp>
#include <http/response.hpp>
#include <runtime/found_channels.hpp>
#include <watch/frame_watch.hpp>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class DeviceService;
class FoxgloveSocket;
class Gateway;

/// Whether the request opens a WebSocket of this protocol.
bool is_foxglove(const http::Request& request) noexcept;

/// Does nothing without clients. With clients, it copies about two frames per second of each kind, to find the channels, and the
/// frames to which the clients subscribed.
class FoxgloveStreams final : private Watcher {
public:
    /// The arguments must outlive it; its WebSockets must be destroyed before it.
    FoxgloveStreams(Gateway& gateway, FrameWatch& watch, DeviceService& devices);
    ~FoxgloveStreams();
    FoxgloveStreams(const FoxgloveStreams&) = delete;
    FoxgloveStreams& operator=(const FoxgloveStreams&) = delete;

    http::Response answer(const http::Request& request);

private:
    friend class FoxgloveSocket;

    // A request of a client that waits for devices.
    struct Question;

    void join(FoxgloveSocket& socket);
    void leave(FoxgloveSocket& socket);
    /// nullptr: the client is disconnected.
    FoxgloveSocket* client(unsigned number) const;
    void warn(unsigned client, std::string_view words);
    void more() override;
    void look_at(const RecordedFrame& frame);
    void look_at(WatchQueue::Tables tables);
    FoundChannels& found(DecodedEncoding encoding);
    void renew_decoding();

    void ask(FoxgloveSocket& socket, foxglove::GetParameters question);
    void ask_device(std::uint8_t address, std::vector<std::string> names, const std::shared_ptr<Question>& question);
    void answered(Question& question);
    void read_old_jobs();
    void ended(const Job& job);
    std::string prefix_of(std::uint8_t address);

    Gateway& gateway_;
    FrameWatch& watch_;
    DeviceService& devices_;
    DecodingPtr decoding_;    // of all channels
    foxglove::ServerInfo server_;
    unsigned clients_ = 0;    // number of clients so far
    std::vector<FoxgloveSocket*> sockets_;
    std::optional<FoundChannels> as_cdr_, as_json_;    // std::nullopt: no clients
    WatchQueue::Tables tables_;
    ParameterBook book_;
    std::shared_ptr<char> life_ = std::make_shared<char>();    // expires when this is destroyed: jobs may end later
};

}    // namespace anogate
