// Reports every frame that is received, sent or dropped to the watchers.
#pragma once
#include <gateway/forwarder.hpp>
#include <sys/alarm.hpp>
#include <sys/batch_memory.hpp>
#include <watch/frame_filter.hpp>
#include <watch/watch_queue.hpp>

#include <memory>
#include <string>
#include <vector>

namespace anogate {

class Gateway;

/// Receives the frames in its queue.
class Watcher {
public:
    static constexpr std::size_t max_waiting = 1024 * 1024;    // bytes

    /// There is more in the queue. Called from the loop, never while a frame is forwarded; it does not remove itself in the call.
    virtual void more() = 0;
    WatchQueue queue{max_waiting};

protected:
    ~Watcher() = default;
};

/// Without watchers it costs a frame nothing. A frame is copied once for all watchers with the same filter: into a batch, which is put
/// into the queue of each when the time `batch` of the settings is over, or shortly before together with another frame, because the loop
/// is awake then. While all their queues are full, frames are only counted.
class FrameWatch final : private Forwarder::Observer {
public:
    static constexpr std::size_t batch_size = 64 * 1024;    // bytes; one that is as large does not wait

    /// `gateway` outlives it.
    explicit FrameWatch(Gateway& gateway);
    ~FrameWatch();
    FrameWatch(const FrameWatch&) = delete;
    FrameWatch& operator=(const FrameWatch&) = delete;

    /// `watcher` gets frames from now on, until remove(); the tables come first.
    void add(Watcher& watcher, const FrameFilterSettings& settings);
    /// `watcher` gets no more frames; those until now are in its queue.
    void remove(Watcher& watcher);
    /// Puts into the queue of an added `watcher` what was to wait for its batch, without calling it.
    void catch_up(const Watcher& watcher);
    /// Changes the settings of an added `watcher`. It loses no frame that passes the old and the new settings.
    void change(Watcher& watcher, const FrameFilterSettings& settings);

private:
    // The watchers with the same settings.
    struct Stream {
        Stream(AlarmClock& alarms, const FrameFilterSettings& its_settings)
            : settings{its_settings}, filter{its_settings}, due{alarms, [this] { deliver(); }} {}
        static bool takes(Watcher& watcher, const WatchQueue::Batch& ended);
        void end_batch(TimePoint now);
        void deliver();
        bool is_nearly_due(TimePoint now) const noexcept { return batch && due.is_due(now + settings.batch / 5); }
        void leave_soon() noexcept;

        FrameFilterSettings settings;
        FrameFilter filter;
        std::vector<Watcher*> watchers;
        std::shared_ptr<std::string> batch;    // nullptr: nothing was recorded since the last; as large as there is room
        std::size_t filled = 0;                // bytes of it
        std::size_t usual = 0;                 // bytes of a batch
        bool goes_on = false;                  // frames come so often that the next batch begins at once
        Alarm due;
    };
    struct Event {
        Direction direction;
        LinkId link;
        std::uint8_t channel;
        std::uint8_t cause;
        bool is_elsewhere = false;
    };

    void received(const Channel& from, ano::FrameView frame, TimePoint arrived_at) override;
    void offered(const Channel&, ano::FrameView, ChannelId) override {}
    void dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) override;
    void refused(LinkId to, ano::FrameView frame, SendCause cause) override;
    void left(const Channel& to, ano::FrameView frame) noexcept override;
    void gave_up(const Channel& to, ano::FrameView frame, SendCause cause) noexcept override;
    void removed(LinkId link) override;

    void join(Watcher& watcher, const FrameFilterSettings& settings);
    void note(const Event& event, ano::FrameView frame, TimePoint at) noexcept;
    void record(Stream& stream, const Event& event, ano::FrameView frame, TimePoint at);
    void begin_batch(Stream& stream);
    void read_clocks();
    void observe();
    bool has_other_links() const noexcept;
    void look_at_links();

    Gateway& gateway_;
    Alarm links_due_;    // a link is gone
    std::vector<std::unique_ptr<Stream>> streams_;
    BatchMemory memory_;
    WatchQueue::Tables tables_;
    std::uint64_t version_ = 0;    // of the forwarder, that the tables are of
    std::uint64_t real_ns_ = 0;    // what the other clocks are ahead of that of TimePoint
    std::uint64_t boot_ns_ = 0;
};

}    // namespace anogate
