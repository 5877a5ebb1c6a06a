#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano/typed.hpp>
#include <config/link_kind.hpp>
#include <config/wire.hpp>
#include <devices/alarm_limits.hpp>
#include <devices/unit_note.hpp>
#include <devices/works/calibration_work.hpp>
#include <devices/works/scan_work.hpp>
#include <gateway/hints.hpp>
#include <http/socket_path.hpp>
#include <log/log_line.hpp>
#include <managed/managed_parameters.hpp>
#include <runtime/control_link.hpp>
#include <runtime/gateway.hpp>
#include <runtime/gateway_devices.hpp>
#include <runtime/known_origin.hpp>
#include <runtime/route_rows.hpp>
#include <sys/files/state_folder.hpp>
#include <sys/files/write_atomically.hpp>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t max_note = 64 * 1024;
constexpr std::string_view unfinished = ".new";    // write_atomically()

ano::Encoding encoding_of(TextEncoding encoding) {
    return encoding == TextEncoding::gbk ? ano::Encoding::gbk : ano::Encoding::utf8;
}

// Whether `name` is a file of keep() for devices: a note, or alarm limits.
bool is_kept_name(std::string_view name) { return is_note(name) || address_of_limits_file(name); }

// Whether it is an unfinished state file, also of another configuration. One younger than a minute may be that of another gateway,
// which is writing it now.
bool is_abandoned(const std::filesystem::path& file, std::string_view name) {
    constexpr std::string_view states[] = {"flexible-", "parameters-", "unconfirmed-"};    // kept_path()
    if (std::none_of(std::begin(states), std::end(states), [&](std::string_view state) { return name.starts_with(state); }))
        return false;
    std::error_code ec;
    const auto written_at = std::filesystem::last_write_time(file, ec);
    return !ec && std::filesystem::file_time_type::clock::now() - written_at > std::chrono::minutes{1};
}

// The host of a peer in a network, without the port, which changes when a program restarts.
std::string_view host_of(const Channel& channel) { return std::string_view{channel.peer}.substr(0, channel.peer.rfind(':')); }
std::string group_of(const Gateway& gateway, const Channel& channel) {
    const bool has_group = gateway.forwarder().router().group_of(channel.id) != 0;
    return has_group ? gateway.link(channel.link).settings().group : std::string{};
}
std::string format_place(const std::string& link, std::string_view peer) {
    return peer.empty() ? link : link + " (" + std::string{peer} + ")";
}

// Whether a repeated request would fail as well, unlike after a short loss of the link.
bool is_for_good(ReceiveCause cause) { return cause == &ReceiveCounters::denied_in || cause == &ReceiveCounters::inhibited; }
bool is_for_good(SendCause cause) { return cause == &SendCounters::denied_out || cause == &SendCounters::too_big; }

}    // namespace

GatewayDevices::GatewayDevices(Gateway& gateway)
    : gateway_{gateway},
      alarm_{gateway.alarms(),
             [this] {
                 report_lost();
                 service_.run(gateway_.now());
             }},
      background_task_{gateway.io()},
      service_{*this, gateway.settings().control.host},
      always_{*this} {
    lost_.reserve(max_lost);
    gateway_.forwarder().add_observer(always_, {.arrivals = false, .fates = true, .departures = false, .always = true});
    gateway_.parts().enter(*this);
    gateway_.parts().scan = this;
    remember_notes();
}

GatewayDevices::~GatewayDevices() {
    gateway_.forwarder().remove_observer(always_);
    gateway_.parts().leave(*this);
    gateway_.parts().scan = nullptr;
}

void GatewayDevices::channel_lost(ChannelId lost) {
    for (unsigned a = 0; a <= 0xFF; ++a)
        if (const auto address = static_cast<std::uint8_t>(a); gateway_.forwarder().router().heard_at(address, lost))
            service_.link_was_down(address);
}

bool GatewayDevices::Place::has(const Gateway& gateway, const Channel& channel) const {
    const std::string its_group = group_of(gateway, channel);
    return its_group.empty() ? link == gateway.link(channel.link).name() && peer == host_of(channel) : group == its_group;
}

