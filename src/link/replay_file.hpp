// A recording that a thread reads ahead, so that the loop never waits for the disk. In addition to the waiting frames, the thread
// holds one uncompressed chunk of MCAP, at most 64 MiB.
//
// Flow:    ReplayFile file{io, [] { new frames, or another state }};
//          file.start(settings);
//          while (const auto frame = file.next()) { ...; file.take(); }
//          file.stop();
#pragma once
#include <ano/time.hpp>
#include <link/link_error.hpp>
#include <link/replay_settings.hpp>
#include <record/replay.hpp>
#include <sys/asio_fwd.hpp>
#include <sys/descriptor.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// For use by the loop only.
class ReplayFile {
public:
    static constexpr std::size_t read_ahead = 1024 * 1024;    // bytes of waiting frames, plus one batch of 64 KiB
    static constexpr std::size_t max_links = 16;              // links with a name; frames of further links belong to the last one

    struct Frame {
        ano::Duration due{};     // since the replay began, over all loops
        std::size_t link = 0;    // index in links()
        ano::FrameView frame;
    };
    enum class State : std::uint8_t {
        opening,
        absent,    // error() returns the reason; opening is retried
        playing,
        ended,    // no frames except those that are waiting
    };

    /// `on_news` is called from the loop when there are new frames or another state.
    ReplayFile(asio::io_context& io, std::function<void()> on_news);
    ~ReplayFile();
    ReplayFile(const ReplayFile&) = delete;
    ReplayFile& operator=(const ReplayFile&) = delete;

    void start(const ReplaySettings& settings);
    /// Does not wait for the thread, which may still be blocked by the disk.
    void stop() noexcept;

    /// The next frame, valid until take(); std::nullopt: none is available now.
    std::optional<Frame> next();
    void pop();

    State state() const;
    /// The reason for `absent`; in other states a fault in the part that was read ("damaged after byte 4711: …"), or why no
    /// frame is replayed.
    LinkError error() const;
    ReplayPlan::KeptBack kept_back() const;
    /// The decoding of the frame that next() returned last.
    const DecodingPtr& decoding() const noexcept { return decoding_; }
    /// Names of the recorded links of the frames so far; passed through printable(), because they appear in the log and the
    /// status.
    const std::vector<std::string>& links() const noexcept { return links_; }

private:
    struct Batch;
    struct Shared;
    class Reader;

    Descriptor event_;
    std::function<void()> on_news_;
    std::shared_ptr<Shared> shared_;    // shared with the thread, which may outlive us
    std::shared_ptr<Batch> batch_;      // from which next() takes frames
    std::size_t taken_ = 0;             // number of its frames
    std::size_t at_ = 0;                // offset of the next frame in its bytes
    std::vector<std::string> links_;
    DecodingPtr decoding_;
};

}    // namespace anogate
