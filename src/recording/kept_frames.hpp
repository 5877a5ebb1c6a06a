// Keeps the latest frames in memory (keep_last), and writes a recording of them.
#pragma once
#include <record/recording_writer.hpp>
#include <record/ring.hpp>
#include <watch/frame_watch.hpp>
#include <watch/watched_record.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Records as a watcher of the gateway received them, with the names for their numbers. Immutable, so a thread may read it.
struct FramesPart {
    WatchQueue::Batch batch;
    std::shared_ptr<const RecordedNames> names;
    RecordedLoss lost{};    // before the batch; the names of the frames are in lost_names
    std::string lost_names{};
    std::uint64_t frames = 0;
};

struct KeptFrames {
    std::vector<FramesPart> parts;
    RecordingHead head;

    std::uint64_t frames() const noexcept;
};

/// Encodes a recording of them in parts.
class KeptFramesWriting {
public:
    KeptFramesWriting(KeptFrames frames, RecordingFormat format, RecordingOptions options = {});

    /// Appends the next part to `into`. False: that was the last one.
    bool next(std::string& into);

private:
    KeptFrames frames_;
    RecordingFormat format_;
    RecordingOptions options_;
    std::unique_ptr<RecordingWriter> writer_;    // nullptr: not begun
    DecodingPtr decoding_;                       // as passed to writer_ last
    std::size_t part_ = 0;
    std::string_view rest_;    // the unread part of the batch
    bool in_part_ = false;
};

/// Keeps the batches of a watcher, without copying frames.
class FrameMemory final : private Watcher {
public:
    static constexpr std::size_t max_bytes = 16 * 1024 * 1024;

    FrameMemory(Gateway& gateway, FrameWatch& watch, const FrameFilterSettings& filter, ano::Duration span);
    ~FrameMemory();
    FrameMemory(const FrameMemory&) = delete;
    FrameMemory& operator=(const FrameMemory&) = delete;

    /// Sets what is kept from now on. Frames already in memory stay, as far as they are within the last `span`.
    void change(const FrameFilterSettings& filter, ano::Duration span);
    /// Takes in the frames that passed until now, so that a change does not apply to them.
    void catch_up();
    /// The frames of the last `span`, up to the last one that passed.
    KeptFrames frames();
    struct Figures {
        ano::Duration span{}, reach{};
        std::uint64_t frames = 0, bytes = 0;
    };
    Figures figures();

private:
    void more() override;
    void renew_names();

    Gateway& gateway_;
    FrameWatch& watch_;
    Ring<FramesPart> ring_;
    WatchQueue::Tables tables_;    // nullptr: not yet
    std::shared_ptr<const RecordedNames> names_;
    std::size_t cost_of_names_ = 0;    // to be added to the cost of the next part
    LostFrames lost_;                  // since the last part
};

/// Calls `call` when a device logs a fault: a received frame 0xA0 with the colour red. Only devices whose address is local count:
/// those on a serial port, CAN or another link that is not a network, and those whose address is pinned to the link.
class FaultTrigger final : private Watcher {
public:
    FaultTrigger(Gateway& gateway, FrameWatch& watch, std::function<void()> call);
    ~FaultTrigger();
    FaultTrigger(const FaultTrigger&) = delete;
    FaultTrigger& operator=(const FaultTrigger&) = delete;

    /// Processes the frames that passed until now at once.
    void catch_up();

private:
    void more() override;
    bool is_at_home(const FrameRecord& record) const;

    Gateway& gateway_;
    FrameWatch& watch_;
    std::function<void()> call_;
};

}    // namespace anogate
