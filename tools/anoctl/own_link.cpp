#include "own_link.hpp"

#include "say.hpp"

#include <ano/heard.hpp>
#include <ano_json/text.hpp>
#include <config/config.hpp>
#include <config/key_facts.hpp>
#include <gateway/hints.hpp>
#include <gateway/v7_echo_watch.hpp>
#include <link/clocks.hpp>
#include <link/kinds.hpp>
#include <link/link_context.hpp>
#include <link/resolver.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/datagram_sender.hpp>
#include <sys/alarm.hpp>
#include <sys/asio.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <optional>
#include <ostream>
#include <span>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using namespace anogate;

constexpr char how_to_watch[] = "; to watch the gateway that uses it: anoctl monitor, without LINK";

std::string only_listens(const std::string& who) {
    return "; " + who + " only receives, and some devices send only after a hello: run anogated with hello=on";
}

bool matters_to_a_listener(std::string_view key) {
    constexpr std::string_view others[]{"id",    "hello",   "flood",        "broadcast", "group", "present_as",
                                        "queue", "rate",    "pace",         "latency",   "gap",   "pack",
                                        "mtu",   "trusted", "max_data_out", "required"};
    constexpr std::string_view groups[]{"send.", "receive.", "limit.", "age."};
    return std::find(std::begin(others), std::end(others), key) == std::end(others) &&
           std::none_of(std::begin(groups), std::end(groups), [&](std::string_view group) { return key.starts_with(group); });
}

std::string to_string(const std::string& text) { return text; }
std::string to_string(std::int64_t number) { return std::to_string(number); }

}    // namespace

LinkSettings link_settings_of(const std::string& link, std::string_view if_name) {
    anogate::Draft draft{link_kinds()};
    read_link(link, "", draft);
    validate(draft);
    if (!draft.errors.empty()) {
        const ConfigError& first = draft.errors.front();
        const bool is_name = !if_name.empty() && link.find_first_of(":/,=") == link.npos;
        throw UsageError{(first.where.empty() ? "" : first.where + ": ") + first.what +
                         (is_name ? "; " + std::string{if_name} + ' ' + ano::in_quotes(link) : "")};
    }
    return draft.settings.links.at(0);
}

std::string keys_idle_for_listener(std::string_view link) {
    std::string idle;
    const auto pieces = split(link, ',');
    for (const std::string_view piece : std::span{pieces}.subspan(1)) {
        const std::string_view key = piece.substr(0, piece.find('='));
        if (!matters_to_a_listener(key)) idle.append(idle.empty() ? "" : ", ").append(key);
    }
    return idle;
}

/// LinkHost of the only link.
class OwnLink::Host final : public LinkHost {
public:
    Host(asio::io_context& io, const LinkSettings& settings, FrameReceiver& receiver, Streams& streams, std::string who,
         Duration look_every)
        : io_{io},
          receiver_{receiver},
          streams_{streams},
          who_{std::move(who)},
          look_every_{look_every},
          link_{settings.kind->make(LinkId{0}, settings, {io_, alarms_, *this, batch_, sender_, names_, v7_lines_})} {}

    void start() {
        link_->start();
        look_later();
    }
    void stop() {
        done_ = true;
        look_.cancel();
        if (std::exchange(stopped_, true)) return;
        link_->stop_reading();
        link_->stop();
    }
    bool send(ano::FrameView frame) {
        has_sent_ = true;
        bool left = false;
        const bool is_anywhere = std::any_of(channels_.begin(), channels_.end(),
                                             [](const auto& open) { return open != nullptr; });
        nowhere_ += !is_anywhere;
        for (Channel* const channel : leading_to(frame.destination())) {
            left = channel->outbox.push(frame, policy_of(frame.id()), now()) == nullptr || left;
            link_->flush(*channel);
        }
        return left;
    }
    ano::Flush flush_parser(ano::FrameView next) {
        const LinkSettings& s = link_->settings();
        ano::Flush all;
        for (Channel* const channel : leading_to(next.destination())) {
            const bool flushes = channel->outbox.flush_parser(now());
            const ano::Duration busy = time_of_flush(channel->outbox.zeros(), line_rate_of(s).bytes_per_second);
            all = all |
                  (flushes ? ano::Flush{.sent = true, .busy = busy} : ano::Flush{.later = channel->outbox.until_flush(now())});
            link_->flush(*channel);
        }
        return all;
    }
    const std::string& name() const noexcept { return link_->name(); }
    bool is_up() const noexcept { return up_; }
    std::string trouble() const { return up_ ? link_->trouble().text : std::string{}; }
    std::uint64_t skipped() const noexcept {
        std::uint64_t bytes = gone_skipped_ + unassigned().received.skipped_bytes;
        for (const auto& open : channels_)
            if (open) bytes += open->channel.parser.counters().skipped_bytes;
        return bytes;
    }
    std::size_t waiting() const noexcept {
        std::size_t frames = 0;
        for (const auto& open : channels_)
            if (open) frames += open->channel.outbox.waiting();
        return frames;
    }
    std::uint64_t dropped_frames() const noexcept {
        std::uint64_t frames = gone_dropped_frames_ + nowhere_;
        for (const auto& open : channels_)
            if (open) frames += offered_and_not_sent(open->channel) - open->channel.outbox.waiting();
        return frames;
    }

private:
    UnassignedTraffic unassigned() const {
        const UnassignedReceiver* const receiver = link_->as<UnassignedReceiver>();
        return receiver ? receiver->unassigned_traffic() : UnassignedTraffic{};
    }
    // The channels on which frames from `address` were received; if there are none, all channels.
    std::vector<Channel*> leading_to(std::uint8_t address) const {
        std::vector<Channel*> all, heard;
        for (const auto& open : channels_) {
            if (!open) continue;
            all.push_back(&open->channel);
            if (open->heard.source(address)) heard.push_back(&open->channel);
        }
        return heard.empty() ? all : heard;
    }
    static std::uint64_t offered_and_not_sent(const Channel& channel) noexcept {
        return channel.outbox.counters().offered - channel.outbox.counters().frames_out;
    }
    struct Open {
        template <class... Args>
        explicit Open(Args&&... args) : channel{std::forward<Args>(args)...} {}
        Channel channel;
        ano::Heard heard;
    };

