#include <ano/address.hpp>
#include <daemon/gateway.hpp>
#include <gateway/pacer.hpp>
#include <link/clocks.hpp>
#include <link/kinds.hpp>

#include <spdlog/spdlog.h>

#include <random>

namespace anogate {
namespace {

constexpr Duration required_within = std::chrono::seconds{10};
constexpr Duration stop_look = std::chrono::milliseconds{10};
constexpr Duration datagram_quiet = std::chrono::milliseconds{100};
constexpr Duration stream_quiet = std::chrono::milliseconds{50};
constexpr QueuePolicy probe_policy{TrafficClass::urgent, Replaces::nothing, AgeKind::rest};
constexpr Duration hello_slack = std::chrono::milliseconds{100};
constexpr std::uint8_t firmware_id = ano::id_of<"firmware">;
constexpr Duration beat_of_streams = std::chrono::milliseconds{100};    // bytes bear no stamp: half of what sticks may wait
constexpr Duration calm_beat = std::chrono::milliseconds{500};
constexpr Duration calm_after = std::chrono::seconds{2};    // without a byte of a stream: who sends nothing is to cost nothing
constexpr Duration beat_slack = std::chrono::milliseconds{20};

// Of what hosts say, sticks alone overtake.
bool keeps_order(ano::FrameView frame) {
    return ano::address::is_host(frame.source()) && policy_of(frame.id()).replaces == Replaces::nothing && !is_probe(frame);
}

// What the line carries, to know when the rest of a frame is overdue.
std::uint32_t line_rate(const LinkSettings& s) {
    return s.kind == "serial" ? uart_rate(s.serial.baud, s.serial.parity != Parity::none, s.serial.stop_bits) : 0;
}

ano::FrameParser::Options parser_options(const LinkSettings& s) {
    const bool datagrams = s.kind == "udp" || s.kind == "udp-listen" || s.kind == "tunnel";
    return {s.max_data, line_rate(s), datagrams ? datagram_quiet : stream_quiet};
}

bool is_stream(const LinkSettings& s) { return s.kind == "serial" || s.kind == "pty"; }

// Whether a probe may leave by it: never to devices, nor to those who do not take broadcasts.
bool takes_probes(const LinkSettings& s) { return s.broadcast && s.kind != "serial" && s.kind != "can" && s.kind != "sim"; }

std::uint64_t number_of_its_own() {
    std::random_device random;
    return std::uint64_t{random()} << 32 | random();
}

}    // namespace

Gateway::Gateway(asio::io_context& io, Settings settings)
    : io_{io},
      settings_{std::move(settings)},
      alarms_{io},
      peer_log_{alarms_},
      router_{settings_.gateway},
      loop_guard_{number_of_its_own()},
      release_{alarms_, [this] { release_held(); }},
      beat_{alarms_, [this] { beat(); }, beat_slack},
      hello_due_{alarms_, [this] { look_at_hellos(); }, hello_slack},
      questions_due_{alarms_, [this] { look_at_questions(); }},
      claims_due_{alarms_,
                  [this] {
                      now();
                      look_at_claims();
                      flush();
                  }},
      required_check_{alarms_,
                      [this] {
                          for (const LinkState& s : links_)
                              if (s.link->settings().required && !s.was_up) return on_required_missing_(s.link->name());
                      }},
      stop_check_{alarms_, [this] {
                      if (nothing_waits() || now() >= stop_by_) finish_stop();
                      else stop_check_.set(now_ + stop_look);
                  }} {
    links_.reserve(max_links);
    add_links();
    if (settings_.tunnel) add_tunnel(*settings_.tunnel);
    add_aliases();
    add_presentations();
    gpio_ = std::make_unique<Gpio>(io_, alarms_, settings_.gpio,
                                   [this](const std::string& name) -> Link& { return *links_[index(link_named(name))].link; });
    for (const RouteSettings& route : settings_.routes) router_.pin(route.first, route.last, link_named(route.link));
    if (settings_.gateway.unknown == Unknown::link) router_.set_unknown_link(link_named(settings_.gateway.unknown_link));
}

Gateway::~Gateway() = default;

void Gateway::add_links() {
    std::vector<std::string> groups{""};
    for (const LinkSettings& link : settings_.links) {
        auto group = std::find(groups.begin(), groups.end(), link.group);
        if (group == groups.end()) group = groups.insert(group, link.group);
        const auto number = static_cast<std::uint8_t>(group - groups.begin());
        const LinkId id = router_.add_link({link.id, link.flood, link.broadcast, number});
        LinkState& added = links_.emplace_back();
        added.link = make_link(id, link, {io_, alarms_, *this, batch_, sender_});
        added.group = number;
        if (is_stream(link)) streams_.insert(id);
        give_rules(added, link.rules, link.profile != Profile::vendor);
        give_hello(added, link);
    }
}

void Gateway::give_rules(LinkState& link, const RuleSettings& settings, bool sends_empty) {
    if (settings == RuleSettings{} && sends_empty) return;
    link.rules = std::make_unique<Rules>(settings, sends_empty);
    ruled_.insert(link.link->id());
}

void Gateway::give_hello(LinkState& link, const LinkSettings& settings) {
    if (settings.hello_interval() == Duration{} || !settings.broadcast) return;
    link.hello.emplace(settings.hello_interval());
    ruled_.insert(link.link->id());
}

void Gateway::add_aliases() {
    for (const LinkState& s : links_) {
        std::vector<AliasRule> rules;
        for (const AliasSettings& alias : settings_.aliases)
            if (alias.link == s.link->name()) rules.push_back({alias.device, alias.as});
        if (rules.empty()) continue;
        const std::size_t largest = std::max(s.link->settings().max_data, s.link->settings().effective_max_data_out());
        for (const AliasRule& rule : rules) router_.pin(rule.as, rule.as, s.link->id());    // it is nowhere else
        links_[index(s.link->id())].aliases = std::make_unique<Aliases>(rules, largest);
        ruled_.insert(s.link->id());
    }
}

// An answer may come by another link of the group than the question went.
void Gateway::add_presentations() {
    std::array<PresentAs*, max_links + 1> of_group{};
    std::uint16_t largest = 0;
    for (const LinkState& s : links_) largest = std::max(largest, s.link->settings().max_data);
    for (LinkState& s : links_) {
        const LinkSettings& link = s.link->settings();
        if (link.present_as == 0) continue;
        PresentAs*& common = of_group[s.group];
        if (s.group == 0 || !common) common = presentations_.emplace_back(new PresentAs{link.present_as, largest}).get();
        if (link.id != 0) common->add_port(link.id);
        s.present_as = common;
        ruled_.insert(s.link->id());
    }
}

void Gateway::add_tunnel(const TunnelSettings& settings) {
    std::vector<TunnelLink::Target> wrap_to;
    for (const WrapSettings& rule : settings.wrap) {
        const LinkId to = link_named(rule.link);
        wrap_to.push_back({to, links_[index(to)].link->settings().effective_max_data_out()});
    }
    for (const std::string& name : settings.links) tunnelled_.insert(link_named(name));
    const LinkId id = router_.add_link({});
    auto tunnel = std::make_unique<TunnelLink>(id, settings_, std::move(wrap_to),
                                               LinkContext{io_, alarms_, *this, batch_, sender_}, *this);
    tunnel_ = tunnel.get();
    links_.emplace_back().link = std::move(tunnel);
    give_rules(links_.back(), settings.rules, true);
}

void Gateway::start(std::function<void(const std::string&)> on_required_missing) {
    on_required_missing_ = std::move(on_required_missing);
    started_at_ = turn().now();
    for (LinkState& s : links_) s.since = started_at_;
    gpio_->start();
    for (LinkState& s : links_) s.link->start();
    beat();    // to open them may take long
    if (std::any_of(links_.begin(), links_.end(), [](const LinkState& s) { return s.link->settings().required; }))
        required_check_.set(started_at_ + required_within);
}

void Gateway::stop(Duration patience, std::function<void()> on_stopped) {
    if (on_stopped_) {
        if (stop_check_.is_set()) finish_stop();
        return;
    }
    on_stopped_ = std::move(on_stopped);
    required_check_.cancel();
    beat_.cancel();
    hello_due_.cancel();
    questions_due_.cancel();
    claims_due_.cancel();
    for (LinkState& s : links_) s.link->stop_reading();
    for (const ChannelId id : used_)    // nobody reads an answer any more
        if (auto& questions = channels_[index(id)]->questions) questions->close();
    flush();
    stop_by_ = now() + patience;
    stop_check_.set(now_ + stop_look);    // what was written just now shows in the kernel's counts a moment later
}

const LoopWatch& Gateway::turn() {
    const ClockReading clocks = read_clocks();
    now_ = clocks.now;
    if (const LoopWatch::Turn turn = loop_.turn(clocks); turn.stood > Duration::zero()) stood_still(turn);
    return loop_;
}

// Where it has stood still, the beat comes behind all that was to be read then: but not when it is the one to notice.
void Gateway::beat() {
    noticed_ = false;
    turn();
    if (!noticed_) loop_.end_standstill();
    calm_ = !noticed_ && !streams_speak();
    const Duration period = calm_ ? calm_beat : beat_of_streams;
    loop_.beat(period + beat_slack);
    beat_.set(now_ + period);
}

void Gateway::hasten_beat() {
    calm_ = false;
    loop_.beat(beat_of_streams + beat_slack);
    beat_.set_no_later(now_ + beat_of_streams);
}

bool Gateway::streams_speak() const {
    for (const ChannelId id : used_) {
        const Channel& channel = *channels_[index(id)];
        if (streams_.contains(channel.link) && now_ - channel.arrived_at < calm_after) return true;
    }
    return false;
}

// Between calm beats: a stream wants more of them, and the stamp of what waited tells as well.
void Gateway::notice_standstill(LinkId from) {
    if (streams_.contains(from)) {
        if (calm_) hasten_beat();
    } else if (const Duration stood = loop_.waited(arrived_at_); stood > Duration::zero()) {
        standstill_log_.stood({.stood = stood, .is_told = true}, now_);
    }
}

void Gateway::stood_still(const LoopWatch::Turn& turn) {
    noticed_ = true;
    if (beat_.is_set()) beat_.set_no_later(now_ + beat_of_streams);
    standstill_log_.stood(turn, now_);
    if (turn.suspended == Duration::zero()) return;
    for (const ChannelId id : used_) {
        channels_[index(id)]->outbox.grow_older(turn.suspended);
        if (auto& questions = channels_[index(id)]->questions) questions->grow_older(turn.suspended);
    }
}

Channel* Gateway::open_channel(Link& link, std::string peer) {
    std::size_t i = 0;
    while (i < max_channels && used_.contains(static_cast<ChannelId>(i))) ++i;
    if (i == max_channels) return nullptr;
    const auto id = static_cast<ChannelId>(i);
    const LinkSettings& s = link.settings();
    channels_[i].reset(new Channel{id,
                                   link.id(),
                                   std::move(peer),
                                   ano::FrameParser{parser_options(s)},
                                   Outbox{{s.queue, s.effective_max_data_out(), s.age}},
                                   {},
                                   now_,
                                   {},
                                   {},
                                   false,
                                   {}});
    if (s.profile == Profile::vendor)
        channels_[i]->questions = std::make_unique<QuestionQueue>(channels_[i]->outbox,
                                                                  QuestionQueue::Options{s.queue, s.age.rest});
    used_.insert(id);
    state(link).channels.insert(id);
    router_.open(id, link.id());
    loop_guard_.open(id, link.id(), state(link).group, takes_probes(s), now_);
    if (!channels_[i]->peer.empty() && state(link).up) peer_log_.came(link.name(), channels_[i]->peer, now_);
    return channels_[i].get();
}

void Gateway::close_channel(Channel& channel) {
    LinkState& s = links_[index(channel.link)];
    channel.routed.looped += held_.forget(channel.id) + loop_guard_.take_lost(channel.id, TimePoint::max());
    loop_guard_.close(channel.id);
    if (s.up) peer_log_.went(s.link->name(), channel.peer, now_);
    channel.outbox.close();
    if (channel.questions) channel.questions->close();
    add(s.gone_received, channel.received());
    add(s.gone_sent, channel.sent());
    s.channels.erase(channel.id);
    used_.erase(channel.id);
    to_flush_.erase(channel.id);
    router_.close(channel.id);
    channels_[index(channel.id)].reset();
}

void Gateway::receive(Channel& from, ano::FrameView frame) {
    if (!held_.empty()) make_room_for(from, frame);
    ++frame_number_;
    arrived_at_ = std::min(from.arrived_at, now_);
    if (!releasing_) notice_standstill(from.link);
    from.hear(now_);
    if (gpio_->watches(from.link)) gpio_->heard(from.link, now_);
    if (from.questions && from.questions->hear(frame, now_)) to_flush_.insert(from.id);
    const QueuePolicy policy = policy_of(frame.id());
    const ano::FrameView brought = frame;
    if (Aliases* aliases = links_[index(from.link)].aliases.get()) frame = aliases->inbound(frame, now_);
    if (!loop_guard_.rings().is_ring(from.id, now_) && router_.heard_again(from.id, frame.source(), now_)) log_conflict();
    Said said = said_at(from, frame);
    said.waited = releasing_;
    said.hurried = hurrying_;
    std::uint32_t copies = 1;
    if (came_before(from, frame, brought, policy, said, copies)) return;
    compare(from, frame, said.key);
    PresentAs* const hosts = links_[index(from.link)].present_as;
    if (hosts) frame = hosts->inbound(frame, now_);    // not of a copy
    if (!admit(from, frame)) return;
    if (tunnelled_.contains(from.link) && tunnel_->takes(frame)) return tunnel_->carry(from, frame);
    if (!admit_unopened(from, frame)) return;
    if (is_probe(frame)) return take_probe(from, frame);
    Route route = router_.route(from.id, frame.source(), frame.destination(), now_);
    if (tunnel_ && from.link == tunnel_->id() && is_tunnel_frame(frame)) keep_from_tunnel(route);
    if (hosts) said.key = key_of(frame);
    if (!route.guarded.empty()) loop_guard_.remember(said, from.id, route.guarded, now_);
    for (; copies > 0; --copies)
        for (const ChannelId to : route.channels) offer(from.id, to, frame, policy, arrived_at_);
    for (const LinkId to : route.absent) refuse(to, &SendCounters::link_down);
    const bool to_host = ano::address::is_host(frame.destination());
    if (route.channels.empty() && route.absent.empty() && route.via != Via::own) {
        ++from.routed.no_route;
        if (to_host) links_[index(from.link)].untaken.note(now_);
    } else if (to_host && !route.channels.empty()) {
        links_[index(from.link)].untaken.taken();
    }
    if (route.new_conflict) log_conflict();
    if (router_.has_question(now_)) look_at_claims();
}

Said Gateway::said_at(const Channel& from, ano::FrameView frame) const {
    Said said = said_by(frame);
    said.speaks = router_.speaks(frame.source(), from.id);
    said.arrived = arrived_at_;
    return said;
}

// Asks those whose address is claimed by others. Such a question may come back by any link, like a hello.
void Gateway::look_at_claims() {
    while (const auto question = router_.take_question(now_)) {
        const auto bytes = device_info_question(question->address);
        const ano::FrameView frame{bytes};
        for (const ChannelId to : question->channels) {
            say(to, frame);
            loop_guard_.remember(said_by(frame), to, to, now_);
        }
        ++frame_number_;
    }
    if (const auto next = router_.next_question(); next && !on_stopped_) claims_due_.set(*next);
    else claims_due_.cancel();
}

// A source on two links is a conflict, whatever becomes of its copies.
void Gateway::compare(const Channel& from, ano::FrameView frame, std::uint64_t key) {
    const std::uint8_t source = frame.source();
    if (ano::address::is_host(source)) return;
    const auto other = same_device_.heard(source, from.link, key, now_);
    const std::uint8_t group = links_[index(from.link)].group;
    if (!other || (group != 0 && group == links_[index(*other)].group)) return;
    const auto claimant = router_.claims(source, from.id) ? std::optional{from.id} : std::nullopt;
    router_.note_conflict(source, LinkSet{from.link} | *other, claimant, now_);
    log_conflict();
}

// Our own, come back by another way, or a copy of one that another link of the group brought: that is told by what was
// `brought`, before its alias. `copies`: those of it that were withheld leave with it.
bool Gateway::came_before(Channel& from, ano::FrameView frame, ano::FrameView brought, QueuePolicy policy, const Said& said,
                          std::uint32_t& copies) {
    if (!held_.empty() && !releasing_ && keeps_order(frame))    // what a host says stays in its order
        if (const auto due = held_.due(from.id); due && hold(from, brought, *due)) return true;
    from.routed.looped += loop_guard_.take_lost(from.id, now_);
    const LoopGuard::Judgement judgement = loop_guard_.judge(said, from.id, now_);
    copies = judgement.copies;
    if (judgement.probe) send_probe(from.id);
    if (judgement.fate == LoopGuard::Fate::waits && !releasing_ &&
        hold(from, brought, now_ + judgement.wait, {judgement.repeats, now_ + LoopGuard::come_together}))
        return true;
    if (judgement.fate == LoopGuard::Fate::ends) {
        if (judgement.elsewhere) compare(from, frame, said.key);
        return end_loop(from, frame), true;
    }
    if (judgement.fate == LoopGuard::Fate::withheld) return true;
    const std::uint8_t group = links_[index(from.link)].group;
    if (group == 0 || !duplicates_.duplicate(key_of(brought), group, from.link, policy.replaces, now_, arrived_at_)) return false;
    ++from.routed.duplicate;
    return true;
}

// The answer is for its host as well, unless nothing but a ring says that there is one.
void Gateway::end_loop(Channel& from, ano::FrameView frame) {
    ++from.routed.looped;
    if (ano::address::is_host(frame.source()) && !loop_guard_.rings().is_ring(from.id, now_)) learn(from, frame);
}

// Ahead of the frame that it is about: in a ring it is back before that.
void Gateway::send_probe(ChannelId channel) {
    ++frame_number_;
    offer(ourselves, channel, loop_guard_.rings().ask(channel, now_), probe_policy, now_);
    ++frame_number_;
}

// Nobody's word, whoever may have passed it on: it teaches no address.
void Gateway::take_probe(Channel& from, ano::FrameView probe) {
    if (loop_guard_.rings().take(probe, from.id, now_) != RingWatch::Probe::news) return void(++from.routed.looped);
    const std::uint8_t group = links_[index(from.link)].group;
    for (const ChannelId to : (loop_guard_.rings().probed() & used_) - from.id)
        if (group == 0 || links_[index(channels_[index(to)]->link)].group != group)
            offer(ourselves, to, probe, probe_policy, now_);
}

bool Gateway::hold(Channel& from, ano::FrameView brought, TimePoint due, Held::Repeats repeats) {
    if (!held_.put(from.id, brought, due, repeats, arrived_at_)) return false;
    release_.set_no_later(due);
    return true;
}

void Gateway::release_held() {
    now();
    release_held_until(now_);
    flush();
}

void Gateway::receive_held(const Held::Frame& held) {
    Channel& from = *channels_[index(held.from)];
    const TimePoint latest = std::exchange(from.arrived_at, held.arrived_at);
    receive(from, held.view());
    from.arrived_at = latest;
}

void Gateway::release_held_until(TimePoint due) {
    releasing_ = true;
    while (const auto held = held_.take(due)) receive_held(*held);
    releasing_ = false;
    if (const auto next = held_.due()) release_.set(*next);
}

void Gateway::hurry(ChannelId from) {
    releasing_ = hurrying_ = true;
    while (const auto held = held_.take(from)) receive_held(*held);
    releasing_ = hurrying_ = false;
}

// A host whose frames wait says more than there is room for: what waits goes first, it must not be overtaken. Or what waits for
// the next of the same bytes has it here.
void Gateway::make_room_for(const Channel& from, ano::FrameView frame) {
    if (!releasing_ && held_.goes_on(from.id, frame, now_)) hurry(from.id);
    if (!releasing_ && keeps_order(frame) && held_.due(from.id) && !held_.fits(frame)) release_held_until(TimePoint::max());
}

// A tunnel frame that came inside another one: the next gateway would open it, and the one after that what is in it.
void Gateway::keep_from_tunnel(Route& route) {
    const ChannelSet kept = route.channels & state(*tunnel_).channels;
    if (kept.empty()) return;
    route.channels -= kept;
    route.guarded -= kept;
    tunnel_->refuse_nested();
}

bool Gateway::admit(Channel& from, ano::FrameView frame) {
    arrived_at_ = std::min(from.arrived_at, now_);
    from.hear(now_);
    LinkState& link = links_[index(from.link)];
    if (link.hello && frame.id() == firmware_id) link.hello->saw_firmware(now_);
    const Rules* rules = link.rules.get();
    if (rules && !rules->takes(frame)) return ++from.routed.denied_in, false;
    if (gpio_->inhibited().contains(from.link) && is_control(frame)) return ++from.routed.inhibited, false;
    return true;
}

// What is inside a tunnel frame that goes on as it is passes nowhere else.
bool Gateway::admit_unopened(Channel& from, ano::FrameView frame) {
    if (!gpio_->inhibited().contains(from.link) || !may_bring_control(frame)) return true;
    ++from.routed.inhibited;
    return false;
}

bool Gateway::passes_loop_guard(Channel& from, ano::FrameView frame, LinkId to) {
    const Said said = said_at(from, frame);
    const LoopGuard::Judgement judgement = loop_guard_.judge(said, from.id, now_);
    if (judgement.probe) send_probe(from.id);
    if (judgement.fate == LoopGuard::Fate::ends) return end_loop(from, frame), false;
    if (judgement.fate == LoopGuard::Fate::withheld) return false;
    from.routed.looped += judgement.copies - 1;    // a datagram has no room for those withheld before it
    loop_guard_.remember(said, from.id, links_[index(to)].channels, now_);
    return true;
}

bool Gateway::may_leave(LinkId to, ano::FrameView frame) {
    if (is_stale(to, frame)) return refuse(to, &SendCounters::stale), false;
    Rules* rules = links_[index(to)].rules.get();
    const auto cause = rules ? rules->refusal(frame, ++frame_number_, now_) : nullptr;
    if (cause) refuse(to, cause);
    if (auto& hello = links_[index(to)].hello; hello && frame.id() == firmware_id) hello->saw_firmware(now_);
    return !cause;
}

bool Gateway::is_stale(LinkId to, ano::FrameView frame) const {
    return now_ - arrived_at_ >= limit(links_[index(to)].link->settings().age, policy_of(frame.id()).age);
}

void Gateway::learn(Channel& from, ano::FrameView frame) {
    router_.learn(from.id, frame.source(), now_);
    log_conflict();
    if (router_.has_question(now_)) look_at_claims();
}

void Gateway::send(LinkId to, ano::FrameView frame) {
    ++frame_number_;
    if (links_[index(to)].channels.empty()) refuse(to, &SendCounters::link_down);
    for (const ChannelId channel : links_[index(to)].channels)
        offer(ourselves, channel, frame, policy_of(frame.id()), arrived_at_);
}

void Gateway::say(ChannelId to, ano::FrameView frame) {
    ++frame_number_;
    offer(ourselves, to, frame, policy_of(frame.id()), now_);
}

void Gateway::offer(ChannelId from, ChannelId to, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at) {
    Channel& channel = *channels_[index(to)];
    if (arrived_at < now_ && channel.outbox.is_open() && channel.outbox.is_stale(policy, now_ - arrived_at)) {
        ++links_[index(channel.link)].came_stale;
        return channel.outbox.refuse(&SendCounters::stale);    // it counts for no limit, and awaits no answer
    }
    channel.hosts_spoke = channel.hosts_spoke || ano::address::is_host(frame.source());
    if (ruled_.contains(channel.link)) {
        LinkState& link = links_[index(channel.link)];
        const auto cause = link.rules ? link.rules->refusal(frame, frame_number_, now_) : nullptr;
        const bool as_it_is = is_probe(frame);    // or nobody would know it again
        if (link.present_as && !cause && !as_it_is) frame = link.present_as->outbound(frame, frame_number_, now_);
        const auto seen = link.aliases && !as_it_is ? link.aliases->outbound(frame, now_) : std::optional{frame};
        if (cause || !seen) return channel.outbox.refuse(cause ? cause : &SendCounters::denied_out);
        frame = *seen;
        if (link.hello && frame.id() == firmware_id) link.hello->saw_firmware(now_);
        if (channel.questions) return ask(from, channel, frame, policy, arrived_at);
    }
    channel.outbox.push(frame, policy, arrived_at, from);
    to_flush_.insert(to);
}

void Gateway::ask(ChannelId from, Channel& channel, ano::FrameView frame, QueuePolicy policy, TimePoint arrived_at) {
    channel.questions->push(frame, policy, now_, from, arrived_at);
    to_flush_.insert(channel.id);
    const auto due = channel.questions->next_look(now_);
    if (due && !on_stopped_) questions_due_.set_no_later(*due);
}

// What was not answered in time makes room for what waits.
void Gateway::look_at_questions() {
    std::optional<TimePoint> next;
    now();
    for (const ChannelId id : used_) {
        const auto& questions = channels_[index(id)]->questions;
        if (!questions) continue;
        if (questions->release(now_)) to_flush_.insert(id);
        if (const auto due = questions->next_look(now_)) next = std::min(next.value_or(TimePoint::max()), *due);
    }
    if (next && !on_stopped_) questions_due_.set(*next);
    flush();
}

TimePoint Gateway::heard_at(const LinkState& link) const {
    TimePoint latest{};
    for (const ChannelId id : link.channels) latest = std::max(latest, channels_[index(id)]->heard_at);
    return latest;
}

// Speaks first where nothing is heard.
void Gateway::look_at_hellos() {
    now();
    for (LinkState& link : links_) {
        const auto due = link.hello ? link.hello->due(heard_at(link)) : std::nullopt;
        if (!due || *due > now_) continue;
        for (const ChannelId id : link.channels) say_hello(id);
        link.hello->said(now_);
    }
    await_hellos();
    flush();
}

// It may come back by any link.
void Gateway::say_hello(ChannelId to) {
    const ano::FrameView hello{hello_frame};
    say(to, hello);
    loop_guard_.remember(said_by(hello), to, to, now_);
}

// Until the first moment at which one can be due: frames that come meanwhile set no alarm.
void Gateway::await_hellos() {
    std::optional<TimePoint> next;
    for (const LinkState& link : links_)
        if (const auto due = link.hello ? link.hello->due(heard_at(link)) : std::nullopt)
            next = std::min(next.value_or(TimePoint::max()), *due);
    if (next && !on_stopped_) hello_due_.set(*next);
}

// A frame that was for the link and for none of its channels.
void Gateway::refuse(LinkId to, std::uint64_t SendCounters::*cause) {
    ++links_[index(to)].gone_sent.offered;
    ++(links_[index(to)].gone_sent.*cause);
}

bool Gateway::is_own_port(std::uint16_t port) const {
    return port != 0 &&
           std::any_of(links_.begin(), links_.end(), [port](const LinkState& s) { return s.link->local_port() == port; });
}

// A link that is flushed may report a failure, and that may bring frames: until nothing is left to do.
void Gateway::flush() {
    while (!to_flush_.empty()) {
        const ChannelId id = *to_flush_.begin();
        to_flush_.erase(id);
        Channel& channel = *channels_[index(id)];
        if (channel.outbox.empty()) continue;
        if (gpio_->watches(channel.link)) gpio_->sends(channel.link, now_);
        links_[index(channel.link)].link->flush(channel);
    }
}

void Gateway::link_up(Link& link) {
    LinkState& s = state(link);
    for (const ChannelId id : s.channels) {
        channels_[index(id)]->outbox.open();
        router_.came_up(id);
    }
    if (s.up) return;
    s.up = s.was_up = true;
    s.since = now_;
    s.error.clear();
    gpio_->link_state(link.id(), true);
    if (s.hello) s.hello->came_up(now_);
    await_hellos();
    spdlog::info("{}: up", link.name());
}

void Gateway::link_down(Link& link, std::string why) {
    LinkState& s = state(link);
    for (const ChannelId id : s.channels) {
        channels_[index(id)]->outbox.close();
        if (auto& questions = channels_[index(id)]->questions) questions->close();
        router_.went_down(id);
    }
    if (s.up || s.error != why) spdlog::warn("{}: {}; waiting for it", link.name(), why);
    if (s.up) s.since = now_;
    s.up = false;
    if (s.hello) s.hello->went_down();
    s.error = std::move(why);
    gpio_->link_state(link.id(), false);
}

LinkId Gateway::link_named(const std::string& name) const {
    for (const LinkState& s : links_)
        if (s.link->name() == name) return s.link->id();
    throw std::logic_error("no link is called " + name);    // the configuration was checked for it
}

void Gateway::log_conflict() {
    Router::Claimant claims;
    while (router_.take_claimant(claims)) {
        const Channel& channel = *channels_[index(claims.channel)];
        claimants_[claims.address] = {channel.link, channel.peer};
    }
    Conflict conflict;
    while (router_.take_new_conflict(conflict)) {
        std::string names, who;
        for (const LinkId id : conflict.links) names += (names.empty() ? "" : " and ") + links_[index(id)].link->name();
        if (const Claimant* by = claimant(conflict))
            who = ", claimed by " + links_[index(by->link)].link->name() + (by->peer.empty() ? "" : " (" + by->peer + ")");
        spdlog::warn(
            "0x{:02X} is heard on {}{}: the same device? give the links one `group`; two devices? give one of them another "
            "id; neither? pin it: --route 0x{:02X}=LINK",
            conflict.address, names, who, conflict.address);
    }
}

bool Gateway::nothing_waits() const {
    for (const ChannelId id : used_)
        if (!channels_[index(id)]->outbox.empty()) return false;
    for (const LinkState& s : links_)
        if (s.up && s.link->unsent() > 0) return false;
    return true;
}

void Gateway::finish_stop() {
    stop_check_.cancel();
    beat_.cancel();
    peer_log_.finish();
    standstill_log_.finish();
    for (LinkState& s : links_) s.link->stop();
    release_.cancel();
    gpio_->stop();
    if (on_stopped_) std::exchange(on_stopped_, [] {})();
}

}    // namespace anogate
