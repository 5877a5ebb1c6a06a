// A connection on a link: a serial link has one channel, a listening UDP link has one for every peer.
#pragma once
#include <ano/parser.hpp>
#include <gateway/answer_watch.hpp>
#include <gateway/counters.hpp>
#include <gateway/echo_watch.hpp>
#include <gateway/ids.hpp>
#include <gateway/outbox.hpp>
#include <gateway/question_queue.hpp>

#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace anogate {

/// When a V7 link dropped such frames last; std::nullopt: never. For hints.
struct V7Notes {
    static constexpr ano::Duration reported_for = std::chrono::seconds{60};
    using When = std::optional<ano::TimePoint>;
    When echo{}, loop{}, command{};    // V7Counters::up_echo, up_loop, up_command
    std::string_view refusal{};        // why the frame that is being dropped can't be translated; empty: no V7 link drops it

    static bool is_recent(When when, ano::TimePoint now) noexcept { return when && now - *when < reported_for; }
};

struct Channel {
    Channel(ChannelId its_id, LinkId its_link, std::string its_peer, const ano::FrameParser::Options& of_parser,
            const Outbox::Options& of_outbox, ano::TimePoint now)
        : id{its_id}, link{its_link}, peer{std::move(its_peer)}, parser{of_parser}, outbox{of_outbox}, opened_at{now} {}

    ChannelId id{};
    LinkId link{};
    std::string peer;    // for people: the device name, or the endpoint of the peer
    ano::FrameParser parser;
    Outbox outbox;
    ReceiveCounters routed;    // only what is not counted by a parser
    ano::TimePoint opened_at{};
    ano::TimePoint heard_at{};            // time of the last valid frame; zero: none yet
    std::uint64_t skipped_by_then = 0;    // skipped() at the time heard_at
    bool had_host_frames = false;         // a frame of a host was to be sent here
    AnswerWatch answers{};
    EchoWatch echo{};
    ReceiveCounters beside{};    // of further parsers: a CAN link has one per CAN id
    V7Notes v7{};                // of a link with protocol V7
    std::span<const std::uint8_t>
        raw{};    // of such a link: the bytes on the wire of the frame that is received or sent just now

    std::unique_ptr<QuestionQueue> questions{};    // before the outbox of a device that accepts few questions at a time; nullptr:
                                                   // none

    ano::TimePoint arrived_at{};    // of the bytes read last; the link sets it before it passes them to the parser

    /// A valid frame was received.
    void record_received(ano::TimePoint now) noexcept {
        heard_at = now;
        skipped_by_then = skipped();
    }
    /// Bytes outside of any frame since the last valid frame.
    std::uint64_t skipped_since_heard() const noexcept { return skipped() - skipped_by_then; }
    /// The counters of all parsers, and `routed`.
    ReceiveCounters received() const noexcept;
    /// The counters of the outbox and of `questions`.
    SendCounters sent() const noexcept;
    std::size_t waiting() const noexcept;
    /// Whether a frame that was received on the channel `from` waits to be sent.
    bool has_waiting(ChannelId from) const noexcept {
        return outbox.has_waiting(from) || (questions && questions->has_waiting(from));
    }

private:
    std::uint64_t skipped() const noexcept { return parser.counters().skipped_bytes + beside.skipped_bytes; }
};

}    // namespace anogate
