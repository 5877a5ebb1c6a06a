// The frames of the last while, in memory (keep_last), and how they become a recording.
#pragma once
#include <daemon/frame_watch.hpp>
#include <daemon/watched_record.hpp>
#include <record/recording_writer.hpp>
#include <record/ring.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Records as a watcher of the gateway got them, and what their numbers meant. Nothing of it changes any more: it may go to a thread.
struct FramesPart {
    WatchQueue::Batch batch;
    std::shared_ptr<const RecordedNames> names;
    RecordedLoss lost{};    // before the batch; its names are in:
    std::string lost_names{};
    std::uint64_t frames = 0;
};

struct KeptFrames {
    std::vector<FramesPart> parts;
    RecordingHead head;

    std::uint64_t frames() const noexcept;
};

/// Makes a recording of them bit by bit.
class KeptFramesWriting {
public:
    KeptFramesWriting(KeptFrames frames, RecordingFormat format, RecordingOptions options = {});

    /// Appends more of it. False: that was all.
    bool next(std::string& into);

private:
    KeptFrames frames_;
    RecordingFormat format_;
    RecordingOptions options_;
    std::unique_ptr<RecordingWriter> writer_;    // nullptr: nothing is written yet
    std::size_t part_ = 0;
    std::string_view rest_;    // of its batch
    bool in_part_ = false;
};

/// Watches, and remembers. No frame is copied for it alone, and none allocated.
class FrameMemory final : private Watcher {
public:
    static constexpr std::size_t max_bytes = 16 * 1024 * 1024;

    FrameMemory(Gateway& gateway, FrameWatch& watch, const FrameFilterSettings& filter, ano::Duration span);
    ~FrameMemory();
    FrameMemory(const FrameMemory&) = delete;
    FrameMemory& operator=(const FrameMemory&) = delete;

    /// Of the last while until now.
    KeptFrames frames();
    struct Figures {
        ano::Duration span{}, reach{};
        std::uint64_t frames = 0, bytes = 0;
    };
    Figures figures();

private:
    void more() override;

    Gateway& gateway_;
    FrameWatch& watch_;
    Ring<FramesPart> ring_;
    std::shared_ptr<const RecordedNames> names_;
    std::size_t cost_of_names_ = 0;    // that no part has yet
    RecordedLoss lost_{};
    std::string lost_names_;
};

/// Calls `call` when a device logs a fault: 0xA0 in red, that comes in.
class FaultEar final : private Watcher {
public:
    FaultEar(FrameWatch& watch, std::function<void()> call);
    ~FaultEar();
    FaultEar(const FaultEar&) = delete;
    FaultEar& operator=(const FaultEar&) = delete;

private:
    void more() override;

    FrameWatch& watch_;
    std::function<void()> call_;
};

}    // namespace anogate
