#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/feed.hpp>
#include <link/make_link.hpp>
#include <link/sim_link.hpp>
#include <link/sim_settings.hpp>
#include <world/kinds.hpp>

#include <array>
#include <utility>

namespace anogate {
namespace {

constexpr ano::Duration busy_for = std::chrono::milliseconds{5};    // with one request, if only one_at_a_time is set

// Simulated devices share their wake-ups.
ano::TimePoint begin_of_step(ano::TimePoint now) {
    return ano::TimePoint{now.time_since_epoch() / ano::world::SimulatedDevice::step * ano::world::SimulatedDevice::step};
}

ano::world::Faults faults_of(const SimSettings& sim) {
    const ano::Duration none{};
    return {.loss = sim.loss.value_or(std::uint8_t{0}),
            .duplicate = sim.duplicate.value_or(std::uint8_t{0}),
            .corrupt = sim.corrupt.value_or(std::uint8_t{0}),
            .delay = sim.delay.value_or(none),
            .jitter = sim.jitter.value_or(none),
            .deaf_after = sim.deaf_after,
            .restart_after = sim.restart_after,
            .slow = sim.slow.value_or(sim.one_at_a_time ? busy_for : none),
            .one_at_a_time = sim.one_at_a_time,
            .vendor_parser = sim.parser == SimParser::vendor};
}

// The translation has the table of parameters that the device knows by number.
V7LinkSettings translation_of(const ano::world::SimulatedDevice& device) {
    V7LinkSettings v7;
    v7.protocol = LinkProtocol::v7;
    v7.device = device.id();
    v7.params = "lx";
    return v7;
}

}    // namespace

SimLink::SimLink(LinkId id, LinkSettings settings, const LinkContext& context)
    : Link{id, std::move(settings)},
      context_{context},
      send_{[this](ano::Bytes bytes, ano::TimePoint) { receive(bytes); }},
      send_later_{[this](ano::Bytes bytes, ano::TimePoint) { answers_.insert(answers_.end(), bytes.begin(), bytes.end()); }},
      tick_{context.alarms, [this] { tick(); }},
      answer_{context.alarms, [this] { answer(); }} {}

void SimLink::start() {
    const SimSettings& sim = settings().as<SimSettings>();
    const ano::world::Settings world{.id = sim.dev_id,
                                     .hz = sim.hz,
                                     .seed = sim.seed,
                                     .parameters = sim.parameters,
                                     .texts = sim.texts,
                                     .firmware = sim.firmware,
                                     .any_address = sim.any_address,
                                     .euler = sim.euler};
    const ano::TimePoint begin = begin_of_step(context_.host.now());
    line_ = std::make_unique<ano::world::FaultyLine>(ano::world::make_device(sim.device, world, begin), faults_of(sim), sim.seed,
                                                     begin);
    channel_ = context_.host.open_channel(*this, sim.device);
    if (line_->device().uses_v7()) {
        v7_ = std::make_unique<V7Edge>(translation_of(line_->device()), settings(), context_,
                                       V7Edge::Calls{[this] { write_v7(); }});
        v7_->begin(*channel_);
    }
    context_.host.link_up(*this);
    tick();
}

void SimLink::stop() {
    if (v7_) v7_->pause();
    tick_.cancel();
    answer_.cancel();
}

void SimLink::tick() {
    line_->run(context_.host.now(), send_);
    context_.host.flush();
    if (v7_) write_v7();
    tick_.set(line_->due());
}

// The bytes of the device are parsed and counted as those of any other link.
void SimLink::receive(std::span<const std::uint8_t> received) {
    channel_->arrived_at = context_.host.now();
    if (tap_) [[unlikely]]
        tap_->received(received);
    if (v7_) return v7_->receive_datagram(received, channel_->arrived_at);
    feed_datagram(channel_->parser, received, channel_->arrived_at,
                  [this](ano::FrameView frame) { context_.host.receive(*channel_, frame); });
}

// The device receives the frame at once. Its answers are sent in a later turn, so that two devices can't call each other
// endlessly.
void SimLink::flush(Channel& channel) {
    std::array<std::span<const std::uint8_t>, 1> next;
    while (channel.outbox.gather(next, context_.host.now()) == 1) {
        if (channel.outbox.zeros() == 0 && v7_) {
            v7_->take(channel.outbox, ano::FrameView{next[0]}, context_.host.now());
            write_v7();
            continue;
        }
        send_to_device(next[0]);
        if (channel.outbox.zeros() > 0) channel.outbox.sent(next[0].size());
        else channel.outbox.sent_frame();
    }
    set_alarms();
}

void SimLink::send_to_device(std::span<const std::uint8_t> bytes) {
    if (tap_) [[unlikely]]
        tap_->sent(bytes);
    line_->take(ano::Bytes{bytes}, context_.host.now(), send_later_);
}

void SimLink::set_alarms() {
    if (!answers_.empty()) answer_.set(context_.host.now());
    if (tick_.is_set()) tick_.set(line_->due());    // an answer may be due later
}

bool SimLink::write_raw(std::span<const std::uint8_t> bytes) {
    if (!tick_.is_set()) return false;
    send_to_device(bytes);
    set_alarms();
    return true;
}

void SimLink::write_v7() {
    while (!v7_->unsent().empty()) {
        const auto next = v7_->first_unsent();
        const std::vector<std::uint8_t> frame{next.begin(), next.end()};
        v7_->written(frame.size());
        send_to_device(frame);
    }
    set_alarms();
}

void SimLink::answer() {
    const auto answers = std::exchange(answers_, {});    // sending them may cause new answers
    if (!tick_.is_set()) return;                         // stopped meanwhile
    receive(answers);
    context_.host.flush();
    if (v7_) write_v7();
}

// The counts of simulated faults, if any are configured.
LinkFacts SimLink::facts() const {
    LinkFacts facts;
    if (v7_) add_v7_facts(facts, v7_->counters());
    if (!line_ || faults_of(settings().as<SimSettings>()).is_none()) return facts;
    const auto& n = line_->counters();
    const auto number = [](std::uint64_t count) { return static_cast<std::int64_t>(count); };
    facts.insert(facts.end(), {{"faults_lost", number(n.lost)},
                               {"faults_duplicated", number(n.doubled)},
                               {"faults_corrupted", number(n.damaged)},
                               {"faults_unheard", number(n.unheard)}});
    return facts;
}

namespace {

using namespace key_rows;

constexpr std::uint64_t max_late = 10 * second;

constexpr Key<LinkSettings> sim_keys[] = {
    choice<own<SimSettings>, &SimSettings::device>("device", ano::world::kinds, "the device to simulate") | needed,
    integer<own<SimSettings>, &SimSettings::hz>("hz", 1, 100, "attitude frames per second; slower frames scale with it"),
    address<own<SimSettings>, &SimSettings::dev_id>("dev_id", 1, 253, "the hardware id of the device (default: the usual one)"),
    boolean<own<SimSettings>, &SimSettings::any_address>(
        "any_address", "act on and answer frames for every address, like the oldest devices (default: no)"),
    integer<own<SimSettings>, &SimSettings::seed>("seed", 0, UINT32_MAX,
                                                  "random seed; the same seed gives the same noise, weather and faults"),
    choice<own<SimSettings>, &SimSettings::parameters>(
        "parameters", "typed|minmax|scaled", "how it describes its parameters; minmax and scaled are those of older devices"),
    choice<own<SimSettings>, &SimSettings::texts>(
        "texts", "en|utf8|gbk", "language and encoding of its names and texts: English, or Chinese in UTF-8 or GBK"),
    choice<own<SimSettings>, &SimSettings::firmware>("firmware", "little|reading",
                                                     "the byte order of the codes in a firmware upgrade"),
    choice<own<SimSettings>, &SimSettings::euler>(
        "euler", "document|lx", "the signs of its Euler angles; lx: pitch and yaw have the opposite sign of its quaternion"),
    integer<own<SimSettings>, &SimSettings::loss>("loss", 1, 100,
                                                  "percentage of frames lost, in both directions (default: none)"),
    duration<own<SimSettings>, &SimSettings::delay>("delay", 1, max_late, "delay of each frame, in both directions (default: 0)"),
    duration<own<SimSettings>, &SimSettings::jitter>(
        "jitter", 1, max_late, "random additional delay, so that frames may overtake each other (default: 0)"),
    integer<own<SimSettings>, &SimSettings::duplicate>("duplicate", 1, 100,
                                                       "percentage of frames duplicated, in both directions (default: none)"),
    integer<own<SimSettings>, &SimSettings::corrupt>("corrupt", 1, 100,
                                                     "percentage of frames with a wrong bit, in both directions (default: none)"),
    duration<own<SimSettings>, &SimSettings::deaf_after>("deaf_after", 1, day,
                                                         "the device stops receiving after this time (default: never)"),
    duration<own<SimSettings>, &SimSettings::restart_after>(
        "restart_after", 1, day, "the device restarts after this time, with its stored values (default: never)"),
    duration<own<SimSettings>, &SimSettings::slow>(
        "slow", 1, max_late, "processing time of the device for each frame; up to 20 frames wait (default: 0)"),
    boolean<own<SimSettings>, &SimSettings::one_at_a_time>(
        "one_at_a_time", "frames don't wait: those received while the device is busy (slow, or 5ms) are lost"),
    choice<own<SimSettings>, &SimSettings::parser>(
        "parser", "search|vendor",
        "how the device parses frames; vendor: after a corrupted LEN it misses up to 198 "
        "bytes, like many real devices"),
};

}    // namespace

extern const LinkKind sim_kind;    // listed in kinds.cpp
constinit const LinkKind sim_kind{
    .name = "sim",
    .address = "device",
    .example = "fc",
    .help = "a simulated device inside the process, such as a flying flight controller (0xDC): demo, tests, development",
    .carries = Carries::pieces,
    .devices_only = true,
    .keys = sim_keys,
    .settings = [] { return KindSettings{SimSettings{}}; },
    .make = make_link_of<SimLink>,
    .usual_name = [](const LinkSettings& link) { return link.as<SimSettings>().device; },
    .has_uart = [](const LinkSettings& link) { return link.as<SimSettings>().parser == SimParser::vendor; },
};

}    // namespace anogate
