#include "device_access.hpp"

#include <http/client/client.hpp>

#include <utility>

namespace anoctl {
namespace {

namespace http = anogate::http;

// The result of a job is one line, which may contain all parameters of a device.
constexpr http::ClientLimits limits_of_jobs{.line = 64 * 1024 * 1024};

class GatewayAccess final : public DeviceAccess {
public:
    GatewayAccess(anogate::asio::io_context& io, const std::string& socket)
        : asks_{io, socket, limits_of_jobs}, streams_{io, socket, limits_of_jobs} {}

    void ask(http::Request request, Done done) override { asks_.ask(std::move(request), std::move(done)); }
    void stream(http::Request request, Line line, Done done) override {
        streams_.stream(std::move(request), std::move(line), std::move(done));
    }
    void hang_up() override {
        asks_.cancel();
        streams_.cancel();
    }

private:
    http::Client asks_, streams_;
};

}    // namespace

std::unique_ptr<DeviceAccess> gateway_access(anogate::asio::io_context& io, const std::string& socket) {
    return std::make_unique<GatewayAccess>(io, socket);
}

}    // namespace anoctl
