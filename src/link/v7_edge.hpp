// The edge of a link whose devices, or whose host program, use V7: V7 frames on the wire, V8 frames towards the gateway.
//
// In:     prepare(), read into it, commit(), deliver(); or receive_datagram()
// Out:    take(outbox, its first frame, now), then write unsent() and remove it by written()
#pragma once
#include <gateway/channel.hpp>
#include <link/link.hpp>
#include <link/link_context.hpp>
#include <link/v7_settings.hpp>
#include <sys/alarm.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace anogate {

class V7Edge final : private V7Output {
public:
    struct Calls {
        /// unsent() has bytes that no take() made: a repeated request, or the next one that waited.
        std::function<void()> write;
        /// A frame of the device, as V8; empty: it is passed to LinkHost::receive().
        std::function<void(ano::FrameView)> receive{};
    };

    V7Edge(const V7LinkSettings& v7, const LinkSettings& link, const LinkContext& context, Calls calls);

    /// A connection begins; its frames belong to `channel`.
    void begin(Channel& channel) noexcept {
        channel_ = &channel;
        reset();
    }

    std::span<std::uint8_t> prepare() noexcept { return parser_.prepare(); }
    void commit(std::size_t n, TimePoint now) noexcept { parser_.commit(n, now); }
    /// Translates the complete frames and passes them on. The caller then calls LinkHost::flush() and writes unsent().
    void deliver();
    void receive_datagram(std::span<const std::uint8_t> datagram, TimePoint now);
    /// The connection is lost: passes on the last frames and forgets everything that belongs to it.
    void end_of_input();
    /// Nothing happens until end_of_input() or begin().
    void pause() noexcept { alarm_.cancel(); }

    /// Translates the first frame of `outbox`, which gather() returned, and removes it: as sent, or as dropped, with
    /// V7Notes::refusal. Answers of the gateway are passed on later: a link that is flushed must not receive.
    void take(Outbox& outbox, ano::FrameView frame, TimePoint now);
    /// Whole V7 frames, to be written before the next frame is taken.
    std::span<const std::uint8_t> unsent() const noexcept { return unsent_; }
    /// The first of them.
    std::span<const std::uint8_t> first_unsent() const noexcept;
    void written(std::size_t bytes) { unsent_.erase(unsent_.begin(), unsent_.begin() + static_cast<std::ptrdiff_t>(bytes)); }

    const V7Counters& counters() const noexcept { return translation_->counters(); }

private:
    void to_device(ano::v7::FrameView frame) override;
    void from_device(ano::FrameView frame) override;
    void translate_received();
    void note_drops(TimePoint now);
    void pass_on();
    void drop(Outbox& outbox);
    void set_alarm();
    void ring();
    void reset() noexcept;

    LinkContext context_;
    Calls calls_;
    std::unique_ptr<V7LinkTranslation> translation_;
    ano::v7::FrameParser parser_;
    Channel* channel_ = nullptr;
    Alarm alarm_;
    std::vector<std::uint8_t> unsent_;
    std::span<const std::uint8_t> raw_{};    // the frame that is being translated
    std::vector<std::uint8_t> received_;     // V8 frames that are not passed on yet; behind each, the V7 frame if it has one
    std::vector<std::uint8_t> passed_on_;    // those that are being passed on
    V7Counters noted_{};                     // when frames were dropped last
    std::uint64_t noted_drops_ = 0;
};

/// The protocol and the counters, for the status.
void add_v7_facts(LinkFacts& facts, const V7Counters& counters);

}    // namespace anogate