    Channel* open_channel(Link& link, std::string peer) override {
        std::size_t i = 0;
        while (i < channels_.size() && channels_[i]) ++i;
        if (i == max_channels) return nullptr;
        if (i == channels_.size()) channels_.emplace_back();
        const LinkSettings& s = link.settings();
        channels_[i] = std::make_unique<Open>(
            static_cast<ChannelId>(i), link.id(), std::move(peer),
            ano::FrameParser::Options{s.max_data, 0, quiet_of(*s.kind), s.frame_gap.value_or(Duration{})},
            Outbox::Options{s.queue, s.effective_max_data_out(), s.age, flush_bytes_of(s)}, now_);
        if (up_) channels_[i]->channel.outbox.open();
        return &channels_[i]->channel;
    }
    void close_channel(Channel& channel, std::string_view) override {
        gone_skipped_ += channel.parser.counters().skipped_bytes;
        gone_dropped_frames_ += offered_and_not_sent(channel);
        channels_[index(channel.id)].reset();
    }
    void receive(Channel& channel, ano::FrameView frame) override {
        channel.record_received(now_);
        channels_[index(channel.id)]->heard.note(frame);
        heard_ = true;
        if (done_) return;
        const auto time = std::chrono::system_clock::now().time_since_epoch();
        const std::string& where = channel.peer.empty() ? link_->name() : channel.peer;
        if (!receiver_.accept(frame, {where, std::chrono::duration<double>(time).count()})) finish_soon();
    }
    void flush() override {
        if (!receiver_.flush()) finish_soon();
    }
    // ", to PEER from ADDRESS", ", at ADDRESS" or, of a link without addresses, ": device /dev/ttyUSB0, baud 500000".
    static std::string end_points(const LinkFacts& facts) {
        std::string all, peer, address;
        for (const auto& [name, value] : facts) {
            const std::string text = std::visit([](const auto& v) { return to_string(v); }, value);
            if (name == "peer") peer = ", to " + text;
            if (name == "address") address = (peer.empty() ? ", at " : " from ") + text;
            all.append(all.empty() ? ": " : ", ").append(name).append(" ").append(text);
        }
        return peer.empty() && address.empty() ? all : peer + address;
    }
    void changed(Link& link, LinkEvent event, LinkError why) override {
        if (event == LinkEvent::up) came_up(link);
        if (event == LinkEvent::down) went_down(link, std::move(why));
    }
    void came_up(Link& link) {
        for (const auto& open : channels_)
            if (open) open->channel.outbox.open();
        if (!up_ && !who_.empty()) complain(link.name() + " is up" + end_points(link.facts()));
        if (!up_) up_at_ = now();
        up_ = true;
        why_.clear();
    }
    void went_down(Link& link, LinkError error) {
        for (const auto& open : channels_)
            if (open) open->channel.outbox.close();
        std::string& why = error.text;
        const bool has_gateway = why.ends_with("in use by another gateway") || why.find("in use by anogated (") != why.npos;
        if (why != why_) complain(link.name() + ": waiting: " + why + (has_gateway ? how_to_watch : ""));
        up_ = false;
        why_ = std::move(why);
    }
    TimePoint now() override { return now_ = Clock::now(); }
    const StallDetector& turn() override {
        loop_.turn(read_clocks());
        now_ = loop_.now();
        return loop_;
    }

