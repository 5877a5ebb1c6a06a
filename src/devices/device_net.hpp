// What surrounds the host engine: how its frames leave, what is known of the network, when it is called.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <ano/values.hpp>
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
    std::string link;    // by which it was heard; empty: not known
    std::string peer;
    std::optional<ano::TimePoint> heard_at{};
};

/// What is configured of the way to a device.
struct DeviceManners {
    ano::host::TextLimits text{};
    ano::ValueType7 value_type_7 = ano::ValueType7::f32;
    std::size_t max_data = 198;    // bytes of DATA that a frame to it may have
};

/// The service calls it from within its own functions. Nothing here calls the service back at once, but that send() may lead to
/// DeviceService::hear().
class DeviceNet {
public:
    virtual ~DeviceNet() = default;

    virtual ano::TimePoint now() = 0;
    /// Sends `frame` as the host. Why it never will, as a clause for people; empty: it is on its way, or may be the next time.
    virtual std::string send(ano::FrameView frame) = 0;
    /// From now on every frame that passes is given to DeviceService::hear(), or none any more.
    virtual void listen(bool wants) = 0;
    /// DeviceService::run() is to be called at `at`, or at what it said sooner.
    virtual void wake(ano::TimePoint at) = 0;
    /// Devices and ports; hosts are not among them.
    virtual std::vector<HeardAddress> heard(ano::TimePoint now) = 0;
    virtual ano::host::Whereabouts whereabouts(std::uint8_t address, ano::TimePoint now) = 0;
    /// The links by which the several devices that have `address` were heard.
    virtual std::vector<std::string> links_in_conflict(std::uint8_t /*address*/, ano::TimePoint /*now*/) { return {}; }
    /// Two addresses stand for one device, or may: one of them is the port by which the other is heard.
    virtual bool is_same_device(std::uint8_t /*one*/, std::uint8_t /*other*/) { return false; }
    /// `port` is a port id by which a question left: the frame that is heard just now, of `source`, came by where that leads to, and
    /// who is there doesn't speak as `port` itself.
    virtual bool may_answer_for(std::uint8_t /*source*/, std::uint8_t /*port*/) { return false; }
    virtual DeviceManners manners(std::uint8_t /*address*/) { return {}; }
    /// A request that came at `came_at` waited through a standstill: it is not to be carried out late.
    virtual bool may_have_waited(ano::TimePoint /*came_at*/) { return false; }
    // NOLINTBEGIN(performance-unnecessary-value-param): who does it later moves them
    /// Keeps `text` under `name` where it survives a crash, then calls `done` with what is wrong, or nothing; an empty text: it is
    /// no longer needed. `done` may be called at once.
    virtual void keep(std::string /*name*/, std::string /*text*/, std::function<void(std::string fault)> done) { done({}); }
    /// Calls `work`, which may take long and touches nothing that others have, and then `done`, with what it threw or nothing;
    /// `done` may be called at once.
    virtual void aside(std::function<void()> work, std::function<void(std::string fault)> done) {
        work();
        done({});
    }
    // NOLINTEND(performance-unnecessary-value-param)
};

}    // namespace anogate
