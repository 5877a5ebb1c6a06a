// The host engine for all devices and all clients: known devices, jobs, and the assignment of devices to jobs.
//
// Flow:    DeviceService service{net};
//          add_device_routes(routes, service);      // requests of clients
//          service.hear(frame, now);                // every passing frame, after net.listen(true)
//          service.run(now);                        // at the time of net.wake()
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <devices/alarm_feed.hpp>
#include <devices/alarm_limits.hpp>
#include <devices/crash_journal.hpp>
#include <devices/device_log.hpp>
#include <devices/device_net.hpp>
#include <devices/device_texts.hpp>
#include <devices/fair_places.hpp>
#include <devices/job.hpp>
#include <devices/line_stream.hpp>
#include <devices/loss_watch.hpp>
#include <host/air_guard.hpp>
#include <host/description_cache.hpp>
#include <host/device.hpp>
#include <host/telemetry_pace.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

/// Why a job can't start, as the answer to the client.
struct NotBegun {
    ano::Fault fault;
    std::string what;
    std::shared_ptr<const Job> has_it{};    // the job that is using the device

    unsigned status() const noexcept { return fault.status(); }
};

/// The known data of one device.
struct DeviceReport {
    HeardAddress heard;
    std::optional<ano::host::DeviceInfo> info;
    std::optional<double> rate;    // frames a second
    std::optional<std::uint16_t> parameters;
    std::optional<unsigned> job;       // the job that is using it
    std::vector<std::string> notes;    // names of notes about unfinished work
    DeviceTexts texts;
    std::uint32_t limits = 0;       // AlarmLimits::version()
    std::uint64_t red_lines = 0;    // of its log
};

/// Listens from the first request until `idle_after` after the last one, and longer while a device with known descriptions is
/// present: only a service that listens detects that the device was away. Work that is not allowed in flight waits until the
/// service has listened for 2 s. Writes of other hosts, which a job reports, are known only from the time it listens.
class DeviceService {
public:
    static constexpr std::size_t max_jobs = 64;                         // running and ended ones
    static constexpr FairPlaces running_places{24};                     // of jobs that run
    static constexpr std::size_t max_upgrades = 2;                      // at the same time
    static constexpr FairPlaces waiting_places{16};                     // of clients that wait for jobs
    static constexpr std::size_t max_results = std::size_t{8} << 20;    // bytes of ended jobs; the oldest are dropped first
    static constexpr ano::Duration kept_for = std::chrono::minutes{10};
    static constexpr ano::Duration between_write_backs = std::chrono::minutes{1};    // interval of attempts while values are to
                                                                                     // be written back
    static constexpr ano::Duration between_log_lines = std::chrono::milliseconds{20};    // for clients that follow the log
    static constexpr ano::Duration idle_after = std::chrono::minutes{1};
    /// Minimum time between two reports of progress.
    static constexpr ano::Duration between_progress = std::chrono::milliseconds{100};

    /// `net` must outlive the service; `own`: the address of this host.
    explicit DeviceService(DeviceNet& net, std::uint8_t own = ano::address::host) : net_{net}, own_{own} {
        curious_.yield_to_others(true);
    }
    /// Stores descriptions of parameters with DeviceNet::cache(), for the next run.
    void keep_descriptions();
    ~DeviceService();
    DeviceService(const DeviceService&) = delete;
    DeviceService& operator=(const DeviceService&) = delete;

    /// To be called for each passing frame that is not from this host. Sends nothing. True: the frame answers this host, even if
    /// late or repeated.
    bool receive(ano::FrameView frame, ano::TimePoint now);
    /// The same for a frame that was received at `place` although the route of its source leads elsewhere: it is not trusted, and
    /// running jobs for that device report it.
    void record_elsewhere(ano::FrameView frame, const std::string& place);
    /// The device did not carry out the action of a job, and reported the reason outside the protocol.
    void refuse(std::uint8_t address, const ano::Fault& why, ano::TimePoint now);
    /// `frame`, which DeviceNet::send() accepted, was dropped before it was sent.
    void not_sent(ano::FrameView frame, const Unsent& unsent, ano::TimePoint now);
    /// The link to the device at `address` was down, or is another one now: the data read before may belong to another device.
    void link_was_down(std::uint8_t address);
    /// To be called for each frame that this host sends without the service, so that its answers are expected.
    void sent_by_others(ano::FrameView frame, ano::TimePoint now);
    void run(ano::TimePoint now);
    /// The gateway is stopping: nothing is sent any more; every job ends and reports what is half done.
    void stop(ano::TimePoint now);

    /// Starts a new job, or returns a running one that reads the same. A device that was not heard yet is first asked for its
    /// device info, for 2 s.
    std::variant<std::shared_ptr<Job>, NotBegun> begin(JobOrder order, ano::TimePoint now);
    /// The job ends soon. False: it had ended already.
    bool cancel(Job& job, ano::TimePoint now);
    /// A client with ?while_connected has disconnected: cancels the job if no other client needs it.
    void left(Job& job);
    /// POST /jobs/J/next. Returns why the job can't continue: it is not waiting, or is not allowed now. std::nullopt: it
    /// continues.
    std::optional<NotBegun> go_on(Job& job, ano::TimePoint now);

