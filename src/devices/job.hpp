// One request to a device, from its beginning to its result.
#pragma once
#include <ano/time.hpp>
#include <devices/works/work.hpp>
#include <host/air_guard.hpp>
#include <http/places.hpp>

#include <nlohmann/json_fwd.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

enum class JobKind : std::uint8_t {
    parameters,
    write,
    apply,
    action,
    commands,
    command,
    waypoints,
    put_waypoints,
    firmware,
    calibration,
    scan,    // the last one
};

enum class JobState : std::uint8_t { running, waiting, done, failed, cancelled };

/// The client of a job, for assigning places and turns: first by right, then by client.
struct Requester {
    http::Access access = http::Access::control;
    http::ClientId client_id{};
    bool acts = false;    // the job changes the device, or reads data that its client needs for such a job (?to_act)
    bool operator==(const Requester&) const = default;
    constexpr bool controls() const noexcept { return access == http::Access::control; }
};

/// The action, the device and the client of a job.
struct JobOrder {
    JobKind kind{};
    ano::host::Operation operation = ano::host::Operation::read;
    std::optional<std::uint8_t> address;    // std::nullopt: all devices
    bool force = false;                     // even in flight
    std::string client;                     // name of the client
    std::function<std::unique_ptr<Work>(const WorkPlace& place)> work;
    std::function<std::string()> result{};    // JSON; for works without a result of their own
    std::string shared_as{};                  // of a reading job: equal requests share its result; empty: not shared
    Requester requester{};
    bool is_first_frame = false;    // a command that is sent before any question, even to a device that was never heard
};

struct Job {
    unsigned id = 0;
    JobOrder order;
    JobState state = JobState::running;
    std::unique_ptr<Work> work;                         // nullptr before it starts and after it has ended
    std::optional<WorkEnd> end;                         // without its result, which is in `result`
    std::shared_ptr<const std::string> result{};        // one line; nullptr: none
    mutable std::weak_ptr<const std::string> line{};    // of job_line(), shared while in use
    std::string message;
    std::optional<ano::TimePoint> heard_by{};    // the device must be heard by then; std::nullopt: it was
    unsigned acted = 0;                          // frames that change the device that were sent for it
    bool is_cancelled = false;                   // cancelled, but ending may take a while
    ano::Fault refused;                          // why its frames can't be sent: the job is ending
    unsigned refused_status = 403;               // HTTP status for `refused`
    ano::Fault conflict;                         // other senders that write to its device, or answer with its address
    ano::Fault stopped;                          // why no frame to its device is sent
    std::string step;                            // JSON
    ano::host::Progress progress{};
    ano::TimePoint begins_at{};    // earliest start; until then the service listens whether the job is allowed
    ano::TimePoint ended_at{};
    std::uint64_t version = 0;       // increased with every change to report
    ano::TimePoint reported_at{};    // last report of progress
    std::size_t needed_by = 0;       // clients that cancel it when they disconnect
    bool goes_on = false;            // another client waits that does not cancel it by disconnecting
    std::vector<std::function<void(const Job&)>> on_end;
    std::vector<std::function<void()>*> on_change;    // of clients that watch it

    bool is_over() const noexcept { return end.has_value(); }
    bool is_writing() const noexcept { return order.operation != ano::host::Operation::read; }
};

std::string_view name_of(JobKind kind) noexcept;
std::string_view name_of(JobState state) noexcept;
/// The unit of the progress of a kind: "bytes".
std::string_view unit_of(JobKind kind) noexcept;
/// Whether jobs of this kind send questions with this id.
bool asks_by(JobKind kind, std::uint8_t id) noexcept;

/// The job as a JSON object, without its result.
nlohmann::ordered_json job_json(const Job& job);
/// The same with its result, as a line. For an ended job all callers share one text, because a result may be large.
std::shared_ptr<const std::string> job_line(const Job& job);
/// Only the result of the job, as a line; shared likewise.
std::shared_ptr<const std::string> end_line(const Job& job);
/// `text` (JSON) in the form that every program can read without loss (json_line.hpp).
std::string exact_json(const std::string& text);
/// "job 7 (firmware upgrade, by 192.168.1.5)"
ano::Fault name_of(const Job& job);

}    // namespace anogate
