// The session of one client of the Foxglove WebSocket protocol: its subscriptions, and the messages for it. No I/O.
//
// Flow:    FoxgloveSession session{server, encoding};
//          session.learn(first_frame);                // new channels
//          session.hear(text);                        // a message of the client
//          if (session.filter_has_changed()) watch(session.pop_filter());
//          session.show(frame);                       // a frame that passed the filter
//          while (auto message = session.next()) ...  // to be sent, in this order
#pragma once
#include <foxglove/foxglove_messages.hpp>
#include <record/decoded_channels.hpp>
#include <runtime/found_channels.hpp>
#include <watch/frame_filter.hpp>
#include <watch/watch_queue.hpp>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class FoxgloveSession {
public:
    static constexpr std::size_t max_statuses = 32;         // waiting to be sent; of further ones only the number is sent
    static constexpr std::size_t max_questions = 16;        // not answered, or the answer is not sent yet
    static constexpr std::size_t max_watched = 16384;       // names of parameters
    static constexpr std::size_t max_watched_name = 256;    // bytes: no parameter has a longer name
    static constexpr std::size_t part_size = 32 * 1024;     // bytes of channels in a message, unless one alone needs more

    struct Message {
        std::string data;
        bool is_text = true;
        bool is_answer = false;    // to a request of the client
    };

    FoxgloveSession(const foxglove::ServerInfo& server, DecodedEncoding encoding, DecodingPtr decoding);

    /// A text message of the client.
    void receive(std::string_view text);
    /// A binary message of the client; always an error.
    void receive_binary();

    /// Announces these channels to the client. Call it in the order in which they were found. Their FoundChannels must outlive
    /// the session.
    void learn(const FirstFrame& first);
    /// Unadvertises the channels of a removed link. A later learn() of the same topic makes a new channel.
    void forget(std::string_view link);
    /// Sets the decoding of the frames that follow. Unadvertises the channels of flexible messages, as forget() does.
    void use(DecodingPtr decoding);
    /// A frame that passed filter(): its messages for the subscribed channels are queued.
    void show(const RecordedFrame& frame);
    /// Frames that were lost because the client reads too slowly.
    void lose(const LostFrames& lost);

    /// Whether filter() has changed since the last pop_filter().
    bool filter_has_changed() const noexcept { return filter_has_changed_; }
    /// Selects the frames that may contain the subscribed channels; std::nullopt: nothing is subscribed.
    std::optional<FrameFilterSettings> filter() const;
    std::optional<FrameFilterSettings> pop_filter() {
        filter_has_changed_ = false;
        return filter();
    }

    /// The next request for parameters. Each must be answered by answer(), in any order.
    std::optional<foxglove::GetParameters> next_question();
    void answer(const foxglove::GetParameters& question, const std::vector<foxglove::Parameter>& values);
    /// These parameters were read or written: queues those that the client watches.
    void changed(const std::vector<foxglove::Parameter>& values);
    void warn(std::string_view words) { send_status(foxglove::Level::warning, words); }

    /// The next message to send; std::nullopt: none is queued.
    std::optional<Message> next();

private:
    // A channel that was announced to the client, or will be.
    struct Known {
        const DecodedChannel* channel;
        const DecodedSchema* schema;
        std::set<FrameKind> kinds;    // of the frames with messages for it
        bool is_standard;             // its messages also contain values from frames of other kinds
        bool is_gone = false;
    };

    void receive(const foxglove::Subscribe& request);
    void receive(const foxglove::Unsubscribe& request);
    void receive(foxglove::GetParameters&& request);
    void receive(foxglove::WatchParameters&& request);
    void receive(foxglove::Wrong&& request);
    void subscribe(const foxglove::Subscription& wanted);
    void send_status(foxglove::Level level, std::string_view words);
    std::size_t number_of(const DecodedChannel& channel, const DecodedSchema& schema);
    std::optional<std::size_t> number_of(const DecodedMessage& message);
    void want(const Known& channel);
    template <class IsGone>
    void forget_where(IsGone is_gone);
    void send_on(std::uint32_t channel, std::uint64_t time_ns, std::string_view payload);
    void find_wanted();
    /// nullptr: the channel of whole frames, or a channel that was never advertised.
    const Known* known(std::uint32_t channel) const noexcept;
    std::optional<Message> next_channels();

    std::string greeting_;    // empty: already sent
    DecodedEncoding encoding_;
    DecodedChannels decoded_;
    std::vector<std::optional<std::size_t>> numbers_;    // position in channels_, by the number in decoded_
    std::vector<Known> channels_;
    std::map<std::string_view, std::size_t> by_topic_;     // without removed channels
    std::set<FrameKind> standard_kinds_;                   // of the standard channels
    std::set<FrameKind> wanted_;                           // for the subscribed channels
    std::map<std::uint32_t, std::uint32_t> by_channel_;    // the subscription of each channel
    std::map<std::uint32_t, std::uint32_t> by_id_;         // the channel of each subscription
    bool filter_has_changed_ = false;
    bool raw_is_advertised_ = false;
    std::string raw_;                        // buffer for the message of a whole frame; keeps its memory
    std::size_t advertised_channels_ = 0;    // number of channels_ that were announced
    std::vector<std::uint32_t> gone_;        // removed channels that are still to be unadvertised
    std::deque<Message> messages_;
    std::deque<std::string> statuses_;
    std::uint64_t unreported_ = 0;    // statuses that did not fit
    std::deque<foxglove::GetParameters> questions_;
    std::size_t open_questions_ = 0;
    bool watches_all_ = false;
    std::set<std::string> watched_;
    std::map<std::string, std::string> changed_;    // watched parameters with new values, not sent yet
};

}    // namespace anogate
