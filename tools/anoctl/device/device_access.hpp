// Access to the routes of devices, of a running gateway or of this process with its own link.
#pragma once
#include <anoctl/anoctl.hpp>

#include <http/answer.hpp>
#include <http/request.hpp>
#include <sys/asio_fwd.hpp>

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace anoctl {

/// Works while its loop runs. Callbacks are called from the loop, never from within ask() or stream().
class DeviceAccess {
public:
    using Done = std::function<void(anogate::http::Outcome)>;
    using Line = std::function<void(std::string_view)>;

    virtual ~DeviceAccess() = default;
    /// Calls `done` with the complete response. One request at a time, besides one stream.
    virtual void ask(anogate::http::Request request, Done done) = 0;
    /// Calls `line` for each line of the response. One stream at a time. `done` receives the body of a response that is not 200.
    virtual void stream(anogate::http::Request request, Line line, Done done) = 0;
    /// Cancels the request and the stream without calling their callbacks; the server detects the disconnect.
    virtual void hang_up() = 0;
};

/// Access to the gateway with this control socket.
std::unique_ptr<DeviceAccess> gateway_access(anogate::asio::io_context& io, const std::string& socket);

}    // namespace anoctl