// An address moves when its holder is silent, and in a network any sender can forge the address of a lost device. Therefore
// frames of a device that stays_lost() are accepted as its own only at its last place, on a link that is not a network, or on a
// link that it is pinned to.
GatewayDevices::Sender GatewayDevices::sender(const Channel& from, std::uint8_t source) {
    const Router& router = gateway_.forwarder().router();
    if (router.claims(source, from.id)) return Sender::another;
    Place& last = places_[source];
    const bool is_at_home = router.heard_at(source, from.id).has_value();
    if (ano::address::is_host(source) || (last.link.empty() && !is_at_home)) return Sender::itself;
    if (last.has(gateway_, from)) return Sender::itself;
    if (!is_at_home) return Sender::another;
    if (!last.link.empty() && service_.stays_lost(source) && !is_known_origin(gateway_, from, source))
        return log_unknown_sender(from, source), Sender::unknown;
    last = {gateway_.link(from.link).name(), group_of(gateway_, from), std::string{host_of(from)}};
    return Sender::itself;
}

void GatewayDevices::log_unknown_sender(const Channel& from, std::uint8_t source) {
    if (service_.was_received_elsewhere(source)) return;
    const std::string here = format_place(gateway_.link(from.link).name(), from.peer), name = ano::hex_byte(source);
    service_.record_elsewhere(source, here, gateway_.time());
    log_warning(
        "{} now sends on {}, but was last seen on {}: this may be another device, so it stays lost. If it is the same device: "
        "anoctl routes --forget {}",
        name, here, format_place(places_[source].link, places_[source].peer), name);
}

// A frame that is not from the device itself is not logged, and neither raises nor ends an alarm. A frame that may be from a lost
// device in another place may raise one, because commands to the device are sent there.
bool GatewayDevices::AlwaysListener::passes(const Channel& from, ano::FrameView frame) try {
    if (from.id == ourselves) return false;
    const Sender sender = of_.sender(from, frame.source());
    if (sender == Sender::another) return false;
    DeviceService& service = of_.service_;
    const TimePoint now = of_.gateway_.time();
    const auto judge = [&] {
        if (service.alarms().watch().wants(frame.source(), frame.id()))
            service.record_value(frame.source(), ano::read(frame, &of_.gateway_.decoding()->layouts()), now,
                                 sender == Sender::unknown);
    };
    if (sender == Sender::unknown) return judge(), false;
    if (frame.id() == ano::id_of<"log"> || frame.id() == ano::id_of<"log_value">) {
        const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
        const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(since_1970).count();
        const bool is_known = is_known_origin(of_.gateway_, from, frame.source());
        service.record_log(frame, of_.gateway_.link(from.link).name(), static_cast<std::uint64_t>(ns),
                           is_known ? DeviceLog::Origin::known : DeviceLog::Origin::anybody);
    }
    if (frame.id() == ano::id_of<"mode">) service.record_mode(frame, now);
    else service.record_telemetry(frame.source(), frame.id(), now);
    judge();
    return false;
} catch (const std::bad_alloc&) {    // ignores the frame
    return false;
}

std::string GatewayDevices::scan(const std::function<void(const std::string&)>& on_found) {
    JobOrder order{JobKind::scan, ano::host::Operation::read, std::nullopt, false, "the gateway as a device", anogate::scan};
    order.result = [this, on_found] {
        for (const DeviceReport& device : service_.devices(gateway_.now()))
            on_found(ano::hex_byte(device.heard.address) + " " +
                     (device.info ? device.texts.display_text(device.info->name) : "unnamed") +
                     (device.heard.link.empty() ? "" : " by " + device.heard.link));
        return std::string{"[]"};
    };
    const auto begun = service_.begin(std::move(order), gateway_.now());
    const auto* const refused = std::get_if<NotBegun>(&begun);
    return refused ? refused->fault.text() : std::string{};
}

// To be called before the loop runs.
void GatewayDevices::remember_notes() {
    const std::string folder = state_folder();
    std::error_code ec;
    if (folder.empty()) return;
    for (const auto& entry : std::filesystem::directory_iterator{folder, ec}) {
        const std::string name = entry.path().filename().string();
        if (!name.ends_with(unfinished)) remember_file(folder, name);
        else if (is_kept_name(name.substr(0, name.size() - unfinished.size())) || is_abandoned(entry.path(), name))
            forget_file(entry.path().string());    // writing it was interrupted
    }
}

