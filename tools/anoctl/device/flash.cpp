// anoctl flash FILE: writes new firmware to a device.
#include "device_client.hpp"
#include "file_text.hpp"
#include "job_text.hpp"

#include <ano_json/escapes.hpp>
#include <anoctl/anoctl.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>
#include <utility>

namespace anoctl {
namespace {

using ano::Json;

struct Flash {
    DeviceOptions options;
    std::string file, crc;
    bool force = false;

    int run(Streams& streams) const {
        anogate::http::Request request;
        request.body = read_input(file, "firmware", streams);
        if (request.body.empty()) throw UsageError{file + ": the file is empty"};
        const bool has_header = request.body.starts_with("bia");
        if (!has_header && file.ends_with(".bia"))
            throw UsageError{file + ": not a .bia file (wrong header); name raw firmware .bin"};
        if (!has_header && file != "-" && !file.ends_with(".bin") && !file.ends_with(".BIN"))
            throw UsageError{file + ": not a .bia file; raw firmware must be named .bin"};
        DeviceClient client{options, streams};
        client.will_act();
        client.must_be_able_to_ask("flash");
        const std::string size = bytes_text(static_cast<double>(request.body.size()));
        if (!client.may("Replace the firmware of " + device_with_versions(client) + " with " + file + ", " + size +
                        (has_header ? "" : ", which does not name its hardware") + "?")) {
            print_note(streams, "nothing was changed");
            return failed;
        }
        request.method = "POST";
        request.target = client.target("/firmware");
        if (force) request.target += "?force";
        if (!crc.empty()) request.target += (force ? "&crc=" : "?crc=") + percent_encoded(crc);
        request.headers.push_back({"Content-Type", "application/octet-stream"});
        ProgressView view{streams, true};
        const Json came = client.run(std::move(request), view);
        if (options.json) streams.out << ano::json_text(came) << '\n';
        else {
            const std::string note = text_at(came, "note");
            print(streams, client.device_words() + ": written and verified, " +
                               plural(static_cast<std::size_t>(number_at(came, "frames")), "frame") + ", " +
                               text_at(came, "repeats") + " repeated, in " + time_text(number_at(came, "seconds")) +
                               (note.empty() ? "" : "; " + note));
        }
        return fine;
    }

private:
    static std::string device_with_versions(DeviceClient& client) {
        const Json& device = client.known_device();
        std::string words = client.device_words();
        if (device.contains("hw")) words += ", hardware " + text_at(device, "hw") + ", software " + text_at(device, "sw") + ",";
        return words;
    }
};

}    // namespace

Run add_flash(Options& options) {
    const auto self = std::make_shared<Flash>();
    options.push_back({"file", &self->file, "FILE", "Firmware file: .bia, checked against the hardware, or .bin", true});
    options.push_back(
        {"--force", &self->force, "", "Update even if the file is for other hardware or the device reports that it is flying"});
    options.push_back(
        {"--crc", &self->crc, "ibm-3740|xmodem|kermit|modbus|arc", "CRC-16 variant of the device's loader (default: ibm-3740)"});
    DeviceOptions::add(options, self->options, "flash");
    DeviceOptions::add_yes(options, self->options);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
