// The other parts of the program, as the gateway knows them. Each enters itself when it is constructed, and leaves when it is
// destroyed.
#pragma once
#include <ano/frame.hpp>
#include <gateway/forwarder.hpp>
#include <gateway/ids.hpp>
#include <runtime/recording_figures.hpp>

#include <nlohmann/json_fwd.hpp>

#include <algorithm>
#include <functional>
#include <string>
#include <vector>

namespace anogate {

struct LinkState;
struct ClockReading;

/// What happens in the running gateway. A part overrides what concerns it. No part may enter or leave during a call.
class GatewayEvents {
public:
    /// A required link was not up in time.
    virtual void required_missing(const std::string& /*link*/) {}
    virtual void link_changed(const LinkState& /*link*/) {}
    /// It was up.
    virtual void link_lost(const LinkState& /*link*/) {}
    /// The connection of the channel is lost, or it is about to be closed.
    virtual void channel_lost(ChannelId /*channel*/) {}
    virtual void conflict_began(const std::string& /*what*/) {}
    /// Layouts that a client had set are dropped, because the configuration has changed.
    virtual void layouts_overruled() {}
    /// The gateway's own answer to a request that was sent in its own name.
    virtual void own_answer(ano::FrameView /*frame*/) {}
    /// The gateway refuses a request that was sent in its own name; `why` is a clause.
    virtual void own_refusal(const std::string& /*why*/) {}
    /// Gateway::stop() begins: who sends on his own must stop.
    virtual void stopping() {}
    /// Reading ended at `unread_since`, and the links are about to be closed: the state may be stored for the next run.
    virtual void closing(const ClockReading& /*unread_since*/) {}
    /// Adds its entries to the section `gateway` of the status.
    virtual void describe_gateway(nlohmann::ordered_json& /*gateway*/) const {}

protected:
    ~GatewayEvents() = default;
};

/// The gateway as a device.
class OwnFrames : public Forwarder::Own {
public:
    /// Sends all waiting frames. Called after every received frame, and at the end of every batch.
    virtual void send_waiting() = 0;

protected:
    ~OwnFrames() = default;
};

class RecordingService {
public:
    /// Start and stop the configured recording, or one with its defaults. Return empty, or a clause with the reason for the
    /// failure.
    virtual std::string start_recording() = 0;
    virtual std::string stop_recording() = 0;
    /// The section `recording` of the status.
    virtual void describe(nlohmann::ordered_json& recording) = 0;
    virtual RecordingFigures figures() = 0;

protected:
    ~RecordingService() = default;
};

class ScanService {
public:
    /// Sends a query to all devices; `on_found` receives one line for each answer. Returns empty, or a clause with the reason why
    /// the scan can't begin.
    virtual std::string scan(const std::function<void(const std::string&)>& on_found) = 0;

protected:
    ~ScanService() = default;
};

struct GatewayParts {
    void enter(GatewayEvents& part) { listeners.push_back(&part); }
    void leave(GatewayEvents& part) { std::erase(listeners, &part); }
    /// Calls `event` of all parts, in the order in which they entered: tell(&GatewayEvents::stopping).
    template <class Event, class... Arguments>
    void tell(Event event, const Arguments&... arguments) const {
        for (GatewayEvents* part : listeners) (part->*event)(arguments...);
    }

    std::vector<GatewayEvents*> listeners{};
    OwnFrames* own = nullptr;                 // nullptr: the gateway is not a device; as Forwarder::set_own()
    RecordingService* recording = nullptr;    // nullptr: no recordings
    ScanService* scan = nullptr;              // nullptr: no requests to devices
};

}    // namespace anogate