    /// To be held by each client that waits for a job, also if has_room_for() is false for it.
    std::shared_ptr<void> waiting_client(const Requester& requester);
    bool has_room_for(const Requester& requester) const { return has_place_for(requester, waiting_places, *waiting_clients_); }

    std::shared_ptr<Job> job(unsigned id) const;
    /// In the order in which they started.
    const std::vector<std::shared_ptr<Job>>& jobs() const noexcept { return jobs_; }

    /// The device for `word`: an address, a configured name of an address, or the name that a device reports.
    std::variant<std::uint8_t, NotBegun> address_of(std::string_view word, ano::TimePoint now);
    std::vector<DeviceReport> devices(ano::TimePoint now);
    /// The encoding of its texts.
    const DeviceTexts& texts(std::uint8_t address);
    /// std::nullopt: not known.
    std::optional<ano::host::DeviceInfo> info(std::uint8_t address) const;

    /// Adds a note of an earlier run (DeviceNet::keep()). Old values of a calibration are written back as soon as that is
    /// allowed. False: the note is damaged and stays in place.
    bool remember(std::string name, std::string text);

    /// `call` is called for each job that has ended, before its waiting clients.
    void on_end(std::function<void(const Job&)> call) { on_end_ = std::move(call); }

    /// To be called for each log frame received where the route of its source leads, whether or not the service listens; see
    /// DeviceLog::hear().
    void record_log(ano::FrameView frame, std::string_view link, std::uint64_t time_ns,
                    DeviceLog::Origin origin = DeviceLog::Origin::known);
    const DeviceLog& log() const noexcept { return log_; }
    /// The clients that follow the log; woken at most every `between_log_lines`.
    LineClients& log_clients() noexcept { return log_clients_; }

    /// To be called for each passing frame of a message for which alarms().watch().wants() is true, whether or not the service
    /// listens. `raises_only`: see AlarmWatch::hear().
    void record_value(std::uint8_t source, const ano::Reading& reading, ano::TimePoint now, bool raises_only = false);
    /// To be called for each frame `mode` received where the route of its source leads, whether or not the service listens.
    void record_mode(ano::FrameView frame, ano::TimePoint now);
    /// The same for each other frame.
    void record_telemetry(std::uint8_t source, std::uint8_t id, ano::TimePoint now);
    /// A frame with the address of a device that stays_lost() was received at `place`, and is not known to be from the device:
    /// the place is reported until the device is heard.
    void record_elsewhere(std::uint8_t source, const std::string& place, ano::TimePoint now);
    bool was_received_elsewhere(std::uint8_t source) const noexcept { return losses_.was_received_elsewhere(source); }
    /// See LossWatch::stays_lost().
    bool stays_lost(std::uint8_t address) const noexcept { return losses_.stays_lost(address); }
    /// Vehicles, and devices that sent telemetry, until forget_values(); by address.
    std::vector<WatchedDevice> watched(ano::TimePoint now);
    /// The watched devices that are not heard any more, for clients that joined after the loss. A locked one is reported for
    /// AlarmFeed::locked_reported_for, any other one until it is heard again or forget_values() is called.
    std::vector<WatchedDevice> lost(ano::TimePoint now);
    /// The device was switched off: none of its values is in alarm until it is received again, and the device does not count as
    /// lost. False: it was not watched.
    bool forget_values(std::uint8_t address);
    AlarmFeed& alarms() noexcept { return alarms_; }
    /// To be called when a client of alarms() joins.
    void look_for_alarms(ano::TimePoint now);
    const AlarmLimits& limits() const noexcept { return limits_; }
    /// Uses and stores the limits, then calls `done` with "" or the error: why the next restart will lose them.
    void keep_limits(std::uint8_t address, AlarmLimits::List list, std::function<void(std::string fault)> done);
    /// Adds the content of a file that an earlier run stored. Returns its error; empty: none.
    std::string remember_limits(std::uint8_t address, const std::string& text);

    DeviceNet& net() noexcept { return net_; }
    std::uint8_t own() const noexcept { return own_; }

private:
    struct Known {
        std::optional<ano::host::DeviceInfo> info;    // the last known; the device may be absent
        std::unique_ptr<ano::host::Device> device;    // nullptr: not asked yet
        std::uint32_t frames = 0;                     // since `counted_since`
        ano::TimePoint counted_since{};
        std::optional<double> rate;
        bool sends_more_than_checks = false;
        bool acknowledged_as_port = false;    // at this device: the port id is not a device of its own, unless it sends other
                                              // frames
        std::optional<ano::TimePoint> heard_at{};
        ano::TimePoint asked_until{};    // to learn whether it is present
        DeviceTexts texts;
        bool has_logged_encoding = false;    // logged that the texts contradict the key of the link
        bool told_varying = false;           // logged that its device info varies
        std::uint32_t presence = 0;          // of the device that `texts` belongs to
        std::uint32_t signs = 0;             // of the device that `info` belongs to
        bool in_doubt = false;               // the link was down since `info`
        unsigned acted_before = 0;           // jobs with a lower id began before the last frame that changed the device
    };

