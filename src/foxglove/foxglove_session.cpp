#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <foxglove/foxglove_session.hpp>
#include <record/mcap/mcap_items.hpp>

#include <algorithm>

namespace anogate {
namespace {

using foxglove::Level;

// Numbers of channels in the protocol: one for the whole frames, as in a recording in MCAP, then those of decoded messages.
constexpr std::uint32_t raw_channel = 1, first_decoded = 2;

constexpr std::string_view own_messages = "ano_msgs/";    // prefix of the names of their schemas

std::string name_of(std::uint8_t id) {
    const ano::Message* const message = ano::find_message(id);
    return message ? std::string{message->name} : ano::hex_byte(id);
}

std::string to_string(const LostFrames& lost) {
    constexpr std::size_t max_names = 8;
    std::vector<std::pair<std::uint32_t, std::uint8_t>> many;
    for (unsigned id = 0; id < lost.by_id.size(); ++id)
        if (lost.by_id[id] > 0) many.emplace_back(lost.by_id[id], static_cast<std::uint8_t>(id));
    std::sort(many.rbegin(), many.rend());
    std::string words = std::to_string(lost.count) + " frames of the last " + std::to_string(lost.since.count()) +
                        " ms were dropped: the client reads too slowly:";
    for (std::size_t i = 0; i < many.size() && i < max_names; ++i)
        words.append(i > 0 ? ", " : " ").append(name_of(many[i].second) + " " + std::to_string(many[i].first));
    return words + (many.size() > max_names ? ", ..." : "");
}

}    // namespace

FoxgloveSession::FoxgloveSession(const foxglove::ServerInfo& server, DecodedEncoding encoding, DecodingPtr decoding)
    : greeting_{foxglove::server_info(server)}, encoding_{encoding}, decoded_{encoding, std::move(decoding)} {}

void FoxgloveSession::receive(std::string_view text) {
    std::visit([this](auto&& request) { receive(std::forward<decltype(request)>(request)); }, foxglove::read(text));
}

void FoxgloveSession::receive_binary() {
    send_status(Level::error, "binary messages are not supported: this interface is read-only");
}

void FoxgloveSession::receive(const foxglove::Subscribe& request) {
    for (const foxglove::Subscription& wanted : request.subscriptions) subscribe(wanted);
    find_wanted();
}

void FoxgloveSession::subscribe(const foxglove::Subscription& wanted) {
    const std::string channel = "channel " + std::to_string(wanted.channel);
    const Known* const its = known(wanted.channel);
    if (!its && wanted.channel != raw_channel) return send_status(Level::error, "unknown " + channel + ": it was not advertised");
    if (its && its->is_gone) return send_status(Level::warning, channel + " no longer exists because its link was removed");
    if (by_id_.contains(wanted.id))
        return send_status(Level::error, "the subscription id " + std::to_string(wanted.id) + " is already in use");
    if (!by_channel_.try_emplace(wanted.channel, wanted.id).second)
        return send_status(Level::error,
                           channel + " is already subscribed with id " + std::to_string(by_channel_.at(wanted.channel)));
    by_id_.emplace(wanted.id, wanted.channel);
}

void FoxgloveSession::receive(const foxglove::Unsubscribe& request) {
    for (const std::uint32_t id : request.ids) {
        const auto found = by_id_.find(id);
        if (found == by_id_.end()) {
            send_status(Level::error, "unknown subscription " + std::to_string(id));
            continue;
        }
        by_channel_.erase(found->second);
        by_id_.erase(found);
    }
    find_wanted();
}

void FoxgloveSession::receive(foxglove::GetParameters&& request) {
    if (open_questions_ == max_questions)
        return send_status(Level::error, "too many parameter requests are pending; try again later");
    ++open_questions_;
    questions_.push_back(std::move(request));
}

void FoxgloveSession::receive(foxglove::WatchParameters&& request) {
    if (request.names.empty()) {
        watches_all_ = !request.ends;
        watched_.clear();
    }
    for (std::string& name : request.names) {
        if (request.ends) watched_.erase(name);
        else if (watched_.size() < max_watched && name.size() <= max_watched_name) watched_.insert(std::move(name));
    }
}

void FoxgloveSession::receive(foxglove::Wrong&& request) { send_status(Level::error, request.words); }

void FoxgloveSession::send_status(Level level, std::string_view words) {
    if (statuses_.size() < max_statuses) statuses_.push_back(foxglove::status(level, words));
    else ++unreported_;
}

const FoxgloveSession::Known* FoxgloveSession::known(std::uint32_t channel) const noexcept {
    return channel >= first_decoded && channel - first_decoded < channels_.size() ? &channels_[channel - first_decoded] : nullptr;
}

void FoxgloveSession::find_wanted() {
    wanted_.clear();
    for (const auto& [channel, id] : by_channel_)
        if (const Known* const its = known(channel); its && !its->is_gone) want(*its);
    filter_has_changed_ = true;
}

// A standard message may contain values from earlier frames of its device, so all frames of the device with standard messages are
// wanted.
void FoxgloveSession::want(const Known& channel) {
    wanted_.insert(channel.kinds.begin(), channel.kinds.end());
    if (!channel.is_standard) return;
    for (const FrameKind& kind : channel.kinds)
        for (auto other = standard_kinds_.lower_bound({kind.link, kind.source, 0});
             other != standard_kinds_.end() && other->link == kind.link && other->source == kind.source; ++other)
            wanted_.insert(*other);
}

std::optional<FrameFilterSettings> FoxgloveSession::filter() const {
    const bool is_raw = by_channel_.contains(raw_channel);
    if (!is_raw && wanted_.empty()) return std::nullopt;
    FrameFilterSettings filter;
    filter.elsewhere = false;
    if (is_raw) return filter;
    filter.directions = {true, false, false};
    filter.ids.reset();
    filter.from.reset();
    std::set<std::string> links;
    for (const FrameKind& kind : wanted_) {
        filter.ids.set(kind.id);
        filter.from.set(kind.source);
        links.insert(kind.link);
    }
    filter.links.assign(links.begin(), links.end());
    return filter;
}

std::size_t FoxgloveSession::number_of(const DecodedChannel& channel, const DecodedSchema& schema) {
    const auto [known, is_new] = by_topic_.try_emplace(channel.topic, channels_.size());
    if (is_new) channels_.push_back({&channel, &schema, {}, !schema.name.starts_with(own_messages)});
    return known->second;
}

// std::nullopt: unknown channel.
std::optional<std::size_t> FoxgloveSession::number_of(const DecodedMessage& message) {
    if (numbers_.size() <= message.channel) numbers_.resize(message.channel + 1);
    std::optional<std::size_t>& number = numbers_[message.channel];
    if (number && !channels_[*number].is_gone) return number;
    const auto known = by_topic_.find(decoded_.channels()[message.channel].topic);
    number = known == by_topic_.end() ? std::nullopt : std::optional{known->second};
    return number;
}

void FoxgloveSession::learn(const FirstFrame& first) {
    if (const auto frame = first.frame()) decoded_.decode(*frame);    // so that decoded_ gives its link the same name
    for (const FoundChannel& found : first.found()) {
        const std::size_t number = number_of(*found.channel, *found.schema);
        Known& channel = channels_[number];
        channel.kinds.insert(found.kind);
        if (channel.is_standard) standard_kinds_.insert(found.kind);
    }
    if (!by_channel_.empty()) find_wanted();
}

// The subscription of a removed channel stays until the client ends it: the client may not have received the removal yet.
template <class IsGone>
void FoxgloveSession::forget_where(IsGone is_gone) {
    for (std::size_t number = 0; number < channels_.size(); ++number) {
        Known& channel = channels_[number];
        if (channel.is_gone || channel.kinds.empty() || !is_gone(*channel.kinds.begin())) continue;
        channel.is_gone = true;
        by_topic_.erase(channel.channel->topic);
        if (number < advertised_channels_) gone_.push_back(static_cast<std::uint32_t>(number) + first_decoded);
    }
    std::erase_if(standard_kinds_, is_gone);
    if (!by_channel_.empty()) find_wanted();
}

void FoxgloveSession::forget(std::string_view link) {
    forget_where([link](const FrameKind& kind) { return kind.link == link; });
}

void FoxgloveSession::use(DecodingPtr decoding) {
    decoded_.use(std::move(decoding));
    forget_where([](const FrameKind& kind) { return ano::is_flexible(kind.id); });
}

void FoxgloveSession::show(const RecordedFrame& frame) {
    if (by_channel_.contains(raw_channel)) {
        mcap::encode(frame, raw_);
        send_on(raw_channel, frame.time_ns, raw_);
    }
    if (frame.direction != Direction::in || !wanted_.contains(kind_of(frame))) return;
    for (const DecodedMessage& message : decoded_.decode(frame))
        if (const auto number = number_of(message))
            send_on(static_cast<std::uint32_t>(*number) + first_decoded, frame.time_ns, message.data);
}

void FoxgloveSession::send_on(std::uint32_t channel, std::uint64_t time_ns, std::string_view payload) {
    const auto subscription = by_channel_.find(channel);
    if (subscription == by_channel_.end()) return;
    messages_.push_back({foxglove::message_data(subscription->second, time_ns, payload), false, false});
}

void FoxgloveSession::lose(const LostFrames& lost) { warn(to_string(lost)); }

std::optional<foxglove::GetParameters> FoxgloveSession::next_question() {
    if (questions_.empty()) return std::nullopt;
    foxglove::GetParameters question = std::move(questions_.front());
    questions_.pop_front();
    return question;
}

void FoxgloveSession::answer(const foxglove::GetParameters& question, const std::vector<foxglove::Parameter>& values) {
    messages_.push_back({foxglove::parameter_values(values, question.id), true, true});
}

void FoxgloveSession::changed(const std::vector<foxglove::Parameter>& values) {
    for (const foxglove::Parameter& one : values)
        if (watches_all_ || watched_.contains(one.name)) changed_.insert_or_assign(one.name, one.value);
}

// Channels are announced before their messages.
std::optional<FoxgloveSession::Message> FoxgloveSession::next() {
    if (!greeting_.empty()) return Message{std::exchange(greeting_, {})};
    if (!statuses_.empty()) {
        Message status{std::move(statuses_.front())};
        statuses_.pop_front();
        if (statuses_.empty() && unreported_ > 0)
            send_status(Level::error,
                        std::to_string(std::exchange(unreported_, 0)) + " more errors are not reported individually");
        return status;
    }
    if (!gone_.empty()) return Message{foxglove::unadvertise(std::exchange(gone_, {}))};
    if (auto channels = next_channels()) return channels;
    if (!messages_.empty()) {
        Message message = std::move(messages_.front());
        messages_.pop_front();
        if (message.is_answer) --open_questions_;    // only now: a client that reads no answers gets no more of them
        return message;
    }
    if (changed_.empty()) return std::nullopt;
    std::vector<foxglove::Parameter> values;
    for (auto& [name, value] : std::exchange(changed_, {})) values.push_back({name, std::move(value)});
    return Message{foxglove::parameter_values(values, std::nullopt)};
}

std::optional<FoxgloveSession::Message> FoxgloveSession::next_channels() {
    std::vector<foxglove::Channel> channels;
    if (!std::exchange(raw_is_advertised_, true))
        channels.push_back({raw_channel, mcap::frames_topic, text(DecodedEncoding::cdr), mcap::frame_schema_name,
                            mcap::frame_schema_text, "ros2msg"});
    std::size_t size = 0;
    while (advertised_channels_ < channels_.size() && size < part_size) {
        const Known& next = channels_[advertised_channels_++];
        if (next.is_gone) continue;
        const DecodedChannel& channel = *next.channel;
        const DecodedSchema& schema = *next.schema;
        channels.push_back({static_cast<std::uint32_t>(advertised_channels_ - 1) + first_decoded, channel.topic, text(encoding_),
                            schema.name, schema.text, schema.encoding});
        size += channel.topic.size() + schema.name.size() + schema.text.size();
    }
    if (channels.empty()) return std::nullopt;
    return Message{foxglove::advertise(channels)};
}

}    // namespace anogate
