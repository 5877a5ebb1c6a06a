// Passes all received, sent and dropped frames to the watchers.
#pragma once
#include <gateway/forwarder.hpp>
#include <sys/alarm.hpp>
#include <sys/batch_memory.hpp>
#include <watch/frame_filter.hpp>
#include <watch/watch_queue.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace anogate {

class Gateway;

/// A receiver of frames, by its queue.
class Watcher {
public:
    static constexpr std::size_t max_waiting = 1024 * 1024;    // bytes

    /// The queue has new items. Called from the loop, never while a frame is forwarded; the watcher must not remove itself in the
    /// call.
    virtual void more() = 0;
    WatchQueue queue{max_waiting};

protected:
    ~Watcher() = default;
};

/// No cost per frame without watchers. A frame is copied once for all watchers with the same filter, into a batch. The batch is
/// put into the queue of each watcher after the time `batch` of the settings, or shortly before, together with another frame,
/// because the loop is awake then. While all their queues are full, frames are only counted.
class FrameWatch final : private Forwarder::Observer {
public:
    static constexpr std::size_t batch_size = 64 * 1024;    // bytes; a batch of this size is delivered at once

    /// `gateway` must outlive it.
    explicit FrameWatch(Gateway& gateway);
    ~FrameWatch();
    FrameWatch(const FrameWatch&) = delete;
    FrameWatch& operator=(const FrameWatch&) = delete;

    /// From now until remove(), `watcher` gets the tables and then frames.
    void add(Watcher& watcher, const FrameFilterSettings& settings);
    /// `watcher` gets no more frames; earlier ones are in its queue.
    void remove(Watcher& watcher);
    /// Ends the current batch and puts it into the queue of an added `watcher`, without calling it.
    void catch_up(const Watcher& watcher);
    /// Changes the settings of an added `watcher`. No frame that passes both the old and the new settings is lost.
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
        std::shared_ptr<std::string> batch;    // nullptr: no frame since the last one; its size is its capacity
        std::size_t filled = 0;                // bytes used of `batch`
        std::size_t usual = 0;                 // bytes of a batch
        bool goes_on = false;                  // frames are so frequent that the next batch begins at once
        Alarm due;
    };
    struct Event {
        Direction direction;
        LinkId link;
        std::uint8_t channel;
        std::uint8_t cause;
        bool is_elsewhere = false;
        std::span<const std::uint8_t> raw{};
    };

    void received(const Channel& from, ano::FrameView frame, TimePoint arrived_at) override;
    void offered(const Channel&, ano::FrameView, ChannelId) override {}
    void dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) override;
    void refused(LinkId to, ano::FrameView frame, SendCause cause) override;
    void left(const Channel& to, ano::FrameView frame) noexcept override;
    void discarded(const Channel& to, ano::FrameView frame, SendCause cause) noexcept override;
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
    Alarm links_due_;    // after the removal of a link
    std::vector<std::unique_ptr<Stream>> streams_;
    BatchMemory memory_;
    WatchQueue::Tables tables_;
    std::uint64_t version_ = 0;    // of the Forwarder, for which the tables were made
    std::uint64_t real_ns_ = 0;    // offsets of the other clocks from that of TimePoint
    std::uint64_t boot_ns_ = 0;
};

}    // namespace anogate
