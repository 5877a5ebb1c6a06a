// anoctl monitor LINK: the frames that come in by a link of our own; without a LINK, those of the gateway that runs.
#include "anoctl.hpp"
#include "frame_printer.hpp"
#include "gateway.hpp"
#include "watch.hpp"

#include <config/config.hpp>
#include <config/key_facts.hpp>
#include <gateway/hints.hpp>
#include <link/alarm.hpp>
#include <link/asio.hpp>
#include <link/clocks.hpp>
#include <link/datagram_batch.hpp>
#include <link/datagram_sender.hpp>
#include <link/kinds.hpp>
#include <link/link_context.hpp>

#include <algorithm>
#include <bitset>
#include <chrono>
#include <csignal>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using namespace anogate;

constexpr Duration look_every = std::chrono::seconds{3};
constexpr char only_listens[] =
    "; monitor itself never speaks, and some speak only when spoken to: let anogated do it, with hello=on";

constexpr char how_to_watch[] = "; to watch the gateway that has it: anoctl monitor, without a LINK";

using IdSet = std::bitset<256>;

// Keys of a link that concern sending, or what a gateway does with received frames.
bool matters_to_a_listener(std::string_view key) {
    constexpr std::string_view others[]{"id",   "hello",   "flood", "broadcast", "group",   "present_as",   "queue",   "rate",
                                        "pace", "latency", "pack",  "mtu",       "trusted", "max_data_out", "required"};
    constexpr std::string_view groups[]{"send.", "receive.", "limit.", "age."};
    return std::find(std::begin(others), std::end(others), key) == std::end(others) &&
           std::none_of(std::begin(groups), std::end(groups), [&](std::string_view group) { return key.starts_with(group); });
}

/// "hello, limit.0x01": the keys of a LINK text that have no effect here.
std::string idle_keys(std::string_view link) {
    std::string idle;
    const auto pieces = split(link, ',');
    for (const std::string_view piece : std::span{pieces}.subspan(1)) {
        const std::string_view key = piece.substr(0, piece.find('='));
        if (!matters_to_a_listener(key)) idle.append(idle.empty() ? "" : ", ").append(key);
    }
    return idle;
}

struct Filter {
    IdSet ids, from, to;

    bool takes(ano::FrameView frame) const { return ids[frame.id()] && from[frame.source()] && to[frame.destination()]; }
};

/// The host of the one link: shows what it receives, sends nothing.
class Monitor final : public LinkHost {
public:
    Monitor(const LinkSettings& settings, const Filter& filter, std::uint64_t count, Streams& streams, const FrameOptions& frames)
        : filter_{filter},
          left_{count},
          streams_{streams},
          printer_{streams, frames},
          link_{settings.kind->make(LinkId{0}, settings, {io_, alarms_, *this, batch_, sender_})} {}

    int run() {
        asio::signal_set signals{io_, SIGINT, SIGTERM};
        signals.async_wait([this](error_code ec, int) {
            if (!ec) stop();
        });
        link_->start();
        look_later();
        io_.run();
        complain() << shown_ << (shown_ == 1 ? " frame" : " frames") << " shown of " << seen_ << ", " << skipped()
                   << " bytes of no frame\n";
        return fine;
    }

private:
    Channel* open_channel(Link& link, std::string peer) override {
        std::size_t i = 0;
        while (i < channels_.size() && channels_[i]) ++i;
        if (i == max_channels) return nullptr;
        if (i == channels_.size()) channels_.emplace_back();
        const LinkSettings& s = link.settings();
        channels_[i] = std::make_unique<Channel>(static_cast<ChannelId>(i), link.id(), std::move(peer),
                                                 ano::FrameParser::Options{s.max_data, 0, quiet_of(*s.kind)},
                                                 Outbox::Options{s.queue, s.effective_max_data_out()}, now_);
        return channels_[i].get();
    }
    void close_channel(Channel& channel) override {
        gone_skipped_ += channel.parser.counters().skipped_bytes;
        channels_[index(channel.id)].reset();
    }
    void receive(Channel& channel, ano::FrameView frame) override {
        channel.hear(now_);
        ++seen_;
        if (done_ || !filter_.takes(frame)) return;
        const auto time = std::chrono::system_clock::now().time_since_epoch();
        const std::string& where = channel.peer.empty() ? link_->name() : channel.peer;
        printer_.print(frame, {where, std::chrono::duration<double>(time).count()});
        ++shown_;
        if (left_ > 0 && --left_ == 0) finish_soon();
    }
    void flush() override {
        if (!streams_.out.flush()) finish_soon();
    }
    void link_up(Link& link) override {
        std::string facts;
        for (const auto& [name, value] : link.facts()) {
            facts.append(facts.empty() ? ": " : ", ").append(name).append(" ");
            std::visit([&](const auto& v) { facts += text_of(v); }, value);
        }
        if (!up_) complain() << link.name() << " is up" << facts << std::endl;
        if (!up_) up_at_ = now();
        up_ = true;
        why_.clear();
    }
    void link_down(Link& link, LinkError error) override {
        std::string& why = error.text;
        const bool has_gateway = why.ends_with("in use by another gateway") || why.find("in use by anogated (") != why.npos;
        if (why != why_) complain() << link.name() << ": waiting: " << why << (has_gateway ? how_to_watch : "") << std::endl;
        up_ = false;
        why_ = std::move(why);
    }
    TimePoint now() override { return now_ = Clock::now(); }
    const LoopWatch& turn() override {
        loop_.turn(read_clocks());
        now_ = loop_.now();
        return loop_;
    }

