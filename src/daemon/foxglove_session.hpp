// One client of the Foxglove WebSocket protocol: what he is told, what he wants, and what of that he gets. No I/O.
//
// Flow:    FoxgloveSession session{server, encoding};
//          session.learn(first_frame);                // which channels there are
//          session.hear(text);                        // what the client says
//          if (session.wants_other_frames()) watch(session.take_filter());
//          session.show(frame);                       // one of these
//          while (auto message = session.next()) ...  // to be sent, in this order
#pragma once
#include <ano/flexible.hpp>
#include <daemon/found_channels.hpp>
#include <daemon/foxglove_messages.hpp>
#include <daemon/frame_filter.hpp>
#include <daemon/watch_queue.hpp>
#include <record/decoded_channels.hpp>

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
    static constexpr std::size_t max_statuses = 32;         // that wait to be sent; of more their number is told
    static constexpr std::size_t max_questions = 16;        // that wait for their answer, or whose answer waits to be taken
    static constexpr std::size_t max_watched = 16384;       // parameters by their names
    static constexpr std::size_t max_watched_name = 256;    // bytes: none has a longer one
    static constexpr std::size_t part_size = 32 * 1024;     // bytes of channels in one message, but for one that is longer

    struct Message {
        std::string data;
        bool is_text = true;
        bool is_answer = false;    // to one of his questions
    };

    /// `flexible`, which outlives it, has the layouts of flexible messages.
    FoxgloveSession(const foxglove::ServerInfo& server, DecodedEncoding encoding, const ano::FlexibleLayouts& flexible);

    /// A text of the client.
    void hear(std::string_view text);
    /// Bytes of his: nothing that he may send.
    void hear_bytes();

    /// He is to know of its channels; all in the order in which they were found. What found them outlives this.
    void learn(const FirstFrame& first);
    /// There is no such link any more: its channels are taken back. Behind it, learn() of the same topic makes another channel.
    void forget(std::string_view link);
    /// A frame that passed filter(): its messages on the channels that he subscribed.
    void show(const RecordedFrame& frame);
    /// Frames that were not shown, for he takes too little.
    void lose(const LostFrames& lost);

    /// filter() is another one than that which was taken last.
    bool wants_other_frames() const noexcept { return wants_others_; }
    /// What he subscribed may stand in these frames; nothing: he subscribed nothing.
    std::optional<FrameFilterSettings> filter() const;
    std::optional<FrameFilterSettings> take_filter() {
        wants_others_ = false;
        return filter();
    }

    /// Parameters that he asks for. Each question has its answer by answer(), in whatever order.
    std::optional<foxglove::GetParameters> next_question();
    void answer(const foxglove::GetParameters& question, const std::vector<foxglove::Parameter>& values);
    /// These were read or written: he is told of those that he watches.
    void changed(const std::vector<foxglove::Parameter>& values);
    void warn(std::string_view words) { say(foxglove::Level::warning, words); }

    /// What is to be sent next; nothing: all was.
    std::optional<Message> next();

private:
    // A channel as he knows it.
    struct Known {
        const DecodedChannel* channel;
        const DecodedSchema* schema;
        std::set<FrameKind> kinds;    // of the frames that it comes of
        bool is_standard;             // it has what frames of other kinds said as well
        bool is_gone = false;
    };

    void hear(const foxglove::Subscribe& said);
    void hear(const foxglove::Unsubscribe& said);
    void hear(foxglove::GetParameters&& said);
    void hear(foxglove::WatchParameters&& said);
    void hear(foxglove::Wrong&& said);
    void subscribe(const foxglove::Subscription& wanted);
    void say(foxglove::Level level, std::string_view words);
    std::size_t number_of(const DecodedChannel& channel, const DecodedSchema& schema);
    std::optional<std::size_t> number_of(const DecodedMessage& message);
    void want(const Known& channel);
    void send_on(std::uint32_t channel, std::uint64_t time_ns, std::string_view payload);
    void find_wanted();
    /// nullptr: it is that of whole frames, or was never advertised.
    const Known* known(std::uint32_t channel) const noexcept;
    std::optional<Message> next_channels();

    std::string greeting_;    // empty: it was sent
    DecodedEncoding encoding_;
    DecodedChannels decoded_;
    std::vector<std::optional<std::size_t>> numbers_;    // in channels_, by number in decoded_
    std::vector<Known> channels_;
    std::map<std::string_view, std::size_t> by_topic_;     // without those that are gone
    std::set<FrameKind> standard_kinds_;                   // that standard messages come of
    std::set<FrameKind> wanted_;                           // for what he subscribed
    std::map<std::uint32_t, std::uint32_t> by_channel_;    // the subscription of each channel
    std::map<std::uint32_t, std::uint32_t> by_id_;         // the other way
    bool wants_others_ = false;
    bool raw_is_told_ = false;
    std::string raw_;                    // the last whole frame, as its message; keeps its memory
    std::size_t told_channels_ = 0;      // of channels_
    std::vector<std::uint32_t> gone_;    // of these, which is not told yet
    std::deque<Message> messages_;
    std::deque<std::string> statuses_;
    std::uint64_t unsaid_ = 0;    // statuses
    std::deque<foxglove::GetParameters> questions_;
    std::size_t open_questions_ = 0;
    bool watches_all_ = false;
    std::set<std::string> watched_;
    std::map<std::string, std::string> changed_;    // of these, not told yet
};

}    // namespace anogate
