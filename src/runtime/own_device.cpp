#include <gateway/counters.hpp>
#include <gpio/gpio.hpp>
#include <log/log_line.hpp>
#include <runtime/link_report.hpp>
#include <runtime/own_device.hpp>
#include <runtime/reload.hpp>
#include <sys/asio.hpp>
#include <sys/files/write_atomically.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

using LogColor = GatewayDevice::LogColor;

// A Link contains the channel in its lower bits and a unique number above them: see link_of().
constexpr GatewayDevice::Link channel_bits = 6;
constexpr GatewayDevice::Link link_of_ourselves = ano::device::every_link - 1;

constexpr std::size_t max_waiting_saves = 8;

}    // namespace

OwnDevice::OwnDevice(Gateway& gateway, Reload& reload, std::string kept_path, WrittenValues kept)
    : gateway_{gateway},
      reload_{reload},
      kept_path_{std::move(kept_path)},
      kept_{std::move(kept)},
      alarm_{gateway.alarms(),
             [this] {
                 device_.run(gateway_.now());
                 gateway_.flush();
                 await();
             }},
      background_task_{gateway.io()} {
    gateway_.parts().enter(*this);
    reload_.on_settled([this] {    // not while it processes a request
        asio::post(gateway_.io(), [this, alive = std::weak_ptr<bool>{is_alive_}] {
            if (alive.expired()) return;
            configure();
            keep_in_step();
        });
    });
    configure();
}

OwnDevice::~OwnDevice() {
    gateway_.parts().leave(*this);
    stopping();
}

void OwnDevice::stopping() {
    is_alive_.reset();
    reload_.on_settled({});
    take_frames(false);
    alarm_.cancel();
    saves_.clear();
    background_task_.stop();
}

void OwnDevice::take_frames(bool wants) {
    OwnFrames* const own = wants ? this : nullptr;
    gateway_.parts().own = own;
    gateway_.forwarder().set_own(own);
}

void OwnDevice::configure() {
    device_.configure(reload_.of_files(), reload_.written());
    take_frames(device_.is_there());
    await();
}

// The number of a closed channel is reused for another peer, which must not receive the answers for the old one.
OwnDevice::Link OwnDevice::link_of(const Channel& channel) {
    if (channel.id == ourselves) return link_of_ourselves;
    Place& place = places_[index(channel.id)];
    if (place.link == 0 || place.opened_at != channel.opened_at) {
        if (place.link != 0) device_.forget(place.link);
        place = {channel.opened_at, ++places_used_ << channel_bits | static_cast<Link>(index(channel.id))};
    }
    return place.link;
}

const Channel* OwnDevice::channel_of(Link link) const {
    const auto id = static_cast<ChannelId>(link & (max_channels - 1));
    const Place& place = places_[index(id)];
    if (place.link != link || !gateway_.forwarder().channels().contains(id)) return nullptr;
    const Channel& channel = gateway_.forwarder().channel(id);
    return channel.opened_at == place.opened_at ? &channel : nullptr;
}

void OwnDevice::take(const Channel& from, ano::FrameView frame, TimePoint now) {
    if (!GatewayDevice::concerns(frame.id())) return;
    const bool is_ours = from.id == ourselves;
    const bool may_manage = is_ours ? gateway_.settings().control.manage : gateway_.link(from.link).settings().manage;
    device_.take(frame, {link_of(from), is_ours ? "control" : gateway_.link(from.link).name(), may_manage, is_ours}, now);
    await();
}

void OwnDevice::send_waiting() {
    while (const auto out = device_.next()) {
        if (out->link == ano::device::every_link) gateway_.forwarder().send_to_active_channels(out->frame, gateway_.now());
        else if (out->link == link_of_ourselves) answer_ourselves(out->frame);
        else if (const Channel* channel = channel_of(out->link))
            gateway_.forwarder().answer(channel->id, out->frame, gateway_.now());
        else device_.forget(out->link);
    }
}

// The caller is still sending its request, so the answer is delivered in the next turn of the loop.
void OwnDevice::answer_ourselves(ano::FrameView frame) {
    asio::post(gateway_.io(), [this, alive = std::weak_ptr<bool>{is_alive_},
                               bytes = std::vector<std::uint8_t>{frame.bytes().begin(), frame.bytes().end()}] {
        if (!alive.expired()) gateway_.parts().tell(&GatewayEvents::own_answer, ano::FrameView{bytes});
    });
}

void OwnDevice::await() {
    if (const auto due = device_.due()) alarm_.set_no_later(*due);
}

void OwnDevice::send_log(const std::string& line, LogColor color) {
    if (!is_alive_ || !device_.is_there()) return;
    device_.log(line, color, gateway_.time());
    alarm_.set_no_later(gateway_.time());
}

void OwnDevice::link_changed(const LinkState& link) {
    if (link.up) send_log(link.link->name() + ": up", LogColor::green);
    else send_log(link.link->name() + ": " + link.error.text, LogColor::red);
}

void OwnDevice::conflict_began(const std::string& what) { send_log(what, LogColor::red); }

void OwnDevice::apply(const WrittenValues& written) { reload_.write(written); }

std::string OwnDevice::save(const WrittenValues& written) {
    if (kept_path_.empty()) return "no configuration file or folder to save them in";
    if (saves_.size() >= max_waiting_saves) return "other saves are still waiting for the disk";
    saves_.push_back({written, true});
    if (saves_.size() == 1) next_save();
    return {};
}