    // The hint that a gateway's status would have; after the first frame, only when something is wrong.
    void look_later() {
        look_.expires_after(look_every);
        look_.async_wait([this](error_code ec) {
            if (ec || done_) return;
            std::string hint = seen_ > 0 ? hint_of_trouble(figures()) : anogate::hint(figures());
            if (!hint.empty() && figures().received.bytes_in == 0 && !figures().listens) hint += only_listens;
            if (!hint.empty() && hint != hint_) complain() << link_->name() << ": " << hint << std::endl;
            hint_ = std::move(hint);
            look_later();
        });
    }
    LinkFigures figures() {
        const UnassignedTraffic unassigned = link_->unassigned_traffic();
        LinkFigures f;
        f.words = link_->settings().kind->hints;
        f.up = up_;
        f.listens = link_->settings().kind->listens;
        f.received = unassigned.received;
        f.v7_frames = unassigned.v7_frames;
        f.up_for = now() - up_at_;
        for (const auto& channel : channels_) {
            if (!channel) continue;
            ++f.channels;
            add(f.received, channel->received());
            f.skipped_since += channel->skipped_since_heard();
            const auto ago = [&](TimePoint then, std::optional<Duration>& least) {
                if (then != TimePoint{}) least = std::min(least.value_or(Duration::max()), now_ - then);
            };
            ago(channel->heard_at, f.silent_for);
            ago(channel->arrived_at, f.bytes_ago);
            f.v7_frames += channel->parser.counters().v7_frames;
        }
        return f;
    }

    static std::string text_of(const std::string& text) { return text; }
    static std::string text_of(std::int64_t number) { return std::to_string(number); }

    // A link must not be closed while it calls us.
    void finish_soon() {
        if (done_) return;
        done_ = true;
        asio::post(io_, [this] { stop(); });
    }
    void stop() {
        done_ = true;
        link_->stop_reading();
        link_->stop();
        io_.stop();
    }
    std::uint64_t skipped() const {
        std::uint64_t bytes = gone_skipped_ + link_->unassigned_traffic().received.skipped_bytes;
        for (const auto& channel : channels_)
            if (channel) bytes += channel->parser.counters().skipped_bytes;
        return bytes;
    }
    std::ostream& complain() {
        streams_.out.flush();
        return streams_.err << "anoctl: ";
    }

    asio::io_context io_{1};
    AlarmClock alarms_{io_};
    DatagramBatch batch_;
    DatagramSender sender_;
    Filter filter_;
    std::uint64_t left_;    // 0: no end
    Streams& streams_;
    FramePrinter printer_;
    std::vector<std::unique_ptr<Channel>> channels_;
    std::unique_ptr<Link> link_;
    TimePoint now_{};
    LoopWatch loop_;    // needed by links; the age of a frame is not used here
    asio::steady_timer look_{io_};
    std::string hint_;
    bool up_ = false;
    TimePoint up_at_{};
    bool done_ = false;
    std::string why_;
    std::uint64_t seen_ = 0;
    std::uint64_t shown_ = 0;
    std::uint64_t gone_skipped_ = 0;
};

