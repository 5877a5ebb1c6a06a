// The filter of a watcher of frames (GET /frames?...).
#pragma once
#include <ano/time.hpp>
#include <gateway/filter.hpp>
#include <gateway/frame_record.hpp>
#include <gateway/ids.hpp>
#include <http/request.hpp>
#include <sys/expected.hpp>

#include <array>
#include <bitset>
#include <chrono>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anogate {

struct FrameFilterSettings {
    using Bytes = std::bitset<256>;
    Bytes ids = ~Bytes{}, from = ~Bytes{}, to = ~Bytes{};
    std::vector<std::string> links;                      // empty: all
    std::array<bool, 3> directions{true, true, true};    // by Direction
    std::vector<LimitRule> limit;                        // in the order of the ids
    bool elsewhere = true;                               // also frames received on a link that is not the home of their source
    bool raw = false;                                    // with FrameRecord::raw
    unsigned samples = 0;                                // about this many per second, link, sender and id; 0: every frame
    /// The longest time that a frame may wait for delivery together with others: 1 ms to 1 s. Each delivery costs a wake-up.
    ano::Duration batch = std::chrono::milliseconds{10};
    bool operator==(const FrameFilterSettings&) const = default;
};

enum class FrameFormat : std::uint8_t { json, binary };

struct FrameQuery {
    FrameFilterSettings filter;
    FrameFormat format = FrameFormat::json;
};

/// Parses `from=0xDC,30-40`, `to=`, `id=euler,0x20-0x2F`, `link=fc,ground`, `direction=in,out,dropped`, `limit.ID=RATE`,
/// `samples=10`, `elsewhere=yes|no`, `batch=40ms`, `format=json|binary` and `raw`; the values of repeated names are combined. `links`:
/// the names of all links. A string: the error.
std::variant<FrameQuery, std::string> parse_frame_query(std::span<const http::Field> query,
                                                        std::span<const std::string_view> links);

/// The value of a parameter that is yes or no; empty, as in "?raw": yes.
Expected<bool> parse_flag(std::string_view name, std::string_view value);

/// Passes the given number of frames per second, link, sender and id. If two combinations share a place of the hash table, more
/// frames may pass.
class FrameSamples {
public:
    explicit FrameSamples(unsigned per_second) noexcept : every_{ano::Duration{std::chrono::seconds{1}} / per_second} {}

    bool passes(std::uint8_t link, ano::FrameView frame, ano::TimePoint now) noexcept {
        const std::uint32_t kind = std::uint32_t{link} << 16 | std::uint32_t{frame.source()} << 8 | frame.id();
        Place& place = places_[kind * spread >> shift];
        if (place.is_taken && place.kind == kind && now - place.passed_at < every_) return false;
        place = {now, kind, true};
        return true;
    }

private:
    struct Place {
        ano::TimePoint passed_at{};
        std::uint32_t kind = 0;
        bool is_taken = false;
    };
    static constexpr std::uint32_t spread = 0x9E3779B1;    // Fibonacci hashing: the upper bits are the index of the place
    static constexpr unsigned shift = 32 - 12;
    ano::Duration every_;
    std::array<Place, std::size_t{1} << 12> places_{};
};

/// Applies the settings. No exceptions and no allocation after construction.
class FrameFilter {
public:
    explicit FrameFilter(const FrameFilterSettings& settings);

    /// Sets the current numbers of the links that the settings name.
    void set_links(LinkSet links) noexcept { links_ = links; }
    /// Whether the frame passes. A limit applies to each direction separately, and to all links together. `is_elsewhere`: as in
    /// FrameRecord.
    bool takes(Direction direction, std::uint8_t link, ano::FrameView frame, ano::TimePoint now,
               bool is_elsewhere = false) noexcept {
        const auto way = static_cast<std::size_t>(direction);
        if (!directions_[way] || (is_elsewhere && !elsewhere_)) return false;
        return accepts_all_ ||
               (links_.contains(LinkId{link}) && ids_[frame.id()] && from_[frame.source()] && to_[frame.destination()] &&
                (!limits_ || (*limits_)[way].passes(frame.id(), now)) && (!samples_ || samples_->passes(link, frame, now)));
    }

private:
    FrameFilterSettings::Bytes ids_, from_, to_;
    bool accepts_all_;    // accepts every frame in the wanted directions
    bool elsewhere_;
    LinkSet links_ = ~LinkSet{};
    std::array<bool, 3> directions_;
    std::unique_ptr<std::array<Limit, 3>> limits_;    // nullptr: no limits
    std::unique_ptr<FrameSamples> samples_;           // nullptr: every frame
};

}    // namespace anogate