void GatewayDevices::remember_file(const std::string& folder, const std::string& name) {
    if (!is_kept_name(name)) return;
    const auto limited = address_of_limits_file(name);
    const std::string path = folder + "/" + name;
    std::string fault;
    auto text = read_kept_file(path, limited ? AlarmLimits::max_text : max_note, fault);
    if (text && !limited) return remember_note(folder, name, *std::move(text));
    if (text) fault = service_.remember_limits(*limited, *text);
    if (text && !fault.empty()) fault = path + ": " + fault;
    if (fault.empty()) return;
    if (limited) log_warning("{}; {} has no alarm limits until they are set again", fault, ano::hex_byte(*limited));
    else log_warning("{}; {}", fault, loss_of_note(name));
}

// Several gateways of one user share the folder: each reads only its own journal.
void GatewayDevices::remember_note(const std::string& folder, const std::string& name, std::string text) {
    const bool is_of_calibration = sensor_of_note(name).has_value();
    if (const std::string damage = damage_of_note(name, text); !damage.empty())
        return log_warning("{}/{} {}", folder, name, damage);
    const std::string about = describe_note(name, text);
    const std::string misfit = misfit_of_place(text, unit_place(0, {}), false);
    if (!misfit.empty())
        return log_info("{}/{} ({}) is not used: it is {}{}", folder, name, about, misfit,
                        is_of_calibration ? ". To write it back: anoctl param import " + folder + "/" + name : "");
    service_.remember(name, std::move(text));
    if (is_of_calibration)
        log_info(
            "{}/{}: the calibration was not finished ({}); the old values are written back as soon as this device is seen on "
            "the ground, if its values distinguish it from others of its type",
            folder, name, about);
    else if (is_loader_note(name))
        log_info("{}/{}: the device was left in its boot loader ({}) and needs its firmware", folder, name, about);
}

void GatewayDevices::stop() {
    service_.stop(gateway_.now());
    alarm_.cancel();
    queued_tasks_.clear();
    background_task_.stop();
}

std::string GatewayDevices::kept_path(const std::string& name) {
    const std::string folder = state_folder();
    return folder.empty() ? std::string{} : folder + "/" + name;
}