struct MonitorOptions {
    std::string link;
    std::vector<std::string> ids, from, to, links, directions;
    std::uint64_t count = 0;
    FrameOptions frames;
    GatewayOptions gateway;

    int run(Streams& streams) const {
        if (link.empty()) return attach(streams);
        if (!links.empty() || !directions.empty())
            throw UsageError{"--link and --direction are for the frames of a gateway: without a LINK"};
        const Filter filter{ids_of(ids), addresses_of("--from", from), addresses_of("--to", to)};
        const LinkSettings settings = link_settings();
        if (const std::string idle = idle_keys(link); !idle.empty())
            streams.err << "anoctl: of no effect here: " << idle
                        << ". monitor only listens; --id, --from and --to choose what is shown\n";
        return Monitor{settings, filter, count, streams, as_said_of(settings)}.run();
    }

private:
    int attach(Streams& streams) const {
        for (const auto* words : {&ids, &from, &to, &links, &directions})    // which take every word behind them
            for (const std::string& word : *words)
                if (word.find(':') != word.npos) throw UsageError{ano::in_quotes(word) + ": a LINK stands before the options"};
        const std::string query = filter_words("id", ids) + filter_words("from", from) + filter_words("to", to) +
                                  filter_words("link", links) + filter_words("direction", directions);
        return watch({gateway.socket(), query, count, frames}, streams);
    }
    // The option, otherwise the key of the link.
    FrameOptions as_said_of(const LinkSettings& settings) const {
        FrameOptions options = frames;
        if (!options.encoding && settings.text_encoding() == TextEncoding::gbk) options.encoding = ano::Encoding::gbk;
        if (!options.value_type_7) options.value_type_7 = settings.meaning_of_type_7();
        return options;
    }
    LinkSettings link_settings() const {
        anogate::Draft draft{link_kinds()};
        read_link(link, "", draft);
        validate(draft);
        if (!draft.errors.empty()) {
            const ConfigError& first = draft.errors.front();
            const bool is_name = link.find_first_of(":/,=") == link.npos;
            throw UsageError{(first.where.empty() ? "" : first.where + ": ") + first.what +
                             (is_name ? "; a link of the gateway, by its name: monitor --link " + ano::in_quotes(link) : "")};
        }
        return draft.settings.links.at(0);
    }
    static IdSet ids_of(const std::vector<std::string>& words) {
        if (words.empty()) return IdSet{}.set();
        IdSet set;
        for (const std::string& word : words) set.set(message_id_of(word, "--id: "));
        return set;
    }
    static IdSet addresses_of(const char* option, const std::vector<std::string>& words) {
        if (words.empty()) return IdSet{}.set();
        IdSet set;
        for (const std::string& word : words) {
            const auto address = ano::address_called(word);
            if (const auto* fault = std::get_if<ano::JsonFault>(&address))
                throw UsageError{std::string{option} + ": " + fault->what};
            set.set(std::get<std::uint8_t>(address));
        }
        return set;
    }
};

}    // namespace

Run add_monitor(Options& options) {
    const auto self = std::make_shared<MonitorOptions>();
    const auto read_count = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        const auto* count = number ? std::get_if<std::uint64_t>(&*number) : nullptr;
        if (count == nullptr || *count == 0) return ano::in_quotes(word) + " is not a number of frames, 1 or more";
        self->count = *count;
        return {};
    };
    options.push_back({"link", &self->link, "LINK",
                       "A link to listen at, as for anogated: serial:/dev/ttyUSB0,baud=500000 udp-listen:0.0.0.0:12333 pty:PATH; "
                       "without it, the frames of the gateway that runs: what comes, what leaves, and what is dropped and why"});
    options.push_back({"--id", &self->ids, "ID...", "Only these messages, by name or id"});
    options.push_back({"--from", &self->from, "ADDRESS...", "Only from these addresses"});
    options.push_back({"--to", &self->to, "ADDRESS...", "Only to these addresses"});
    options.push_back({"--link", &self->links, "LINK...", "Of the gateway: only by these links, by name"});
    options.push_back(
        {"--direction", &self->directions, "in|out|dropped...", "Of the gateway: only what comes, leaves or is dropped"});
    options.push_back({"--count", Option::Read{read_count}, "N", "Ends after so many frames were shown"});
    GatewayOptions::add(options, self->gateway);
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
