// Finds the frames in a stream of bytes.
//
// Flow:    auto room = parser.prepare();              // read into it
//          parser.commit(n, now);
//          while (auto frame = parser.next()) …       // each view is valid until the next prepare()
//          set a timer for parser.deadline(); when it is due: if (parser.expire(now)) call next() again
//
// Call begin_datagram() before the bytes of a datagram are written: it decides whether the incomplete rest of the previous
// datagram is kept.
#pragma once
#include <ano/frame.hpp>
#include <ano/frame_pairs.hpp>
#include <ano/heard.hpp>
#include <ano/image_length.hpp>
#include <ano/lazy_array.hpp>
#include <ano/prefix_sums.hpp>
#include <ano/time.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace ano {

/// Counters of the bytes. bytes_in = the bytes of valid frames + skipped_bytes + the waiting bytes.
struct ParserCounters {
    std::uint64_t frames_in{};
    std::uint64_t bytes_in{};
    std::uint64_t bad_check{};        // candidates with a wrong checksum
    std::uint64_t bad_length{};       // candidates whose LEN is above max_data
    std::uint64_t skipped_bytes{};    // bytes outside of valid frames
    std::uint64_t expired{};          // candidates whose end was not received, or only after a valid frame that follows them
    std::uint64_t v7_frames{};        // frames of the previous protocol version among the skipped bytes: an estimate
    std::uint64_t long_images{};      // refused images above max_data, recognised by their width and height: an estimate
};

/// After a refused candidate the search continues one byte later, so that a damaged frame never takes others with it. The time is
/// linear for any input. A candidate whose rest is missing waits. One that is not credible by the received frames (heard.hpp) is
/// given up if two consecutive valid frames from known sources follow. While the credit for that search (frame_pairs.hpp) is used
/// up, it waits as well, until expire() gives it up. Neither throws nor allocates after construction.
class FrameParser {
public:
    struct Options {
        // 0 to 65535. A larger LEN is refused by the header alone; for an image above it (max_image_data_at()), by the first
        // bytes of DATA.
        std::size_t max_data = usual_max_data;
        std::uint32_t line_rate = 0;                       // bytes/s of the line; 0: unknown
        Duration quiet = std::chrono::milliseconds{50};    // after this time without a byte, waiting candidates may be given up
        // Pauses of this length are normal inside a frame: after `quiet`, a candidate is given up only if valid frames after it end
        // with the last byte received. Zero: not set.
        Duration frame_gap{};
        bool zero_padding = false;    // 0x00 after a valid frame, committed together with its end, is padding and is not counted
    };

    explicit FrameParser(Options options);

    /// Room for the next bytes, at least one byte if next() was called until it returned std::nullopt. Invalidates all views.
    std::span<std::uint8_t> prepare() noexcept;
    /// `n` bytes of that room were filled at `now`.
    void commit(std::size_t n, TimePoint now) noexcept;
    /// The next valid frame; std::nullopt: none is complete.
    std::optional<FrameView> next() noexcept;

    /// Call before the bytes of a datagram are written. The rest of the previous one is kept only if it is younger than 100 ms
    /// (or frame_gap) and `datagram` does not itself start with a complete valid frame.
    void begin_datagram(std::span<const std::uint8_t> datagram, TimePoint now) noexcept;
    /// The input ends here: next() no longer waits for the rest of a candidate. Bytes committed later are parsed separately.
    void finish() noexcept { barrier_ = end_; }
    /// Gives up candidates that delay a valid frame or whose rest is overdue. True: call next() again.
    bool expire(TimePoint now) noexcept;
    /// When to call expire(); std::nullopt: no candidate waits for its rest.
    std::optional<TimePoint> deadline() const noexcept;

    /// Bytes that wait for the rest of their frame.
    std::size_t waiting() const noexcept { return end_ - pos_; }
    /// Those bytes; valid until the next prepare().
    std::span<const std::uint8_t> rest() const noexcept { return {buffer_.get() + pos_, end_ - pos_}; }
    /// Copies the newest bytes outside of valid frames, in their order, as many as there are and fit. Returns their number.
    std::size_t copy_skipped(std::span<std::uint8_t> into) const noexcept;
    static constexpr std::size_t kept_skipped = 1024;
    /// Valid frames since the last byte outside of valid frames.
    std::uint64_t frames_since_skipped() const noexcept { return counters_.frames_in - frames_at_skip_; }
    const ParserCounters& counters() const noexcept { return counters_; }
    /// The largest LEN among ParserCounters::long_images; 0: there were none.
    std::size_t longest_image() const noexcept { return longest_image_; }
    void set_line_rate(std::uint32_t bytes_per_second) noexcept { options_.line_rate = bytes_per_second; }

private:
    enum class Verdict { good, bad, too_long, incomplete };