void GatewayDevices::keep(std::string name, std::string text, std::function<void(std::string fault)> done) {
    const std::string path = kept_path(name);
    const auto fault = std::make_shared<std::string>();
    aside(
        [path, text = std::move(text), fault] {
            *fault = text.empty() ? forget_file(path)
                                  : write_atomically(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        },
        [fault, done = std::move(done)](const std::string& thrown) {
            const std::string why = thrown.empty() ? *fault : thrown;
            if (!why.empty()) log_warning("{}; after a restart, the gateway does not have it", why);
            done(why);
        });
}

void GatewayDevices::aside(std::function<void()> work, std::function<void(std::string fault)> done) {
    queued_tasks_.push_back({std::move(work), std::move(done)});
    start_next_task();
}

void GatewayDevices::start_next_task() {
    if (queued_tasks_.empty() || background_task_.is_running()) return;
    QueuedTask queued = std::move(queued_tasks_.front());
    queued_tasks_.pop_front();
    const auto done = [this, callback = queued.done](std::string fault) {
        callback(std::move(fault));
        start_next_task();
    };
    if (background_task_.run(std::move(queued.work), done)) return;
    queued.done(std::string{background_task_.why_not()});
    start_next_task();
}

ano::TimePoint GatewayDevices::now() { return gateway_.now(); }

void GatewayDevices::listen(bool wants) {
    waiting_.clear();
    lost_.clear();
    if (wants) gateway_.forwarder().add_observer(*this, {.arrivals = false, .fates = true, .departures = true});
    else gateway_.forwarder().remove_observer(*this);
    listens_ = wants;
}

void GatewayDevices::own_answer(ano::FrameView frame) {
    if (listens_) service_.receive(frame, gateway_.now());
}

void GatewayDevices::own_refusal(const std::string& why) {
    if (!listens_) return;
    if (sends_) refusal_.why = {"other", why};
    else service_.refuse(gateway_.settings().gateway.id, {"other", why}, gateway_.now());
}

bool GatewayDevices::may_have_waited(ano::TimePoint came_at) {
    gateway_.turn();
    return gateway_.loop().may_have_waited(came_at);
}

Unsent GatewayDevices::send(ano::FrameView frame) {
    ControlLink* const link = gateway_.control();
    if (!link) return {{"other", no_control_link}};
    if (frame.destination() == gateway_.settings().gateway.id) {
        if (!is_device(gateway_.settings().gateway)) return {{"gateway_itself", ano::hex_byte(frame.destination())}};
        if (ano::is_control(frame) && !gateway_.settings().control.manage) return {{"may_not_manage"}};
    }
    was_accepted_ = false;
    left_by_[frame.destination()].clear();
    sends_frame_.assign(frame.bytes().begin(), frame.bytes().end());
    refusal_ = {};
    ++sends_number_;
    sends_ = true;
    link->send(frame);
    sends_ = false;
    gateway_.flush();
    return was_accepted_ ? lost_at_once() : std::exchange(refusal_, {});
}

Unsent GatewayDevices::lost_at_once() {
    const auto lost = std::ranges::find(lost_, sends_number_, &Lost::number);
    if (lost == lost_.end()) return {};
    const Unsent why = unsent(*lost);
    const bool ends_it = !why.is_down ||
                         ano::FrameView{lost->frame}.id() == ano::id_of<"command">;    // anything else is sent again
    lost_.erase(lost);
    return ends_it ? why : Unsent{};
}

void GatewayDevices::report_lost() {
    for (; !lost_.empty(); lost_.erase(lost_.begin())) {
        const Lost lost = lost_.front();
        service_.not_sent(ano::FrameView{lost.frame}, unsent(lost), gateway_.now());
    }
}

Unsent GatewayDevices::unsent(const Lost& lost) const {
    ano::Fault link{"removed_link"};
    for (const LinkState& state : gateway_.links())
        if (state.link->id() == lost.link) link = {"link_named", state.link->name()};
    if (!lost.refusal.empty()) return {{"no_v7_frame", link, lost.refusal}};
    if (lost.cause == &SendCounters::stale) return {{"too_old", link}, true};
    if (lost.cause == &SendCounters::queue_full) return {{"queue_full", link}, true};
    if (lost.cause == &SendCounters::link_down) return {{"link_down", link}, true};
    return {{"send_failed", link}, !is_for_good(lost.cause)};
}

ano::Flush GatewayDevices::flush_parser(ano::FrameView next) {
    ControlLink* const link = gateway_.control();
    return link ? link->flush_parsers(next) : ano::Flush{};
}

bool GatewayDevices::is_waiting(std::uint8_t address) {
    for (const ChannelId id : left_by_[address] & gateway_.forwarder().channels())
        if (gateway_.forwarder().channel(id).has_waiting(ourselves)) return true;
    return false;
}

// Bytes in the driver count as not sent.
ano::Fault GatewayDevices::accepts_nothing(std::uint8_t address) {
    ano::Fault why;
    for (const LinkState& state : gateway_.links()) {
        const KernelQueue* const queue = state.link->as<KernelQueue>();
        for (const ChannelId id : left_by_[address] & gateway_.forwarder().traffic(state.link->id()).channels) {
            const Channel& channel = gateway_.forwarder().channel(id);
            const SendCounters sent = channel.sent();
            const std::size_t held = queue && state.up ? queue->unsent() : 0;
            const bool waits = channel.waiting() > 0 || held > 0;
            if (!drains_[index(id)].accepts_nothing(sent.bytes_out + sent.flush_bytes - held, waits, gateway_.time())) continue;
            why = {"link_takes_nothing", ano::Fault{"link_named", state.link->name()}};
        }
    }
    return why;
}

bool GatewayDevices::passes(const Channel& from, ano::FrameView frame) {
    if (from.id == ourselves) return false;
    heard_by_ = from.link;
    heard_from_ = from.id;
    if (!gateway_.forwarder().router().claims(frame.source(), from.id)) return service_.receive(frame, gateway_.time());
    service_.record_elsewhere(frame, gateway_.link(from.link).name() + (from.peer.empty() ? "" : " (" + from.peer + ")"));
    return false;
}

bool GatewayDevices::came_from(std::uint8_t address) {
    return gateway_.forwarder().channels().contains(heard_from_) && !gateway_.forwarder().router().claims(address, heard_from_);
}

// Uses `sends_frame_`, because the destination of the frame may already be replaced by an alias.
void GatewayDevices::offered(const Channel& to, ano::FrameView frame, ChannelId from) {
    if (from != ourselves) return;
    if (!sends_) return service_.sent_by_others(frame, gateway_.time());    // a hello, or a frame of POST /send
    was_accepted_ = true;
    left_by_[ano::FrameView{sends_frame_}.destination()].insert(to.id);
    if (waiting_.size() == max_waiting) waiting_.erase(waiting_.begin());
    waiting_.push_back({sends_number_, sends_frame_, to.id, {frame.bytes().begin(), frame.bytes().end()}});
}

std::vector<GatewayDevices::Waiting>::iterator GatewayDevices::find_waiting(const Channel& to, ano::FrameView frame) noexcept {
    return std::ranges::find_if(
        waiting_, [&](const Waiting& one) { return one.channel == to.id && std::ranges::equal(one.copy, frame.bytes()); });
}

// One copy that is sent is enough.
void GatewayDevices::left(const Channel& to, ano::FrameView frame) noexcept {
    const auto sent = find_waiting(to, frame);
    if (sent == waiting_.end()) return;
    std::erase_if(waiting_, [number = sent->number](const Waiting& one) { return one.number == number; });
}

// An outbox calls it, so the service is told when the alarm is due.
void GatewayDevices::discarded(const Channel& to, ano::FrameView frame, SendCause cause) noexcept {
    const auto found = find_waiting(to, frame);
    if (found == waiting_.end()) return;
    Lost lost{found->number, std::move(found->frame), to.link, cause, to.v7.refusal};
    waiting_.erase(found);
    const bool has_copies = std::ranges::find(waiting_, lost.number, &Waiting::number) != waiting_.end();
    if (has_copies || lost_.size() == max_lost) return;
    lost_.push_back(std::move(lost));
    wake(gateway_.now());
}

void GatewayDevices::dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) {
    if (!sends_ || from.id != ourselves) return;
    if (cause == &ReceiveCounters::no_route && ano::intent_of(frame) == ano::Intent::acts)
        refusal_.why = {"other", not_routed(frame.destination()).text};
    if (!is_for_good(cause)) return;
    refusal_.why = cause == &ReceiveCounters::inhibited ? ano::Fault{"control_inhibited"} : ano::Fault{"control_forbids"};
}