    struct Nobody final : ano::host::Asker {
        void ended(const ano::host::Ended& /*ended*/, ano::TimePoint /*now*/) override {}
    };

    void use(ano::TimePoint now);
    std::vector<HeardAddress> heard(ano::TimePoint now);
    ano::host::Device& device(std::uint8_t address);
    static void learn_texts(Known& known, ano::FrameView frame) noexcept;
    WorkPlace place(const Job& job);
    std::optional<NotBegun> refusal(const JobOrder& order, ano::TimePoint now);
    bool may_go_unheard(const JobOrder& order, bool was_heard) const;
    std::shared_ptr<Job> holder(std::uint8_t address) const;
    std::shared_ptr<Job> shared(const JobOrder& order) const;
    void write_back(ano::TimePoint now);
    WorkPlace place_of(std::uint8_t address);
    std::vector<std::string> notes_to_show(std::uint8_t address, ano::TimePoint now);
    void report_note(const std::string& name, const std::string& text, bool is_warning);
    void write_back_soon(ano::TimePoint now);
    void info_is_asked(std::uint8_t address, ano::TimePoint now);
    bool is_queued(std::uint8_t address, ano::TimePoint now);
    void acted(std::uint8_t address, std::uint8_t id);
    void cut_off(Job& job, ano::TimePoint now);
    void forget_results();
    bool make_room(ano::TimePoint now);
    bool may_run_one_more(const Requester& requester) const;
    std::size_t upgrades() const;
    void advance(const std::shared_ptr<Job>& job, ano::TimePoint now);
    void send_all(ano::TimePoint now);
    void fail(std::uint8_t address, std::uint8_t id, bool acts, const ano::Fault& why, ano::TimePoint now);
    void fail_calls(std::uint8_t address, const ano::Fault& why, ano::TimePoint now);
    void end_refused(const std::shared_ptr<Job>& job, unsigned status, const ano::Fault& why, ano::TimePoint now);
    void finish(Job& job, WorkEnd end, ano::TimePoint now);
    void look(Job& job, ano::TimePoint now);
    void changed(Job& job);
    void await(ano::TimePoint now);
    void note_pace(std::uint8_t source, ano::TimePoint now) noexcept;
    void report_returned(std::uint8_t source, ano::TimePoint now);
    void run_feeds(ano::TimePoint now);
    void await_feeds();
    std::optional<ano::TimePoint> known_until(ano::TimePoint now) const;
    void forget_descriptions(ano::FrameView upgrade);
    void ask_whether_it_is_there(std::uint8_t address, ano::TimePoint now);
    void ask_who_it_is(std::uint8_t address, ano::TimePoint now, Nobody& asker);
    void confirm_info(Known& known, ano::FrameView frame, ano::TimePoint now);
    void report_varying_info(Known& known, std::uint8_t address);
    bool is_heard(Job& job, ano::TimePoint now);
    void note_other_writer(Job& job, ano::TimePoint now);
    std::optional<std::uint8_t> only_one_waiting() const;
    bool answers_at_port(std::uint8_t source, std::uint8_t port);
    void count(Known& known, ano::TimePoint now);

    DeviceNet& net_;
    Nobody nobody_;     // asks whether a device is present: any frame from it is enough
    Nobody curious_;    // asks whether it is still the same, after all other requests
    CrashJournal journal_{net_};
    DeviceLog log_;
    LineClients log_clients_;
    std::optional<ano::TimePoint> log_due_;    // when to wake log_clients()
    AlarmLimits limits_;
    AlarmFeed alarms_;
    LossWatch losses_;
    std::uint8_t own_;
    std::array<std::unique_ptr<Known>, 256> known_;
    std::array<ano::host::TelemetryPace, 256> paces_{};    // until there is a Device, which measures its own
    std::uint32_t asked_ports_ = 0;                        // a bit for each port id that has a device in known_
    ano::host::DescriptionCache cache_;
    ano::host::CommandCache commands_;
    ano::host::AirGuard guard_;
    std::unique_ptr<ano::host::Device> everybody_;    // for scans
    DeviceTexts default_texts_;
    std::vector<std::shared_ptr<Job>> jobs_;
    std::size_t at_work_ = 0;    // jobs that have started and not ended
    unsigned next_id_ = 1;
    std::optional<ano::TimePoint> listens_since_;
    ano::TimePoint used_at_{};
    std::shared_ptr<std::list<Requester>> waiting_clients_ = std::make_shared<std::list<Requester>>();
    std::map<std::string, ano::TimePoint> write_back_due_;    // by note: the next attempt
    std::map<std::string, std::string> last_reports_;         // by note: the last report
    std::optional<ano::TimePoint> write_back_at_;             // std::nullopt: nothing to write back
    std::function<void(const Job&)> on_end_;
    bool runs_ = false;
    bool stopped_ = false;
};

}    // namespace anogate
