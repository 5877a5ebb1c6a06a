// A recording that a thread of its own reads ahead: the loop never waits for the disk. Beside the frames that wait, the thread holds what is
// unpacked of the file: a chunk of MCAP, 64 MiB at the most.
//
// Flow:    ReplayFile file{io, [] { there is news: frames, or another state }};
//          file.start(settings);
//          while (const auto frame = file.next()) { ...; file.take(); }
//          file.stop();
#pragma once
#include <ano/time.hpp>
#include <link/asio_fwd.hpp>
#include <link/descriptor.hpp>
#include <link/link_error.hpp>
#include <link/replay_settings.hpp>
#include <record/replay.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace anogate {

/// All calls are from the loop.
class ReplayFile {
public:
    static constexpr std::size_t read_ahead = 1024 * 1024;    // bytes of frames that wait, and a batch of 64 KiB more
    static constexpr std::size_t max_links = 16;              // with a name of their own; the frames of others count to the last

    struct Frame {
        ano::Duration due{};     // since the begin of the replay, however often it began again
        std::size_t link = 0;    // in links()
        ano::FrameView frame;
    };
    enum class State : std::uint8_t {
        opening,
        absent,    // error() says why; it is tried again
        playing,
        ended,    // there are no more frames than those that wait
    };

    /// `on_news` is called by the loop.
    ReplayFile(asio::io_context& io, std::function<void()> on_news);
    ~ReplayFile();
    ReplayFile(const ReplayFile&) = delete;
    ReplayFile& operator=(const ReplayFile&) = delete;

    void start(const ReplaySettings& settings);
    /// The thread ends when the disk lets it.
    void stop() noexcept;

    /// Nothing: none is there now. Valid until take().
    std::optional<Frame> next();
    void take();

    State state() const;
    /// Why it is absent; in any other state what is wrong with the file, as far as it was read: "damaged behind byte 4711: …"; or
    /// why nothing of it is said.
    LinkError error() const;
    ReplayPlan::KeptBack kept_back() const;
    /// Of the recording, for the frames that next() gave; as printable() makes them: they get into the log and the status.
    const std::vector<std::string>& links() const noexcept { return links_; }

private:
    struct Batch;
    struct Shared;
    class Reader;

    Descriptor said_;
    std::function<void()> on_news_;
    std::shared_ptr<Shared> shared_;    // with the thread, which may be left behind
    std::shared_ptr<Batch> batch_;      // from which frames are taken
    std::size_t taken_ = 0;             // of its frames
    std::size_t at_ = 0;                // in its bytes: the next one
    std::vector<std::string> links_;
};

}    // namespace anogate
