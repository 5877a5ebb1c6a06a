#include <link/v7_edge.hpp>

#include <config/link_kind.hpp>
#include <gateway/v7_host_translation.hpp>

#include <algorithm>
#include <cstring>
#include <iterator>
#include <random>
#include <utility>

namespace anogate {
namespace {

ano::v7::FrameParser::Options parser_options(const LinkSettings& link) {
    return {std::min<std::size_t>(link.max_data, ano::v7::max_len), link.frame_gap.value_or(quiet_of(*link.kind))};
}

std::unique_ptr<V7LinkTranslation> translation_for(const V7LinkSettings& v7, const LinkSettings& link,
                                                   const LinkContext& context) {
    V7Settings settings = v7.translation();
    settings.port_id = link.id;
    settings.line = std::random_device{}();
    settings.lines = &context.v7_lines;
    if (v7.role == V7Role::host) return std::make_unique<V7HostTranslation>(std::move(settings));
    return std::make_unique<V7Translation>(std::move(settings));
}

}    // namespace

V7Edge::V7Edge(const V7LinkSettings& v7, const LinkSettings& link, const LinkContext& context, Calls calls)
    : context_{context},
      calls_{std::move(calls)},
      translation_{translation_for(v7, link, context)},
      parser_{parser_options(link)},
      alarm_{context.alarms, [this] { ring(); }} {}

void V7Edge::to_device(ano::v7::FrameView frame) { unsent_.insert(unsent_.end(), frame.bytes().begin(), frame.bytes().end()); }

void V7Edge::from_device(ano::FrameView frame) {
    received_.insert(received_.end(), frame.bytes().begin(), frame.bytes().end());
    received_.insert(received_.end(), raw_.begin(), raw_.end());
}

void V7Edge::translate_received() {
    const TimePoint now = context_.host.now();
    while (const auto frame = parser_.next()) {
        raw_ = frame->bytes();
        translation_->up(*frame, now, *this);
    }
    raw_ = {};
    if (translation_->dropped() != noted_drops_) note_drops(now);
}

void V7Edge::note_drops(TimePoint now) {
    const V7Counters& is = translation_->counters();
    if (is.up_echo != noted_.up_echo) channel_->v7.echo = now;
    if (is.up_loop != noted_.up_loop) channel_->v7.loop = now;
    if (is.up_command != noted_.up_command) channel_->v7.command = now;
    noted_ = is;
    noted_drops_ = translation_->dropped();
}

// The gateway may send on this link meanwhile, which fills received_ again.
void V7Edge::pass_on() {
    const ano::v7::ParserCounters& c = parser_.counters();
    ReceiveCounters& counters = channel_->beside;
    counters.frames_in = c.frames_in;
    counters.bytes_in = c.bytes_in;
    counters.bad_check = c.bad_check;
    counters.bad_length = c.bad_length;
    counters.skipped_bytes = c.skipped_bytes;
    counters.expired = c.expired;
    passed_on_.swap(received_);
    for (std::span<const std::uint8_t> rest{passed_on_}; !rest.empty();) {
        const ano::FrameView frame = *ano::frame_at(rest);
        rest = rest.subspan(frame.bytes().size());
        if (!rest.empty() && rest[0] == ano::v7::head) channel_->raw = rest.first(ano::v7::overhead + rest[3]);
        rest = rest.subspan(channel_->raw.size());
        if (calls_.receive) calls_.receive(frame);
        else context_.host.receive(*channel_, frame);
        channel_->raw = {};
    }
    passed_on_.clear();
}

void V7Edge::deliver() {
    translate_received();
    pass_on();
    set_alarm();
}

void V7Edge::receive_datagram(std::span<const std::uint8_t> datagram, TimePoint now) {
    parser_.begin_datagram(datagram, now);
    translate_received();
    while (!datagram.empty()) {
        const auto room = parser_.prepare();
        const std::size_t n = std::min(room.size(), datagram.size());
        std::memcpy(room.data(), datagram.data(), n);
        parser_.commit(n, now);
        datagram = datagram.subspan(n);
        translate_received();
    }
    pass_on();
    set_alarm();
}

void V7Edge::end_of_input() {
    parser_.finish();
    translate_received();
    pass_on();
    reset();
}

void V7Edge::reset() noexcept {
    alarm_.cancel();
    parser_.finish();
    while (parser_.next()) {}
    translation_->reset();
    unsent_.clear();
    received_.clear();
}

void V7Edge::take(Outbox& outbox, ano::FrameView frame, TimePoint now) {
    const std::uint64_t before = translation_->dropped();
    const std::size_t unsent = unsent_.size();
    translation_->down(frame, now, *this);
    channel_->raw = std::span{unsent_}.subspan(unsent);
    if (translation_->dropped() == before) outbox.sent_frame();
    else drop(outbox);
    channel_->raw = {};
    set_alarm();
}

// A request that finds no place may be sent later; all other causes are for good.
void V7Edge::drop(Outbox& outbox) {
    const auto cause = translation_->last_drop();
    const auto is_it = [cause](const V7CounterRow& row) { return row.value == cause; };
    if (cause == &V7Counters::down_queue_full) return outbox.drop_frame(&SendCounters::queue_full);
    std::string_view why = std::find_if(std::begin(v7_counters), std::end(v7_counters), is_it)->help;
    if (const std::size_t direction = why.find(": "); direction != why.npos) why.remove_prefix(direction + 2);
    channel_->v7.refusal = why;
    outbox.drop_frame(&SendCounters::denied_out);
    channel_->v7.refusal = {};
}

std::span<const std::uint8_t> V7Edge::first_unsent() const noexcept {
    return unsent_.empty() ? std::span<const std::uint8_t>{} : std::span{unsent_}.first(ano::v7::overhead + unsent_[3]);
}

void V7Edge::set_alarm() {
    if (!received_.empty()) return alarm_.set(context_.host.now());
    const auto parser = parser_.deadline(), translation = translation_->deadline();
    if (parser && translation) alarm_.set(std::min(*parser, *translation));
    else if (parser || translation) alarm_.set(parser ? *parser : *translation);
    else alarm_.cancel();
}

void V7Edge::ring() {
    const TimePoint now = context_.host.now();
    channel_->arrived_at = now;
    parser_.expire(now);
    translate_received();
    if (const auto due = translation_->deadline(); due && *due <= now) translation_->expire(now, *this);
    pass_on();
    set_alarm();
    context_.host.flush();
    calls_.write();
}

void add_v7_facts(LinkFacts& facts, const V7Counters& counters) {
    facts.push_back({"protocol", "v7"});
    for (const V7CounterRow& row : v7_counters) facts.push_back({row.name, static_cast<std::int64_t>(counters.*row.value)});
}

}    // namespace anogate
