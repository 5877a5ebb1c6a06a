// anoctl devices: who is there.
#include "device_client.hpp"

#include <anoctl/anoctl.hpp>
#include <anoctl/gateway_json.hpp>
#include <anoctl/table.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>

namespace anoctl {
namespace {

using ano::Json;

std::string age_of(const Json& device) { return device.contains("age") ? time_text(number_at(device, "age")) : std::string{}; }

struct Devices {
    DeviceOptions options;
    bool scan = false;

    int run(Streams& streams) const {
        DeviceClient client{options, streams};
        const Json found = client.devices(scan || !options.link.empty());    // a link of our own has heard nobody yet
        if (options.json) {
            for (const Json& device : found) streams.out << device.dump() << '\n';
            return fine;
        }
        Table table{
            {"ADDRESS", "NAME", " HARDWARE", " SOFTWARE", " PROTOCOL", " PARAMETERS", "LINK", "PEER", " HEARD", " RATE", "JOB"}};
        for (const Json& device : found) {
            const std::string rate = text_at(device, "rate"), job = text_at(device, "job");
            table.row({text_at(device, "address"), text_at(device, "name"), text_at(device, "hw"), text_at(device, "sw"),
                       text_at(device, "pt"), text_at(device, "parameters"), text_at(device, "link"), text_at(device, "peer"),
                       age_of(device), rate.empty() ? rate : rate + "/s", job});
        }
        if (table.empty()) streams.err << "anoctl: no device is there" << (scan ? "" : "; --scan asks everybody") << '\n';
        else table.write(streams.out);
        return fine;
    }
};

}    // namespace

Run add_devices(Options& options) {
    const auto self = std::make_shared<Devices>();
    options.push_back({"--scan", &self->scan, "", "Asks everybody who he is; without it, those that were heard"});
    DeviceOptions::add_place(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