void GatewayDevices::refused(LinkId to, ano::FrameView, SendCause cause) {
    if (!sends_) return;
    const ano::Fault link{"link_named", gateway_.link(to).name()};
    if (cause == &SendCounters::link_down) refusal_ = {{"link_down", link}, true};
    if (!is_for_good(cause)) return;
    refusal_.why = cause == &SendCounters::too_big         ? ano::Fault{"link_too_short", link}
                   : gateway_.forwarder().is_exclusive(to) ? ano::Fault{"link_exclusive", link}
                                                           : ano::Fault{"link_forbids", link};
}

std::vector<HeardAddress> GatewayDevices::heard(ano::TimePoint now) {
    std::vector<HeardAddress> all;
    if (const GatewaySettings& gateway = gateway_.settings().gateway; is_device(gateway))
        all.push_back({gateway.id, {}, {}, now});
    for (const RouteRow& row : route_rows(gateway_, now)) {
        if (row.via != Via::learned || ano::address::is_host(row.address) || row.address == service_.own()) continue;
        HeardAddress heard{row.address, {}, {}, row.heard_at};
        for (const ChannelId id : gateway_.forwarder().channels()) {
            const Channel& channel = gateway_.forwarder().channel(id);
            const auto at = gateway_.forwarder().router().heard_at(row.address, id);
            if (!at || (!heard.link.empty() && *at < *heard.heard_at)) continue;
            heard.link = gateway_.link(channel.link).name();
            heard.peer = channel.peer;
            heard.heard_at = at;
        }
        all.push_back(std::move(heard));
    }
    return all;
}

LinkSet GatewayDevices::links_to(std::uint8_t address, ano::TimePoint now) const {
    const Router& router = gateway_.forwarder().router();
    LinkSet links = router.port(address);
    if (links.empty()) links = router.pinned(address);
    return links.empty() ? router.learned(address, now).links : links;
}

// All links of a group lead to the same place.
UnitPlace GatewayDevices::unit_place(std::uint8_t address, ano::TimePoint now) {
    const ControlSettings& control = gateway_.settings().control;
    UnitPlace place;
    place.gateway = http::control_socket(control.socket, http::this_runner()).value_or("without a control socket");
    if (address == 0) return place;
    const LinkSet links = links_to(address, now);
    for (const LinkState& state : gateway_.links()) {
        if (!links.contains(state.link->id())) continue;
        const LinkSettings& link = state.link->settings();
        if (!link.group.empty()) return {place.gateway, "group " + link.group, "group " + link.group};
        if (!place.link.empty()) continue;
        place.link = link.name;
        place.wire = wire_of(link);
    }
    return place;
}