// Does nothing while the file is waiting for confirmation.
void OwnDevice::keep_in_step() {
    WrittenValues still = kept_;
    if (gateway_.config_state().runs != ConfigState::Runs::file || !saves_.empty() ||
        still.forget_stale(reload_.of_files()).empty())
        return;
    saves_.push_back({std::move(still), false});
    next_save();
}

void OwnDevice::next_save() {
    const auto fault = std::make_shared<std::string>();
    const auto write = [path = kept_path_, text = saves_.front().values.text(), fault] {
        *fault = write_atomically(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
    };
    const auto done = [this, fault](const std::string& thrown) {
        const std::string why = thrown.empty() ? *fault : thrown;
        const Save save = std::move(saves_.front());
        saves_.pop_front();
        if (why.empty()) kept_ = save.values;
        if (save.is_asked_for) device_.saved(why, gateway_.now());
        else if (!why.empty()) log_warning("stored parameters that the configuration overrides could not be removed: {}", why);
        gateway_.flush();
        if (!saves_.empty()) next_save();
    };
    if (background_task_.run(write, done)) return;
    asio::post(gateway_.io(), [done, alive = std::weak_ptr<bool>{is_alive_}, why = background_task_.why_not()] {
        if (!alive.expired()) done(std::string{why});
    });
}

// Refuses while a configuration is waiting for confirmation: a reload without a confirmation time would confirm it.
std::string OwnDevice::reload() {
    if (gateway_.config_state().runs == ConfigState::Runs::unconfirmed)
        return "a reloaded configuration is still waiting for confirmation";
    if (std::exchange(reloads_, true)) return "a reload is in progress";
    reload_.reload({}, [this, alive = std::weak_ptr<bool>{is_alive_}](const ReloadOutcome& outcome) {
        if (alive.expired()) return;
        reloads_ = false;
        send_log(outcome);
    });
    return {};
}

void OwnDevice::send_log(const ReloadOutcome& outcome) {
    if (!outcome.refusal.empty()) return send_log("reload: nothing was changed: " + outcome.refusal, LogColor::red);
    if (!outcome.faults.empty())
        return send_log("reload: nothing was changed: " + line_of(outcome.faults.front()), LogColor::red);
    std::string changed;
    for (const LinkDifference& link : outcome.difference.links)
        if (link.change != Change::same) changed += " " + link.name + " " + std::string{text(link.change)};
    send_log("reload:" + (changed.empty() ? " no link changed" : changed), LogColor::green);
}

std::string OwnDevice::restart(const std::string& link) {
    for (const LinkSettings& settings : gateway_.settings().links) {
        if (settings.name != link) continue;
        if (!settings.enabled) return link + " is disabled";
        reload_.restart(link);
        return {};
    }
    return "there is no link " + link + " any more";
}

std::string OwnDevice::scan() {
    ScanService* const service = gateway_.parts().scan;
    return service ? service->scan([this](const std::string& line) { send_log(line, LogColor::standard); })
                   : "requests to devices are not available here";
}

std::string OwnDevice::pulse(std::size_t number) {
    std::size_t n = 0;
    for (const auto& line : gateway_.gpio().lines()) {
        const GpioUse use = line->settings().use;
        if ((use != GpioUse::reset && use != GpioUse::power) || n++ != number) continue;
        const auto refusal = gateway_.gpio().act(*line, gateway_.now());
        return refusal ? refusal->why : std::string{};
    }
    return "there is no line " + std::to_string(number);
}

std::string OwnDevice::start_recording() {
    RecordingService* const service = gateway_.parts().recording;
    return service ? service->start_recording() : "recording is not available here";
}

std::string OwnDevice::stop_recording() {
    RecordingService* const service = gateway_.parts().recording;
    return service ? service->stop_recording() : "recording is not available here";
}

std::vector<LinkSummary> OwnDevice::summaries() {
    std::vector<LinkSummary> all;
    for (const LinkSettings& settings : gateway_.settings().links)
        for (const LinkState& state : gateway_.links()) {
            if (state.link->name() != settings.name) continue;
            const LinkFigures figures = report_of(gateway_, state, gateway_.time()).figures;
            const auto is = state.up           ? LinkSummary::State::up
                            : settings.enabled ? LinkSummary::State::waiting
                                               : LinkSummary::State::disabled;
            all.push_back(
                {is, figures.received.frames_in, figures.sent.frames_out, losses(figures.received) + losses(figures.sent)});
        }
    return all;
}

void OwnDevice::warn(const std::string& line) { log_warning("{}", line); }

void OwnDevice::describe_gateway(nlohmann::ordered_json& gateway) const {
    if (!device_.is_there()) return;
    nlohmann::ordered_json parameters = nlohmann::ordered_json::array();
    for (const ManagedValue& value : device_.values())
        parameters.push_back(
            {{"name", value.row->name}, {"key", value.row->key}, {"value", value.value}, {"from", text(value.from)}});
    const GatewayDeviceCounters counters = device_.counters();
    gateway["device"] = {{"answered", counters.answered},
                         {"unanswered", counters.unanswered},
                         {"not_managed", counters.not_managed},
                         {"would_lock_out", counters.would_lock_out},
                         {"refused", counters.refused},
                         {"to_everybody", counters.to_everybody},
                         {"lines_left_out", counters.lines_left_out},
                         {"parameters", std::move(parameters)}};
}

}    // namespace anogate
