// The interface of the host engine to its surroundings: sending, knowledge of the network, time.
#pragma once
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

/// An address that was heard.
struct HeardAddress {
    std::uint8_t address = 0;
    std::string link;    // on which it was heard; empty: not known
    std::string peer;
    std::optional<ano::TimePoint> heard_at{};
};

/// Where a device is, as far as that tells it from others of its address in other runs of this program.
struct UnitPlace {
    std::string gateway;    // which of the gateways of this user: its control socket
    std::string link;       // its name
    std::string wire;       // where the link leads: "serial:/dev/ttyUSB0"
};

/// The configuration for communicating with a device.
struct DeviceManners {
    ano::host::WriteLimits text{};
    std::optional<ano::ValueType7> value_type_7{};    // as stated for the link; std::nullopt: by the device's descriptions
    std::optional<ano::Encoding> encoding{};          // of its texts; std::nullopt: found out from them
    bool expects_gbk = false;                         // its link has profile=vendor
    std::size_t max_data = ano::vendor_max_data;      // maximum bytes of DATA in a frame to it
};

/// Why a frame is not sent, as a clause for the user; empty: it is sent, or may be with the next try.
struct Unsent {
    std::string why{};
    bool is_down = false;    // its link is down: a later try may succeed
};

/// DeviceService calls it from its own functions. No function may call the service back directly, except that send() may lead to
/// DeviceService::hear().
class DeviceNet {
public:
    virtual ~DeviceNet() = default;

    virtual ano::TimePoint now() = 0;
    /// Sends `frame` as the host.
    virtual Unsent send(ano::FrameView frame) = 0;
    /// Has zero bytes sent before `next`, which will be given to send(), wherever it leaves by a UART and nothing else waits.
    virtual ano::Flush flush_parser(ano::FrameView /*next*/) { return {}; }
    /// The text that cache() was given in this or an earlier run; empty: none. It may be anything.
    virtual std::string cached(const std::string& /*name*/) { return {}; }
    /// Stores a text whose loss costs time only.
    virtual void cache(const std::string& /*name*/, const std::string& /*text*/) {}
    /// Whether a frame that send() got for `address` waits to leave.
    virtual bool is_waiting(std::uint8_t /*address*/) { return false; }
    /// Why no frame leaves for `address`, as a clause, once that has lasted 3 s; empty: they leave, or none waits. To be called several
    /// times a second while a job waits for the device.
    virtual std::string takes_nothing(std::uint8_t /*address*/) { return {}; }
    /// Whether every passing frame shall be given to DeviceService::hear() from now on.
    virtual void listen(bool wants) = 0;
    /// DeviceService::run() must be called at `at`, or at an earlier time set before.
    virtual void wake(ano::TimePoint at) = 0;
    /// Devices and ports, without hosts.
    virtual std::vector<HeardAddress> heard(ano::TimePoint now) = 0;
    virtual ano::host::Whereabouts whereabouts(std::uint8_t address, ano::TimePoint now) = 0;
    /// The links by which the several devices that have `address` were heard.
    virtual std::vector<std::string> links_in_conflict(std::uint8_t /*address*/, ano::TimePoint /*now*/) { return {}; }
    /// Whether both addresses are or may be the same device: one is the port on which the other is heard.
    virtual bool is_same_device(std::uint8_t /*one*/, std::uint8_t /*other*/) { return false; }
    /// `port`: a port id to which a question was sent. Whether the frame now being heard, from `source`, came by that port, and no device
    /// there uses `port` as its own address.
    virtual bool may_answer_for(std::uint8_t /*source*/, std::uint8_t /*port*/) { return false; }
    virtual UnitPlace unit_place(std::uint8_t /*address*/, ano::TimePoint /*now*/) { return {}; }
    /// Whether the frame now being heard came by a place where the device with this address is at home.
    virtual bool came_from(std::uint8_t /*address*/) { return true; }
    /// Of flexible messages, as they are now.
    virtual const ano::FlexibleLayouts& layouts() const {
        static const ano::FlexibleLayouts none;
        return none;
    }
    virtual DeviceManners manners(std::uint8_t /*address*/) { return {}; }
    /// Whether a request that came at `came_at` may have waited during a standstill: then it must not be carried out late.
    virtual bool may_have_waited(ano::TimePoint /*came_at*/) { return false; }
    /// Date and time for people; empty: not known.
    virtual std::string date_text() { return {}; }
    /// Logs what was done to a device without a client that asked for it, or could not be done.
    virtual void report(const std::string& /*text*/, bool /*is_warning*/) {}
    /// Where keep() stores what is under `name`, for people.
    virtual std::string kept_path(const std::string& name) { return name; }
    /// How the user writes back what keep() stored under `name`, as a clause; empty: the next run of this program does it.
    virtual std::string way_to_write_back(const std::string& /*name*/) { return {}; }
    // NOLINTBEGIN(performance-unnecessary-value-param): who does it later moves them
    /// Stores `text` under `name` so that it survives a crash, then calls `done` with the error or "". An empty text deletes it. `done`
    /// may be called from within keep().
    virtual void keep(std::string /*name*/, std::string /*text*/, std::function<void(std::string fault)> done) { done({}); }
    /// Calls `work`, which may take long and uses no shared data, then `done` with the text of its exception or "". `done` may be called
    /// from within aside().
    virtual void aside(std::function<void()> work, std::function<void(std::string fault)> done) {
        work();
        done({});
    }
    // NOLINTEND(performance-unnecessary-value-param)
};

}    // namespace anogate