    // Finds frames of the previous version among the skipped bytes, which arrive in pieces.
    struct V7Matcher {
        bool take(std::uint8_t byte) noexcept;    // true: it is the last byte of such a frame

        unsigned place = 0;
        unsigned length = 0;
        std::uint8_t sum = 0;
        std::uint8_t add = 0;
    };

    std::size_t next_candidate(std::size_t from) noexcept;
    Verdict judge(std::size_t at, std::size_t limit) noexcept;
    bool checks_hold(std::size_t at, std::size_t length) noexcept;
    std::uint64_t refused_together(std::uint64_t candidates, std::size_t from, std::size_t sums_end) const noexcept;
    void count_refused(std::uint64_t heads) noexcept;
    bool add_is_wrong(std::size_t at, std::size_t to) const noexcept;
    bool yields(std::size_t at) noexcept;
    std::size_t find_good_frame_behind(std::size_t at) noexcept;
    std::size_t find_good_frames_to_the_end(std::size_t at) noexcept;
    bool may_be_between_frames() const noexcept { return options_.frame_gap > options_.quiet && !none_at_end_; }
    TimePoint next_look_between_frames() const noexcept;
    TimePoint overdue_without_pauses_at(std::size_t candidate, TimePoint since) const noexcept;
    void sum_up_from(std::size_t at) noexcept;
    std::size_t first_not_overdue(TimePoint now) const noexcept;
    void skip_to(std::size_t at) noexcept;
    void keep_skipped(std::span<const std::uint8_t> bytes) noexcept;
    void drop_padding() noexcept;
    bool begins_with_frame(std::span<const std::uint8_t> datagram) const noexcept;
    void note_long_image(std::size_t at) noexcept;
    void check_long_image() noexcept;
    void count_long_image(const std::uint8_t* begin) noexcept;
    bool may_be_image(std::size_t at, std::size_t length) const noexcept {
        return buffer_[at + 3] == image_id && length <= max_image_;
    }
    Duration quiet() const noexcept { return options_.frame_gap > Duration{} ? options_.frame_gap : options_.quiet; }
    TimePoint overdue_at(std::size_t candidate, TimePoint since) const noexcept;

    Options options_;
    std::size_t max_image_;         // DATA of an image; at least max_data
    std::size_t capacity_;          // of the buffer, for two of the longest images
    std::size_t usual_capacity_;    // for two of the longest other frames: only images access the part after it
    LazyArray<std::uint8_t> buffer_;
    std::size_t pos_ = 0;        // first byte not yet checked
    std::size_t end_ = 0;        // end of the committed bytes
    std::size_t barrier_ = 0;    // the rest of a candidate that begins before this was not received: it ends here

    // Sums are computed only after a refused candidate. With them, checking any further candidate that begins before sums_until_
    // takes constant time. They begin at pos_ or before. If they end before the candidate, they start again there.
    PrefixSums sums_;
    std::size_t sums_until_ = 0;

    Heard heard_;
    FramePairs pairs_;

    bool behind_frame_ = false;       // pos_ is the end of a valid frame, and padding may follow
    bool candidate_waits_ = false;    // the candidate at pos_ waits for its rest
    bool none_behind_ = false;        // no valid frame was found after it since the last byte arrived
    bool none_at_end_ = false;        // the same for valid frames that end with the last byte
    TimePoint candidate_since_{};
    TimePoint last_arrival_{};
    TimePoint looked_at_{};    // for valid frames that end with the last byte
    V7Matcher v7_;
    std::size_t v7_budget_ = 0;                        // bytes it may still examine: each commit adds some
    LazyArray<std::uint8_t> skipped_{kept_skipped};    // a ring: byte N of skipped_bytes is at N % kept_skipped
    // The number of the first byte of a refused header that may be that of an image, among the skipped bytes: the next ones show it.
    std::optional<std::uint64_t> long_image_at_{};
    std::size_t longest_image_ = 0;
    std::uint64_t frames_at_skip_ = 0;    // counters_.frames_in when a byte was skipped last
    ParserCounters counters_;
};

}    // namespace ano
