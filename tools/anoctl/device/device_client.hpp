// Shared by the commands for devices: the access to the device, its choice, jobs, and questions to the user.
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

/// A job failed, and its result says what became of each part.
struct JobFailure : Failure {
    JobFailure(const std::string& why, std::string what_there_is) : Failure{why}, result{std::move(what_there_is)} {}
    std::string result;    // JSON
};

/// What was read of the device is no longer so, and nothing was sent: the client may read it again.
struct Outdated : Failure {
    using Failure::Failure;
    static constexpr std::string_view what_of_commands = "commands_changed";    // `what` of the answer
};

struct DeviceOptions {
    GatewayOptions gateway;
    std::string link, device, command;
    bool json = false, yes = false;
    bool asks_nothing_first = false;    // with --link: a device named by its address is not looked for

    /// Declares --link, --control, --json of `command`. `self` lives as long as the run.
    static void add_place(Options& declared, DeviceOptions& self, const char* command);
    /// Declares these and --device.
    static void add(Options& declared, DeviceOptions& self, const char* command);
    /// Declares --yes.
    static void add_yes(Options& declared, DeviceOptions& self);
};

class DeviceClient {
public:
    /// `options` and `streams` outlive it. Throws UsageError for an invalid LINK.
    DeviceClient(const DeviceOptions& options, Streams& streams);
    ~DeviceClient();
    DeviceClient(const DeviceClient&) = delete;
    DeviceClient& operator=(const DeviceClient&) = delete;

    /// The response of a route that starts no job. Throws Failure.
    ano::Json ask(const std::string& method, const std::string& target, std::string body = {});
    /// Starts a job and follows it to its end; returns its result. Throws Failure (JobFailure when there is a result, Outdated) with the
    /// error, and Interrupted, with what is half done, when it was cancelled by Ctrl-C.
    ano::Json run(anogate::http::Request request, JobView& view);
    /// The same, with a progress bar on a terminal.
    ano::Json run(const std::string& method, const std::string& target, std::string body = {});

    /// The answer with all devices: those that were heard, and which of them are lost; `scan`: asks all for their names first.
    ano::Json device_list(bool scan);
    /// Those that were heard.
    ano::Json devices(bool scan);
    /// The chosen device, {"address", "name"…}: that of --device, else the only one. Throws UsageError with the list when there are
    /// several, Failure when there is none.
    const ano::Json& device();
    /// The same with its "name" and "dev_id": asks the device when they are not known. Without them when it does not answer.
    const ano::Json& known_device();
    /// "/devices/0xDC" + `rest`.
    std::string target(const std::string& rest = {});
    /// "SimFC (0xDC)"
    std::string device_words();

    /// Whether the user agrees: by --yes, or by answering the question. Throws UsageError without a terminal.
    bool may(const std::string& question);
    /// Throws UsageError at once where may() would.
    void must_be_able_to_ask(const std::string& what) const;
    /// To be called before the first request of what acts or writes: its questions get places by that right.
    void will_act() noexcept { acts_ = true; }
    /// Whether the file may be written: it does not exist, or the user agrees to replace it. Throws UsageError without a terminal.
    bool may_write(const std::string& path);

private:
    class Exchange;
    ano::Json choose(const ano::Json& found) const;    // those that match --device

    const DeviceOptions& options_;
    Streams& streams_;
    bool acts_ = false;
    struct Loop;
    std::unique_ptr<Loop> loop_;    // contains the device, once it is chosen
};

}    // namespace anoctl
