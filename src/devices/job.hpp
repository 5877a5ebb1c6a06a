// One thing that is asked of a device, from its beginning to what came of it.
#pragma once
#include <ano/time.hpp>
#include <devices/work.hpp>
#include <host/air_guard.hpp>

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
    scan,
};

enum class JobState : std::uint8_t { running, waiting, done, failed, cancelled };

/// What is to be done to whom, and who asked.
struct JobOrder {
    JobKind kind{};
    ano::host::Deed deed = ano::host::Deed::read;
    std::optional<std::uint8_t> address;    // nothing: everybody
    bool force = false;                     // although it flies
    std::string client;                     // who asked, as he calls himself
    std::function<std::unique_ptr<Work>(const WorkPlace& place)> work;
    std::function<std::string()> result{};    // JSON, of a work that has none of its own
    std::string shared_as{};                  // one that reads: who asks for the same meanwhile gets what this gets; empty: alone
};

struct Job {
    unsigned id = 0;
    JobOrder order;
    JobState state = JobState::running;
    std::unique_ptr<Work> work;                         // null when it has ended, and until it begins
    std::optional<WorkEnd> end;                         // its result is in the next
    std::shared_ptr<const std::string> result{};        // a line; null: there is none
    mutable std::weak_ptr<const std::string> line{};    // of job_line(), as long as somebody has it
    std::string message;
    bool has_acted = false;       // something that changes the device left
    bool is_cancelled = false;    // somebody wants its end, which may take a while
    std::string refused;          // why its frames may not leave: it ends
    std::string step;             // JSON
    ano::host::Progress progress{};
    ano::TimePoint begins_at{};    // not before: until then it is listened whether it may
    ano::TimePoint ended_at{};
    std::uint64_t version = 0;    // grows whenever there is something to tell
    ano::TimePoint told_at{};     // of progress
    std::size_t needed_by = 0;    // clients who want it to end when they go
    bool goes_on = false;         // another waits for it who does not
    std::vector<std::function<void(const Job&)>> on_end;
    std::vector<std::function<void()>*> on_change;    // of those who watch

    bool is_over() const noexcept { return end.has_value(); }
    bool is_writing() const noexcept { return order.deed != ano::host::Deed::read; }
};

std::string_view name_of(JobKind kind) noexcept;
std::string_view name_of(JobState state) noexcept;
/// What the progress of a kind counts in: "bytes".
std::string_view unit_of(JobKind kind) noexcept;
/// Jobs of this kind ask by frames of this id.
bool asks_by(JobKind kind, std::uint8_t id) noexcept;

/// The object that is told of it, without its result.
nlohmann::ordered_json job_json(const Job& job);
/// The same with its result, as a line. Of a job that is over all who have it have the same text: a result may be large.
std::shared_ptr<const std::string> job_line(const Job& job);
/// What came of a job, without the job, as a line; the same.
std::shared_ptr<const std::string> end_line(const Job& job);
/// JSON that every program reads without loss (json_line.hpp).
std::string exact_json(const std::string& text);
/// "job 7 (firmware, of anoctl)"
std::string words_of(const Job& job);

}    // namespace anogate
