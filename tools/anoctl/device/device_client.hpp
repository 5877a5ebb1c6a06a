// Shared by the commands for devices: access to the device, selection of the device, jobs, and questions to the user.
#pragma once
#include "job_view.hpp"

#include <anoctl/anoctl.hpp>
#include <anoctl/gateway.hpp>

#include <ano_json/frame_json.hpp>
#include <http/request.hpp>

#include <memory>
#include <string>
#include <string_view>
#include <utility>

namespace anoctl {

/// A job failed; its result says which parts were done.
struct JobFailure : Failure {
    JobFailure(const std::string& why, std::string what_there_is) : Failure{why}, result{std::move(what_there_is)} {}
    std::string result;    // JSON
};

/// The data read from the device is outdated. Nothing was sent; the client may read it again.
struct Outdated : Failure {
    using Failure::Failure;
    static constexpr std::string_view what_of_commands = "commands_changed";    // `what` of the answer
};

struct DeviceOptions {
    GatewayOptions gateway;
    std::string link, device, command;
    bool json = false, yes = false;
    bool asks_nothing_first = false;    // with --link: no scan for a device given by its address

    /// Declares --link, --control and --json of `command`. `self` must live as long as the run.
    static void add_place(Options& declared, DeviceOptions& self, const char* command);
    /// Declares the same and --device.
    static void add(Options& declared, DeviceOptions& self, const char* command);
    /// Declares --yes.
    static void add_yes(Options& declared, DeviceOptions& self);
};

class DeviceClient {
public:
    /// `options` and `streams` must outlive it. Throws UsageError for an invalid LINK.
    DeviceClient(const DeviceOptions& options, Streams& streams);
    ~DeviceClient();
    DeviceClient(const DeviceClient&) = delete;
    DeviceClient& operator=(const DeviceClient&) = delete;

    /// The response of a route that starts no job. Throws Failure.
    ano::Json ask(const std::string& method, const std::string& target, std::string body = {});
    /// Starts a job, follows it to its end, and returns its result. Throws Failure with the error (JobFailure if there is a
    /// result, or Outdated); if Ctrl-C cancelled the job, throws Interrupted with the parts that are incomplete.
    ano::Json run(anogate::http::Request request, JobView& view);
    /// The same, with a progress bar on a terminal.
    ano::Json run(const std::string& method, const std::string& target, std::string body = {});

    /// The answer with the known devices and those that are lost. `scan`: first requests the names of all devices.
    ano::Json device_list(bool scan);
    /// The known devices.
    ano::Json devices(bool scan);
    /// The chosen device, {"address", "name"…}: that of --device, else the only one. Throws UsageError with the list if there are
    /// several, Failure if there is none.
    const ano::Json& device();
    /// The same with its "name" and "dev_id", which are requested if not known. Without them if the device does not respond.
    const ano::Json& known_device();
    /// "/devices/0xDC" + `rest`.
    std::string target(const std::string& rest = {});
    /// "SimFC (0xDC)"
    std::string device_words();

    /// Whether the user agrees, by --yes or by answering the question. Throws UsageError if there is no terminal.
    bool may(const std::string& question);
    /// Throws UsageError if may() would throw it. `what`: the beginning of the error.
    void must_be_able_to_ask(const std::string& what) const;
    /// To be called before the first request of a command that acts or writes: read-only clients can't take the place of its jobs
    /// (?to_act).
    void will_act() noexcept { acts_ = true; }
    /// Whether the file may be written: it does not exist, or the user agrees to replace it. Throws UsageError if a question is
    /// needed and there is no terminal.
    bool may_write(const std::string& path);

private:
    class Exchange;
    ano::Json choose(const ano::Json& found) const;    // the matches of --device

    const DeviceOptions& options_;
    Streams& streams_;
    bool acts_ = false;
    struct Loop;
    std::unique_ptr<Loop> loop_;    // contains the device, once it is chosen
};

}    // namespace anoctl
