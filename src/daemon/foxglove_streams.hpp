// The Foxglove WebSocket protocol on the control interface's port: its clients see what passes, and the parameters of devices.
#pragma once
#include <ano/flexible.hpp>
#include <daemon/found_channels.hpp>
#include <daemon/foxglove_messages.hpp>
#include <daemon/frame_watch.hpp>
#include <daemon/parameter_book.hpp>
#include <http/response.hpp>

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class DeviceService;
class FoxgloveSocket;
class Gateway;

/// Whether the request wants a WebSocket of this protocol.
bool is_foxglove(const http::Request& request) noexcept;

/// While there are no clients it does nothing. While there are, about two frames a second of each kind are copied, so that they know which
/// channels there are; of the rest what they subscribed.
class FoxgloveStreams final : private Watcher {
public:
    /// All outlive it. What it answers with is gone before it.
    FoxgloveStreams(Gateway& gateway, FrameWatch& watch, DeviceService& devices);
    ~FoxgloveStreams();
    FoxgloveStreams(const FoxgloveStreams&) = delete;
    FoxgloveStreams& operator=(const FoxgloveStreams&) = delete;

    http::Response answer(const http::Request& request);

private:
    friend class FoxgloveSocket;

    // Of a client who waits for devices.
    struct Question;

    void join(FoxgloveSocket& socket);
    void leave(FoxgloveSocket& socket);
    /// nullptr: he is gone.
    FoxgloveSocket* client(unsigned number) const;
    void warn(unsigned client, std::string_view words);
    void more() override;
    void look_at(const RecordedFrame& frame);
    void look_at(WatchQueue::Tables tables);
    FoundChannels& found(DecodedEncoding encoding);

    void ask(FoxgloveSocket& socket, foxglove::GetParameters question);
    void ask_device(std::uint8_t address, std::vector<std::string> names, const std::shared_ptr<Question>& question);
    void answered(Question& question);
    void read_old_jobs();
    void ended(const Job& job);
    std::string prefix_of(std::uint8_t address);

    Gateway& gateway_;
    FrameWatch& watch_;
    DeviceService& devices_;
    ano::FlexibleLayouts flexible_;
    foxglove::ServerInfo server_;
    unsigned clients_ = 0;    // that came
    std::vector<FoxgloveSocket*> sockets_;
    std::optional<FoundChannels> as_cdr_, as_json_;    // as long as there are clients
    WatchQueue::Tables tables_;
    ParameterBook book_;
    std::shared_ptr<char> life_ = std::make_shared<char>();    // jobs may end behind it
};

}    // namespace anogate
