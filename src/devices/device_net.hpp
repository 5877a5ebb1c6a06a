// The interface of the host engine to its environment: sending, knowledge of the network, time.
#pragma once
#include <ano/fault.hpp>
#include <ano/flexible.hpp>
#include <ano/flush.hpp>
#include <ano/frame.hpp>
#include <ano/limits.hpp>
#include <ano/time.hpp>
#include <ano/values.hpp>
#include <ano_json/text.hpp>
#include <host/air_guard.hpp>
#include <host/parameter_write.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// An address from which frames were received.
struct HeardAddress {
    std::uint8_t address = 0;
    std::string link;    // on which frames of it were received, or to which it is pinned ("group G"); empty: not known
    std::string peer;
    std::optional<ano::TimePoint> heard_at{};
};

/// The location of a device: distinguishes it from others with its address in other runs of this program.
struct UnitPlace {
    std::string gateway;    // the gateway among those of this user: its control socket
    std::string link;       // its name
    std::string wire;       // the target of the link: "serial:/dev/ttyUSB0"
};

/// The configuration for communication with a device.
struct DeviceLimits {
    ano::host::WriteLimits text{};
    std::optional<ano::ValueType7> value_type_7{};    // stated for the link; std::nullopt: from the device's descriptions
    std::optional<ano::Encoding> encoding{};          // of its texts; std::nullopt: detected from them
    bool expects_gbk = false;                         // its link has profile=vendor
    std::size_t max_data = ano::vendor_max_data;      // maximum bytes of DATA in a frame to it
    bool by_number = false;                           // Device::ask_by_number()
};

/// Why a frame is not sent; empty: it is sent, or may be sent at the next attempt.
struct Unsent {
    ano::Fault why{};
    bool is_down = false;    // its link is down or too slow: a later try may succeed
};

/// Called by DeviceService from its own functions. No function may call the service back directly, except that send() may cause a
/// call of DeviceService::hear().
class DeviceNet {
public:
    virtual ~DeviceNet() = default;

    virtual ano::TimePoint now() = 0;
    /// Sends `frame` as the host.
    virtual Unsent send(ano::FrameView frame) = 0;
    /// Sends zero bytes before `next`, which will be passed to send(), on each UART that it will use and on which nothing else
    /// waits.
    virtual ano::Flush flush_parser(ano::FrameView /*next*/) { return {}; }
    /// The text that was passed to cache() in this or an earlier run; empty: none. Its content is not trusted.
    virtual std::string cached(const std::string& /*name*/) { return {}; }
    /// Stores a text that can be recreated: losing it only costs time.
    virtual void cache(const std::string& /*name*/, const std::string& /*text*/) {}
    /// Whether a frame that was passed to send() for `address` waits to be sent.
    virtual bool is_waiting(std::uint8_t /*address*/) { return false; }
    /// Why no frame to `address` is being sent, once that has lasted 3 s; empty: frames are sent, or none waits. To
    /// be called several times a second while a job waits for the device.
    virtual ano::Fault accepts_nothing(std::uint8_t /*address*/) { return {}; }
    /// Whether every passing frame must be passed to DeviceService::hear() from now on.
    virtual void listen(bool wants) = 0;
    /// DeviceService::run() must be called at `at`, or at an earlier time set before.
    virtual void wake(ano::TimePoint at) = 0;
    /// Devices and ports, without hosts.
    virtual std::vector<HeardAddress> heard(ano::TimePoint now) = 0;
    virtual ano::host::RouteInfo route_info(std::uint8_t address, ano::TimePoint now) = 0;
    /// The links on which frames of the several devices with `address` were received.
    virtual std::vector<std::string> links_in_conflict(std::uint8_t /*address*/, ano::TimePoint /*now*/) { return {}; }
    /// Whether both addresses are or may be the same device: one is the port on which the other is heard.
    virtual bool is_same_device(std::uint8_t /*one*/, std::uint8_t /*other*/) { return false; }
    /// `port`: a port id to which a question was sent. Whether the frame now in hear(), from `source`, was received on that port,
    /// and no device there uses `port` as its own address.
    virtual bool may_answer_for(std::uint8_t /*source*/, std::uint8_t /*port*/) { return false; }
    virtual UnitPlace unit_place(std::uint8_t /*address*/, ano::TimePoint /*now*/) { return {}; }
    /// Whether the frame now in hear() was received where the route of this address leads.
    virtual bool came_from(std::uint8_t /*address*/) { return true; }
    /// The present layouts of flexible messages.
    virtual const ano::FlexibleLayouts& layouts() const {
        static const ano::FlexibleLayouts none;
        return none;
    }
    virtual DeviceLimits device_limits(std::uint8_t /*address*/) { return {}; }
    /// Whether a request received at `came_at` may have waited during a standstill: then it must not be carried out late.
    virtual bool may_have_waited(ano::TimePoint /*came_at*/) { return false; }
    /// Date and time for people; empty: not known.
    virtual std::string date_text() { return {}; }
    /// Logs what was done to a device without a client that requested it, or what could not be done.
    virtual void report(const std::string& /*text*/, bool /*is_warning*/) {}
    /// The place where keep() stores the text under `name`, for people.
    virtual std::string kept_path(const std::string& name) { return name; }
    /// How the user can write back the values that keep() stored under `name`, as a clause; empty: the next run of this program
    /// does it.
    virtual std::string way_to_write_back(const std::string& /*name*/) { return {}; }
    // NOLINTBEGIN(performance-unnecessary-value-param): an asynchronous implementation moves them
    /// Stores `text` under `name` so that it survives a crash, then calls `done` with the error or "". An empty text deletes it. `done`
    /// may be called from within keep().
    virtual void keep(std::string /*name*/, std::string /*text*/, std::function<void(std::string fault)> done) { done({}); }
    /// Calls `work`, which may take long and must not use shared data, then `done` with the text of its exception or "". `done`
    /// may be called from within aside().
    virtual void aside(std::function<void()> work, std::function<void(std::string fault)> done) {
        work();
        done({});
    }
    // NOLINTEND(performance-unnecessary-value-param)
};

}    // namespace anogate
