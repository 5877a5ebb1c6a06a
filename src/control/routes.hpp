// The routes of the control interface.
#pragma once
#include <control/page.hpp>
#include <status/listener_info.hpp>

#include <functional>

namespace anogate {

class DeviceService;
class FoxgloveStreams;
class FrameStreams;
class Gateway;
class RawStreams;
class TaskPool;
namespace http {
class Routes;
}

/// The parts of the program that the routes are for. All must outlive the routes and their answers.
struct ServedParts {
    Gateway& gateway;
    DeviceService& devices;
    FrameStreams& frames;
    FoxgloveStreams& foxglove;
    RawStreams& raw;
    TaskPool& disk;    // reads the map
};

/// Each route has a description, which `GET /` and the reference show. `listener` returns the present state of the TCP access.
/// `page`: the page for browsers.
void add_routes(
    http::Routes& routes, const ServedParts& parts, const std::function<ListenerInfo()>& listener = [] { return ListenerInfo{}; },
    Page page = {});

}    // namespace anogate
