// The routes of devices, wherever they are: at a gateway that runs, or in this process, over a link of its own.
#pragma once
#include <anoctl/anoctl.hpp>

#include <http/answer.hpp>
#include <http/request.hpp>
#include <link/asio_fwd.hpp>

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace anoctl {

/// It works when its loop runs, and calls from the loop only, never at once.
class DeviceDoor {
public:
    using Done = std::function<void(anogate::http::Outcome)>;
    using Line = std::function<void(std::string_view)>;

    virtual ~DeviceDoor() = default;
    /// The answer whole. One at a time; beside it there may be a stream.
    virtual void ask(anogate::http::Request request, Done done) = 0;
    /// An answer in lines. One at a time. `done` has the body of an answer that is not 200.
    virtual void stream(anogate::http::Request request, Line line, Done done) = 0;
    /// Ends both without a word to who waits for them; at the other side it is seen that nobody does any more.
    virtual void hang_up() = 0;
};

/// Of the gateway with this socket.
std::unique_ptr<DeviceDoor> gateway_door(anogate::asio::io_context& io, const std::string& socket);

}    // namespace anoctl
