// Changes the settings of the running gateway: adds and removes links, and keeps everything else.
#include <config/config.hpp>
#include <config/link_kind.hpp>
#include <runtime/control_link.hpp>
#include <runtime/gateway.hpp>
#include <sys/asio.hpp>

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

namespace anogate {
namespace {

constexpr Duration change_look = std::chrono::milliseconds{10};

bool ends(Change change) { return change == Change::changed || change == Change::removed; }
bool begins(Change change) { return change == Change::changed || change == Change::added; }

// Whether both links use the same port, and therefore have the same devices.
bool have_one_port(const LinkSettings& a, const LinkSettings& b) {
    if (a.kind != b.kind) return false;
    return a.kind->path ? a.kind->path(a).path == a.kind->path(b).path : a.of_kind == b.of_kind;
}

}    // namespace

void Gateway::change(Settings settings, Difference difference, Duration patience, std::function<void()> on_changed) {
    if (on_stopped_) return;
    changing_ = Changing{std::move(settings), std::move(difference), std::move(on_changed), now() + patience};
    bool any_closes = false;
    for (LinkState& s : links_) {
        if (!goes(s)) continue;
        s.link->stop_reading();
        any_closes = true;
    }
    flush();
    if (any_closes) change_check_.set(now_ + change_look);    // the kernel's counters show written bytes only a moment later
    else finish_change();
}

bool Gateway::goes(const LinkState& state) const { return ends(changing_->difference.of(state.link->name())); }

void Gateway::check_change() {
    const bool all_left = std::all_of(links_.begin(), links_.end(),
                                      [this](const LinkState& s) { return !goes(s) || nothing_waits(s); });
    if (all_left || now() >= changing_->by) finish_change();
    else change_check_.set(now_ + change_look);
}

void Gateway::finish_change() {
    now();
    unpin_routes();
    Retired retired;
    remove_links(retired);
    Changing change = *std::exchange(changing_, std::nullopt);
    const Settings before = std::exchange(settings_, std::move(change.settings));
    layouts_.settings_changed(before.flexible, replayed());
    forwarder_.set(settings_.gateway);
    forwarder_.set_classes(settings_.classes);
    make_room_for_links(retired);
    LinkSet fresh;
    add_links(change.difference, fresh);
    restore_homes(retired.homes, fresh);
    if (control_) control_->release_ports(settings_.gateway.id);
    sort_links();
    pin_routes();
    retired.lines = gpio_->change(
        settings_.gpio, [this](const std::string& name) -> Link& { return link_named(name); }, fresh);
    start_links(fresh);
    retire(std::move(retired));
    change.on_changed();
}

std::vector<DecodingPtr> Gateway::replayed() const {
    std::vector<DecodingPtr> all;
    for (const LinkState& s : links_)
        if (const PlayedRecording* played = s.up ? s.link->as<PlayedRecording>() : nullptr)
            if (DecodingPtr decoding = played->decoding()) all.push_back(std::move(decoding));
    return all;
}

void Gateway::unpin_routes() {
    for (const RouteSettings& route : settings_.routes) forwarder_.unpin(route.first, route.last, link_named(route.link).id());
}

void Gateway::remove_links(Retired& retired) {
    for (LinkState& s : links_)
        if (goes(s)) remove(s, retired);
    std::erase_if(links_, [](const LinkState& s) { return !s.link; });
}

void Gateway::remove(LinkState& state, Retired& retired) {
    const LinkId id = state.link->id();
    if (state.up) gpio_->link_state(id, false);
    lose_channels_of(id);
    if (state.link.get() == tunnel_) tunnel_ = nullptr;
    if (state.link.get() == control_) control_ = nullptr;
    state.link->stop();
    retired.homes.push_back({state.link->settings(), forwarder_.router().last_homes(id)});
    forwarder_.remove_link(id);
    links_by_id_[index(id)] = nullptr;
    streams_.erase(id);
    retired.links.push_back(std::move(state.link));
}

// A frame that acts on a device is sent to the link where that device was last heard, even if the link was recreated: with the
// same port, or else with the same name.
void Gateway::restore_homes(const std::vector<LastHomes>& homes, LinkSet fresh) {
    for (const LastHomes& was : homes) {
        const Link* heir = nullptr;
        for (const LinkId id : fresh) {
            const LinkSettings& link = links_by_id_[index(id)]->settings();
            const bool has_port = have_one_port(link, was.link);
            if (has_port || (!heir && link.name == was.link.name)) heir = links_by_id_[index(id)];
            if (has_port) break;
        }
        if (heir) forwarder_.restore_last_homes(was.addresses, heir->id());
    }
}

// The link `control`, which is not configured, is closed to make room: its programs get a message to connect again.
void Gateway::make_room_for_links(Retired& retired) {
    const std::size_t wanted = settings_.links.size() + (settings_.tunnel ? 1 : 0);
    if (!control_ || is_control_configured(settings_) || wanted < max_links) return;
    remove(state(*control_), retired);
    former_controls_.push_back(std::move(retired.links.back()));
    retired.links.pop_back();
    std::erase_if(links_, [](const LinkState& s) { return !s.link; });
}

void Gateway::add_links(const Difference& difference, LinkSet& fresh) {
    for (const LinkSettings& link : settings_.links)
        if (begins(difference.of(link.name))) fresh.insert(add_link(link));
    if (is_control_configured(settings_) && !control_) fresh.insert(add_control());
    if (!settings_.tunnel) return;
    if (tunnel_) connect_tunnel();
    else fresh.insert(add_tunnel());
}

// In the order of the configuration, followed by links that are not configured.
void Gateway::sort_links() {
    const auto place = [this](const LinkState& s) {
        const auto& links = settings_.links;
        return std::find_if(links.begin(), links.end(), [&](const LinkSettings& l) { return l.name == s.link->name(); });
    };
    std::stable_sort(links_.begin(), links_.end(), [&](const LinkState& a, const LinkState& b) { return place(a) < place(b); });
}

void Gateway::start_links(LinkSet fresh) {
    for (LinkState& s : links_)
        if (fresh.contains(s.link->id())) s.since = now_;
    for (LinkState& s : links_) gpio_->link_state(s.link->id(), s.up);    // for new lamps
    for (LinkState& s : links_)
        if (fresh.contains(s.link->id())) start(s);
    flush();
    beat();    // opening the links may take long
}

// The loop calls the queued callbacks of the closed objects before the one that is queued here.
void Gateway::retire(Retired retired) {
    retired_.push_back(std::move(retired));
    asio::post(io_, [this, alive = std::weak_ptr<bool>{is_alive_}] {
        if (!alive.expired()) retired_.pop_front();
    });
}

void Gateway::forget_peer(const Channel& channel) {
    if (PeerPlaces* const places = links_by_id_[index(channel.link)]->as<PeerPlaces>()) places->forget_peer(channel.id);
}

void Gateway::make_channel_free(PeerBook::Rank to) {
    if (forwarder_.channels().size() < max_channels) return;
    const Channel* silent = nullptr;
    for (const LinkState& s : links_) {
        const PeerPlaces* const places = s.link->as<PeerPlaces>();
        const auto id = places ? places->peer_to_replace(to, now_) : std::nullopt;
        if (id && (!silent || forwarder_.channel(*id).heard_at < silent->heard_at)) silent = &forwarder_.channel(*id);
    }
    if (silent) forget_peer(*silent);
}

// For a link that has only one channel. If all peers are trusted or have sent commands, the longest silent one of them makes room.
void Gateway::make_channel_free_for_link() {
    make_channel_free(PeerBook::Rank::trusted);
    if (forwarder_.channels().size() < max_channels) return;
    const Channel* silent = nullptr;
    for (const ChannelId id : forwarder_.channels()) {
        const bool is_peer = links_by_id_[index(forwarder_.channel(id).link)]->settings().kind->listens;
        if (is_peer && (!silent || forwarder_.channel(id).heard_at < silent->heard_at)) silent = &forwarder_.channel(id);
    }
    if (silent) forget_peer(*silent);
}

}    // namespace anogate