    // Checks periodically for a hint, as in the status of a gateway, and prints it. After the first frame, only hints about
    // faults.
    void look_later() {
        look_.expires_after(look_every_);
        look_.async_wait([this](error_code ec) {
            if (ec || done_) return;
            std::string hint = heard_ ? hint_of_trouble(figures()) : anogate::hint(figures());
            const bool is_silent = figures().received.bytes_in == 0 && !figures().listens;
            if (!hint.empty() && is_silent && !has_sent_) hint += only_listens(who_);
            if (!hint.empty() && hint != hint_) complain(link_->name() + ": " + hint);
            hint_ = std::move(hint);
            look_later();
        });
    }
    LinkFigures figures() {
        const UnassignedTraffic unassigned = this->unassigned();
        LinkFigures f;
        f.words = link_->settings().kind->hints;
        f.up = up_;
        f.listens = link_->settings().kind->listens;
        f.received = unassigned.received;
        f.v7_frames = unassigned.v7_frames;
        f.may_use_v7 = may_use_v7(*link_->settings().kind);
        if (unassigned.parser) add_skipped(f, *unassigned.parser);
        f.up_for = now() - up_at_;
        for (const auto& open : channels_) {
            if (!open) continue;
            const Channel& channel = open->channel;
            ++f.channels;
            add(f.received, channel.received());
            f.skipped_since += channel.skipped_since_heard();
            const auto ago = [&](TimePoint then, std::optional<Duration>& least) {
                if (then != TimePoint{}) least = std::min(least.value_or(Duration::max()), now_ - then);
            };
            ago(channel.heard_at, f.silent_for);
            ago(channel.arrived_at, f.bytes_ago);
            f.v7_frames += channel.parser.counters().v7_frames;
            f.long_images += channel.parser.counters().long_images;
            add_skipped(f, channel.parser);
        }
        return f;
    }

    // Posted, because a link must not be closed within its own callback.
    void finish_soon() {
        if (std::exchange(done_, true)) return;
        asio::post(io_, [this] {
            stop();
            io_.stop();
        });
    }
    void complain(const std::string& words) { print_note(streams_, words); }

    asio::io_context& io_;
    AlarmClock alarms_{io_};
    DatagramBatch batch_;
    DatagramSender sender_;
    Resolver names_{io_};
    V7Lines v7_lines_;
    FrameReceiver& receiver_;
    Streams& streams_;
    const std::string who_;
    const Duration look_every_;
    std::vector<std::unique_ptr<Open>> channels_;
    std::unique_ptr<Link> link_;
    TimePoint now_{};
    StallDetector loop_;    // required by links; the age of frames is not used
    asio::steady_timer look_{io_};
    std::string hint_;
    bool up_ = false, heard_ = false, has_sent_ = false;
    bool done_ = false, stopped_ = false;
    TimePoint up_at_{};
    std::string why_;
    std::uint64_t gone_skipped_ = 0, gone_dropped_frames_ = 0;
    std::uint64_t nowhere_ = 0;    // frames sent while no channel was open
};

OwnLink::OwnLink(asio::io_context& io, const LinkSettings& settings, FrameReceiver& receiver, Streams& streams, std::string who,
                 Duration look_every)
    : host_{std::make_unique<Host>(io, settings, receiver, streams, std::move(who), look_every)} {
    if (settings.kind->encrypts) std::signal(SIGPIPE, SIG_IGN);    // OpenSSL raises it when it sends after the peer has closed
}
OwnLink::~OwnLink() = default;

void OwnLink::start() { host_->start(); }
void OwnLink::stop() { host_->stop(); }
bool OwnLink::send(ano::FrameView frame) { return host_->send(frame); }
ano::Flush OwnLink::flush_parser(ano::FrameView next) { return host_->flush_parser(next); }
const std::string& OwnLink::name() const noexcept { return host_->name(); }
bool OwnLink::is_up() const noexcept { return host_->is_up(); }
std::string OwnLink::trouble() const { return host_->trouble(); }
std::uint64_t OwnLink::skipped() const noexcept { return host_->skipped(); }
std::size_t OwnLink::waiting() const noexcept { return host_->waiting(); }
std::uint64_t OwnLink::dropped_frames() const noexcept { return host_->dropped_frames(); }

std::uint64_t listen(const std::string& link, FrameReceiver& receiver, Streams& streams, const std::string& who) {
    const LinkSettings settings = link_settings_of(link);
    if (const std::string idle = keys_idle_for_listener(link); !idle.empty())
        streams.err << "anoctl: ignored: " << idle << "; " << who << " only receives\n";
    asio::io_context io{1};
    asio::signal_set signals{io, SIGINT, SIGTERM};
    OwnLink own{io, settings, receiver, streams, who};
    signals.async_wait([&](error_code ec, int) {
        if (ec) return;
        own.stop();
        io.stop();
    });
    own.start();
    io.run();
    return own.skipped();
}

}    // namespace anoctl
