// A piece of work with a device: progress, cancel, and an end that tells what happened.
#pragma once
#include <host/device.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace ano::host {

/// How a task ended.
enum class Ending : std::uint8_t {
    done,
    timeout,        // the device does not answer
    incomplete,     // it answers, but not everything
    unknown,        // no answer to what may not be repeated: it may have been carried out
    refused,        // the device does not want it
    failed,         // the device tried, and it did not work
    invalid,        // never sent: it would be wrong
    unsupported,    // the device does not say what is needed
    cancelled,
};
inline constexpr std::array<std::string_view, 9> ending_names{"done",   "timeout", "incomplete",  "unknown",  "refused",
                                                              "failed", "invalid", "unsupported", "cancelled"};
constexpr std::string_view name_of(Ending ending) noexcept { return ending_names[static_cast<std::size_t>(ending)]; }

struct End {
    Ending ending = Ending::done;
    std::string what;    // for people: a clause; empty when done and nothing is to be said
    Evidence evidence{};
};

/// In whatever the task counts: descriptions and values, waypoints, bytes. `total` is 0 as long as it is not known.
struct Progress {
    std::size_t done = 0;
    std::size_t total = 0;
};

/// The device must outlive its tasks. A task runs once from its start(); what it found out stays with it.
class Task : public Asker {
public:
    explicit Task(Device& device) : device_{device} {}
    virtual ~Task() { device_.forget(*this); }
    Task(const Task&) = delete;
    Task& operator=(const Task&) = delete;

    /// Nothing until it has ended.
    const std::optional<End>& end() const noexcept { return end_; }
    virtual Progress progress() const noexcept { return {}; }
    /// From its first request on. Who answers always just in time is given up then; a last request may still be waited for.
    virtual Duration max_duration() const noexcept { return std::chrono::minutes{2}; }
    /// Ends it; the end says what is half done. A task that has to put something back first ends when it has.
    virtual void cancel(TimePoint now);
    /// Called when it ends, last of all. The task may not be destroyed in it.
    void on_end(std::function<void(TimePoint)> told) { told_ = std::move(told); }

protected:
    Device& device() noexcept { return device_; }
    const Device& device() const noexcept { return device_; }
    /// Sends `request`, or ends as invalid.
    void ask(const Request& request, TimePoint now);
    /// Behind why it was given up: what that leaves undone.
    virtual std::string_view half_done() const noexcept { return {}; }
    /// Before a request: true, and it has ended, when it takes longer than it may.
    bool gives_up(TimePoint now);
    /// Ends, once; what is on its way is forgotten.
    void finish(End end, TimePoint now);
    /// Without an answer to the question for `step`. `likely` is what it means of a device that is heard all the same, as a clause.
    void finish_silent(std::string_view step, const Evidence& evidence, TimePoint now, std::string_view likely = {});
    /// The same of an order: without an acknowledgement.
    void finish_unacknowledged(std::string_view order, const Evidence& evidence, TimePoint now, std::string_view likely);
    /// Ends as `other` did.
    void finish_as(const Task& other, TimePoint now);

private:
    void finish_unanswered(const std::string& heard_but, std::string_view step, const Evidence& evidence, TimePoint now,
                           std::string_view likely);

    Device& device_;
    std::optional<TimePoint> begun_at_;
    std::optional<End> end_;
    std::function<void(TimePoint)> told_;
};

/// "0xDC", as addresses are written for people.
std::string hex_of(std::uint8_t address);

}    // namespace ano::host
