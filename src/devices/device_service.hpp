// The host engine for all devices and all clients: known devices, jobs, and which job uses which device.
//
// Flow:    DeviceService service{net};
//          add_device_routes(routes, service);      // requests of clients
//          service.hear(frame, now);                // every frame that passes, while net was told to listen
//          service.run(now);                        // when net was told to wake it
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <devices/device_net.hpp>
#include <devices/job.hpp>
#include <devices/notes.hpp>
#include <host/air_guard.hpp>
#include <host/description_cache.hpp>
#include <host/device.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

/// Why a job can't begin, as the answer to the client.
struct NotBegun {
    unsigned status = 400;
    std::string error;
    std::string what;
    std::shared_ptr<const Job> has_it{};    // the job that is using the device
};

/// What is known of one device.
struct DeviceReport {
    HeardAddress heard;
    std::optional<ano::host::DeviceInfo> info;
    std::optional<double> rate;    // frames a second
    std::optional<std::uint16_t> parameters;
    std::optional<unsigned> job;       // the one that is using it
    std::vector<std::string> notes;    // names of notes about unfinished work
};

/// Listens from the first request on until there was none for `idle_after`. Work that is not allowed in flight waits until the service has
/// listened for AirGuard::busy_for. Writes of other hosts before it listened are not known.
class DeviceService {
public:
    static constexpr std::size_t max_jobs = 64;    // running and ended ones
    static constexpr std::size_t max_running = 32;
    static constexpr std::size_t max_upgrades = 2;    // at the same time
    static constexpr long max_waiting = 16;    // clients waiting for jobs: half of the server's places stay for other requests
    static constexpr std::size_t max_results = std::size_t{8} << 20;    // bytes of ended jobs; the oldest are dropped first
    static constexpr ano::Duration kept_for = std::chrono::minutes{10};
    static constexpr ano::Duration between_write_backs = std::chrono::minutes{1};    // interval of tries while values are kept
    static constexpr ano::Duration idle_after = std::chrono::minutes{1};
    /// Minimum time between two reports of progress.
    static constexpr ano::Duration between_progress = std::chrono::milliseconds{100};

    /// `net` must outlive the service; `own`: the address of this host.
    explicit DeviceService(DeviceNet& net, std::uint8_t own = ano::address::host) : net_{net}, own_{own} {}
    ~DeviceService();
    DeviceService(const DeviceService&) = delete;
    DeviceService& operator=(const DeviceService&) = delete;

    /// To be called for each passing frame that is not from this host. Sends nothing. True: it answers this host, even if late or repeated.
    bool hear(ano::FrameView frame, ano::TimePoint now);
    void run(ano::TimePoint now);
    /// The gateway is stopping: sends nothing any more; every job ends and reports what is half done.
    void stop(ano::TimePoint now);

    /// A new job, or a running one that reads the same.
    std::variant<std::shared_ptr<Job>, NotBegun> begin(JobOrder order, ano::TimePoint now);
    /// The job ends soon. False: it was over already.
    bool cancel(Job& job, ano::TimePoint now);
    /// A client with ?while_connected has disconnected: cancels the job if nobody else needs it.
    void left(Job& job);
    /// POST /jobs/J/next. Returns why it can't go on: it is not waiting, or is not allowed now. std::nullopt: it goes on.
    std::optional<NotBegun> go_on(Job& job, ano::TimePoint now);

    /// To be held by each client that waits for a job.
    std::shared_ptr<void> waiting_client() const { return waiting_clients_; }
    bool has_room_for_a_client() const noexcept { return waiting_clients_.use_count() <= max_waiting; }

    std::shared_ptr<Job> job(unsigned id) const;
    /// In the order of their beginning.
    const std::vector<std::shared_ptr<Job>>& jobs() const noexcept { return jobs_; }

    /// The device that `word` means: an address, a name of an address, or the name that a device reports.
    std::variant<std::uint8_t, NotBegun> address_of(std::string_view word, ano::TimePoint now);
    std::vector<DeviceReport> devices(ano::TimePoint now);
    /// std::nullopt: nothing is known about it.
    std::optional<ano::host::DeviceInfo> info(std::uint8_t address) const;

    /// A note kept by an earlier run (DeviceNet::keep()). Old values of a calibration are written back as soon as that is allowed. False:
    /// the note is damaged and stays where it is.
    bool remember(std::string name, std::string text);

    /// `call` is called for each job that has ended, before its waiting clients.
    void on_end(std::function<void(const Job&)> call) { tells_end_ = std::move(call); }

    DeviceNet& net() noexcept { return net_; }
    std::uint8_t own() const noexcept { return own_; }

private:
    struct Known {
        std::optional<ano::host::DeviceInfo> info;    // the last known; the device may be absent
        std::unique_ptr<ano::host::Device> device;    // nullptr: not asked yet
        std::uint32_t frames = 0;                     // since `counted_since`
        ano::TimePoint counted_since{};
        std::optional<double> rate;
        std::optional<ano::TimePoint> heard_at{};
        unsigned acted_before = 0;    // jobs with a lower id began before the last frame that changed the device
    };

    void use(ano::TimePoint now);
    std::vector<HeardAddress> heard(ano::TimePoint now);
    ano::host::Device& device(std::uint8_t address);
    WorkPlace place(const Job& job);
    std::optional<NotBegun> refusal(const JobOrder& order, ano::TimePoint now);
    std::shared_ptr<Job> holder(std::uint8_t address) const;
    std::shared_ptr<Job> shared(const JobOrder& order) const;
    void write_back(ano::TimePoint now);
    void acted(std::uint8_t address);
    void cut_off(Job& job, ano::TimePoint now);
    void forget_results();
    bool make_room(ano::TimePoint now);
    std::size_t running() const;
    std::size_t upgrades() const;
    void advance(const std::shared_ptr<Job>& job, ano::TimePoint now);
    void send_all(ano::TimePoint now);
    void fail(std::uint8_t address, std::uint8_t id, bool acts, const std::string& why, ano::TimePoint now);
    void finish(Job& job, WorkEnd end, ano::TimePoint now);
    void look(Job& job, ano::TimePoint now);
    void changed(Job& job);
    void await(ano::TimePoint now);
    bool answers_at_port(std::uint8_t source, std::uint8_t port);
    void count(Known& known, ano::TimePoint now);

    DeviceNet& net_;
    Notes notes_{net_};
    std::uint8_t own_;
    std::array<std::unique_ptr<Known>, 256> known_;
    std::uint32_t asked_ports_ = 0;    // a bit for each port id that has a device in known_
    ano::host::DescriptionCache cache_;
    ano::host::AirGuard guard_;
    std::unique_ptr<ano::host::Device> everybody_;    // for scans
    std::vector<std::shared_ptr<Job>> jobs_;
    std::size_t at_work_ = 0;    // jobs that have begun and not ended
    unsigned next_id_ = 1;
    std::optional<ano::TimePoint> listens_since_;
    ano::TimePoint used_at_{};
    std::shared_ptr<int> waiting_clients_ = std::make_shared<int>();    // its use count - 1 is the number of waiting clients
    std::map<std::string, ano::TimePoint> write_back_due_;              // by note: when to try
    std::optional<ano::TimePoint> write_back_at_;                       // std::nullopt: nothing to write back
    std::function<void(const Job&)> tells_end_;
    bool runs_ = false;
    bool stopped_ = false;
};

}    // namespace anogate