std::string GatewayDevices::date_text() {
    const std::time_t now = std::time(nullptr);
    std::tm parts{};
    ::gmtime_r(&now, &parts);
    char text[32];
    return std::string{text, std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S UTC", &parts)};
}

void GatewayDevices::report(const std::string& text, bool is_warning) {
    if (is_warning) log_warning("{}", text);
    else log_info("{}", text);
}

ano::host::RouteInfo GatewayDevices::route_info(std::uint8_t address, ano::TimePoint now) {
    const Forwarder& forwarder = gateway_.forwarder();
    const Router& router = forwarder.router();
    ano::host::RouteInfo where;
    const LinkSet links = links_to(address, now);
    where.is_known = !links.empty() || address == gateway_.settings().gateway.id;
    const auto conflicts = router.conflicts(now);
    const bool is_pinned = !router.pinned(address).empty();    // a pinned route identifies the device
    where.in_conflict = !is_pinned &&
                        std::any_of(conflicts.begin(), conflicts.end(), [&](const Conflict& c) { return c.address == address; });
    std::size_t channels = 0;
    std::string group;
    std::optional<ano::TimePoint> last;
    for (const ChannelId id : forwarder.channels()) {
        if (const auto at = router.heard_at(address, id); at && (!last || *at > *last)) {
            last = at;
            where.was_heard = !router.are_all_down(id);
        }
        const LinkId link = gateway_.forwarder().channel(id).link;
        if (!links.contains(link) || !router.heard_at(address, id)) continue;
        const std::string& of_link = gateway_.link(link).settings().group;
        if (!of_link.empty() && of_link == group) continue;
        group = of_link;
        ++channels;
    }
    where.on_several_channels = channels > 1;
    return where;
}

std::vector<std::string> GatewayDevices::links_in_conflict(std::uint8_t address, ano::TimePoint now) {
    std::vector<std::string> names;
    for (const Conflict& conflict : gateway_.forwarder().router().conflicts(now)) {
        if (conflict.address != address) continue;
        for (const LinkId link : conflict.links) names.emplace_back(gateway_.link(link).name());
    }
    return names;
}

bool GatewayDevices::is_same_device(std::uint8_t one, std::uint8_t other) {
    const Router& router = gateway_.forwarder().router();
    const auto is_behind = [&](std::uint8_t address, std::uint8_t port) {
        const LinkSet of_port = router.port(port);
        if (of_port.empty()) return false;
        const LinkSet leads = router.learned(address, gateway_.time()).links | router.pinned(address) | router.port(address);
        return !(leads & of_port).empty();
    };
    return is_behind(one, other) || is_behind(other, one);
}

// The same order as in the router: links with this port id come before links that the address is pinned to.
bool GatewayDevices::may_answer_for(std::uint8_t source, std::uint8_t port) {
    const Router& router = gateway_.forwarder().router();
    LinkSet ways = router.port(port);
    if (ways.empty()) ways = router.pinned(port);
    const bool is_own_sender = !(router.learned(port, gateway_.time()).links & ways).empty();
    return source != port && !is_own_sender && ways.contains(heard_by_);
}

// The strictest limits of all links to this address.
const ano::FlexibleLayouts& GatewayDevices::layouts() const { return gateway_.decoding()->layouts(); }

DeviceLimits GatewayDevices::device_limits(std::uint8_t address) {
    const Router& router = gateway_.forwarder().router();
    const LinkSet links = router.learned(address, gateway_.time()).links | router.pinned(address) | router.port(address);
    DeviceLimits device_limits;
    for (const LinkState& state : gateway_.links()) {
        if (!links.contains(state.link->id())) continue;
        const LinkSettings& link = state.link->settings();
        if (const auto most = link.max_text()) device_limits.text.max_bytes = most;
        device_limits.expects_gbk = device_limits.expects_gbk || link.profile == Profile::vendor;
        if (const auto stated = link.stated_type_7()) device_limits.value_type_7 = stated;
        if (link.encoding) device_limits.encoding = encoding_of(*link.encoding);
        device_limits.by_number = device_limits.by_number || uses_v7(link);
        device_limits.max_data = std::min<std::size_t>(device_limits.max_data, link.effective_max_data_out());
    }
    return device_limits;
}

}    // namespace anogate
