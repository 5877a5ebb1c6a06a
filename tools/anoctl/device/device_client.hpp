// What the commands for devices share: where the device is asked, which device it is, jobs and questions.
#pragma once
#include "job_view.hpp"

#include <anoctl/anoctl.hpp>
#include <anoctl/gateway.hpp>

#include <ano_json/frame_json.hpp>
#include <http/request.hpp>

#include <memory>
#include <string>
#include <utility>

namespace anoctl {

/// A job failed, and there is more to say of it than why: what became of each part.
struct JobFailure : Failure {
    JobFailure(const std::string& why, std::string what_there_is) : Failure{why}, result{std::move(what_there_is)} {}
    std::string result;    // JSON
};

struct DeviceOptions {
    GatewayOptions gateway;
    std::string link, device, command;
    bool json = false, yes = false;

    /// Declares --link, --control, --json of `command`. `self` lives as long as the run.
    static void add_place(Options& declared, DeviceOptions& self, const char* command);
    /// These and --device.
    static void add(Options& declared, DeviceOptions& self, const char* command);
    /// And --yes.
    static void add_yes(Options& declared, DeviceOptions& self);
};

class DeviceClient {
public:
    /// `options` and `streams` outlive it. Throws UsageError for a LINK that is none.
    DeviceClient(const DeviceOptions& options, Streams& streams);
    ~DeviceClient();
    DeviceClient(const DeviceClient&) = delete;
    DeviceClient& operator=(const DeviceClient&) = delete;

    /// What a route answers that asks no device. Throws Failure.
    ano::Json ask(const std::string& method, const std::string& target, std::string body = {});
    /// Asks for a job and follows it to its end: its result. Throws Failure (JobFailure where there is a result) with the words of what went wrong; Interrupted when it was
    /// cancelled by Ctrl-C, with what is half done.
    ano::Json run(anogate::http::Request request, JobView& view);
    /// The same, shown by a bar on a terminal.
    ano::Json run(const std::string& method, const std::string& target, std::string body = {});

    /// The devices that were heard; `scan`: everybody is asked who he is.
    ano::Json devices(bool scan);
    /// The device that is meant: {"address", "name"…}, as --device says, else the only one there. Throws UsageError with the list when there
    /// are several, Failure when there is none.
    const ano::Json& device();
    /// The same with its "name" and "dev_id", for which it is asked when they are not known; as it is when it does not answer.
    const ano::Json& known_device();
    /// "/devices/0xDC" + `rest`.
    std::string target(const std::string& rest = {});
    /// "SimFC (0xDC)"
    std::string device_words();

    /// Whether it may be done: --yes, or a person says so. Throws UsageError where nobody can be asked.
    bool may(const std::string& question);
    /// Throws UsageError at once where may() would.
    void must_be_able_to_ask(const std::string& what) const;
    /// Whether the file may be written: it is not there, or it may be replaced. Throws UsageError where nobody can be asked.
    bool may_write(const std::string& path);

private:
    class Exchange;
    ano::Json choose(const ano::Json& found) const;    // those that --device may mean

    const DeviceOptions& options_;
    Streams& streams_;
    struct Loop;
    std::unique_ptr<Loop> loop_;    // with the device, once it is chosen
};

}    // namespace anoctl
