// The host engine for all devices and all clients: who is there, who is asked what, and who has which device.
//
// Flow:    DeviceService service{net};
//          add_device_routes(routes, service);      // what clients say
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

/// Why something can't begin, as the answer to who asked for it.
struct NotBegun {
    unsigned status = 400;
    std::string error;
    std::string what;
    std::shared_ptr<const Job> has_it{};    // the job that has the device
};

/// What is known of one device.
struct DeviceReport {
    HeardAddress heard;
    std::optional<ano::host::DeviceInfo> info;
    std::optional<double> rate;    // frames a second
    std::optional<std::uint16_t> parameters;
    std::optional<unsigned> job;       // that has it
    std::vector<std::string> notes;    // what is kept of it that was not ended: the names
};

/// It listens from the first question on until nobody asked for `idle_after`. What may not be done in the air waits until it has listened
/// for AirGuard::busy_for; a write of another host before it listened is not known.
class DeviceService {
public:
    static constexpr std::size_t max_jobs = 64;    // that run and that ended
    static constexpr std::size_t max_running = 32;
    static constexpr std::size_t max_upgrades = 2;    // that run
    static constexpr long max_waiting = 16;           // clients who wait for jobs: half of the door's places are for all else
    static constexpr std::size_t max_results = std::size_t{8} << 20;    // bytes of those that ended: the oldest go first
    static constexpr ano::Duration kept_for = std::chrono::minutes{10};
    static constexpr ano::Duration between_write_backs = std::chrono::minutes{1};    // tried again while values are kept
    static constexpr ano::Duration idle_after = std::chrono::minutes{1};
    /// Progress is told so often at most.
    static constexpr ano::Duration between_progress = std::chrono::milliseconds{100};

    /// `net` outlives it; `own` is the address of the host.
    explicit DeviceService(DeviceNet& net, std::uint8_t own = ano::address::host) : net_{net}, own_{own} {}
    ~DeviceService();
    DeviceService(const DeviceService&) = delete;
    DeviceService& operator=(const DeviceService&) = delete;

    /// A frame that passes and that is not of this host. Sends nothing. True: it answers this host, be it late or once more.
    bool hear(ano::FrameView frame, ano::TimePoint now);
    void run(ano::TimePoint now);
    /// The end is near: nothing is sent any more, and every job ends with what is half done.
    void stop(ano::TimePoint now);

    /// A new one, or one that runs and reads the same.
    std::variant<std::shared_ptr<Job>, NotBegun> begin(JobOrder order, ano::TimePoint now);
    /// It ends soon. False: it was over.
    bool cancel(Job& job, ano::TimePoint now);
    /// The same for who asked for it and leaves, where it ends then.
    void left(Job& job);
    /// POST /jobs/J/next. Why it does not go on: it does not wait, or may not be done now. Nothing: it goes on.
    std::optional<NotBegun> go_on(Job& job, ano::TimePoint now);

    /// One client waits for a job as long as this is kept.
    std::shared_ptr<void> waiting_client() const { return waiting_clients_; }
    bool has_room_for_a_client() const noexcept { return waiting_clients_.use_count() <= max_waiting; }

    std::shared_ptr<Job> job(unsigned id) const;
    /// The one that began last is last.
    const std::vector<std::shared_ptr<Job>>& jobs() const noexcept { return jobs_; }

    /// The device that `word` stands for: an address, a name for one, or what it calls itself.
    std::variant<std::uint8_t, NotBegun> address_of(std::string_view word, ano::TimePoint now);
    std::vector<DeviceReport> devices(ano::TimePoint now);
    /// Nothing is known of it: empty.
    std::optional<ano::host::DeviceInfo> info(std::uint8_t address) const;

    /// What a run before this kept (DeviceNet::keep()). Old values of a calibration are written back as soon as that may be. False:
    /// it is damaged, and stays where it is.
    bool remember(std::string name, std::string text);

    /// `call` is called with each job that has ended, before those who wait for it.
    void on_end(std::function<void(const Job&)> call) { tells_end_ = std::move(call); }

    DeviceNet& net() noexcept { return net_; }
    std::uint8_t own() const noexcept { return own_; }

private:
    struct Known {
        std::optional<ano::host::DeviceInfo> info;    // as last told, though it may be away
        std::unique_ptr<ano::host::Device> device;    // null: nothing was asked yet
        std::uint32_t frames = 0;                     // since `counted_since`
        ano::TimePoint counted_since{};
        std::optional<double> rate;
        std::optional<ano::TimePoint> heard_at{};
        unsigned acted_before = 0;    // jobs from this number on began behind the last frame that changes it
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
    std::unique_ptr<ano::host::Device> everybody_;    // of a scan
    std::vector<std::shared_ptr<Job>> jobs_;
    std::size_t at_work_ = 0;    // jobs that have begun and not ended
    unsigned next_id_ = 1;
    std::optional<ano::TimePoint> listens_since_;
    ano::TimePoint used_at_{};
    std::shared_ptr<int> waiting_clients_ = std::make_shared<int>();    // one more owner for each
    std::map<std::string, ano::TimePoint> write_back_due_;              // of each note, when it was tried
    std::optional<ano::TimePoint> write_back_at_;                       // nothing: there is nothing to write back
    std::function<void(const Job&)> tells_end_;
    bool runs_ = false;
    bool stopped_ = false;
};

}    // namespace anogate
