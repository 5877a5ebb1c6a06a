#include <ano/address.hpp>
#include <ano/control.hpp>
#include <ano/hex.hpp>
#include <config/read_file.hpp>
#include <daemon/control_link.hpp>
#include <daemon/gateway.hpp>
#include <daemon/gateway_devices.hpp>
#include <daemon/kept_file.hpp>
#include <daemon/log_line.hpp>
#include <daemon/route_rows.hpp>
#include <daemon/state_folder.hpp>
#include <devices/scan_work.hpp>
#include <managed/managed_parameters.hpp>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <system_error>
#include <utility>

namespace anogate {
namespace {

// The number of bytes that the profile's parser has for a text.
constexpr std::size_t vendor_text = 29;

constexpr std::size_t max_note = 64 * 1024;

// Asking again would have the same result, unlike with a link that is down for a moment.
bool is_for_good(ReceiveCause cause) { return cause == &ReceiveCounters::denied_in || cause == &ReceiveCounters::inhibited; }
bool is_for_good(SendCause cause) { return cause == &SendCounters::denied_out || cause == &SendCounters::too_big; }

}    // namespace

GatewayDevices::GatewayDevices(Gateway& gateway)
    : gateway_{gateway},
      alarm_{gateway.alarms(), [this] { service_.run(gateway_.now()); }},
      errand_{gateway.io()},
      service_{*this, gateway.settings().control.host} {
    gateway_.on_scan([this](const std::function<void(const std::string&)>& tell) { return scan(tell); });
    remember_notes();
}

GatewayDevices::~GatewayDevices() { gateway_.on_scan({}); }

std::string GatewayDevices::scan(const std::function<void(const std::string&)>& tell) {
    JobOrder order{JobKind::scan, ano::host::Deed::read, std::nullopt, false, "the gateway as a device", anogate::scan};
    order.result = [this, tell] {
        for (const DeviceReport& device : service_.devices(gateway_.now()))
            tell(ano::hex_byte(device.heard.address) + " " + (device.info ? device.info->name : "of no name") +
                 (device.heard.link.empty() ? "" : " by " + device.heard.link));
        return std::string{"[]"};
    };
    const auto begun = service_.begin(std::move(order), gateway_.now());
    const auto* const refused = std::get_if<NotBegun>(&begun);
    return refused ? refused->error : std::string{};
}

// Called before the loop runs.
void GatewayDevices::remember_notes() {
    const std::string folder = state_folder();
    std::error_code ec;
    if (folder.empty()) return;
    for (const auto& entry : std::filesystem::directory_iterator{folder, ec}) {
        const std::string name = entry.path().filename().string();
        if (!is_note(name) || !entry.is_regular_file(ec)) continue;    // reading other files may never end
        std::string text = read_file(entry.path().string(), max_note, ec);
        if (ec) log_warning("{}: {}", entry.path().string(), ec.message());
        else if (!service_.remember(name, std::move(text)))
            log_warning("{}/{} is damaged: the old values of a calibration are not written back; calibrate again, or remove it",
                        folder, name);
        else
            log_info("{}/{}: {}", folder, name,
                     name.starts_with("firmware") ? "the device was left in its loader, it needs its firmware"
                                                  : "a calibration never ended; the old values are written back as soon as the "
                                                    "device is heard on the ground");
    }
}

void GatewayDevices::stop() {
    service_.stop(gateway_.now());
    alarm_.cancel();
    chores_.clear();
    errand_.stop();
}

void GatewayDevices::keep(std::string name, std::string text, std::function<void(std::string fault)> done) {
    const std::string folder = state_folder();
    const std::string path = folder.empty() ? std::string{} : folder + "/" + name;
    const auto fault = std::make_shared<std::string>();
    aside(
        [path, text = std::move(text), fault] {
            *fault = text.empty() ? forget_file(path)
                                  : keep_file(path, {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
        },
        [fault, done = std::move(done)](const std::string& thrown) { done(thrown.empty() ? *fault : thrown); });
}

void GatewayDevices::aside(std::function<void()> work, std::function<void(std::string fault)> done) {
    chores_.push_back({std::move(work), std::move(done)});
    next_chore();
}

void GatewayDevices::next_chore() {
    if (chores_.empty() || errand_.is_running()) return;
    Chore chore = std::move(chores_.front());
    chores_.pop_front();
    const auto done = [this, told = chore.done](std::string fault) {
        told(std::move(fault));
        next_chore();
    };
    if (errand_.run(std::move(chore.work), done)) return;
    chore.done("no thread can be had");
    next_chore();
}

ano::TimePoint GatewayDevices::now() { return gateway_.now(); }

void GatewayDevices::listen(bool wants) {
    if (wants) gateway_.add_observer(*this, {.arrivals = false, .fates = true, .departures = false});
    else gateway_.remove_observer(*this);
    gateway_.on_answer_to_ourselves(wants ? [this](ano::FrameView frame) { service_.hear(frame, gateway_.now()); }
                                          : std::function<void(ano::FrameView)>{});
    gateway_.on_refusal_to_ourselves(wants ? [this](const std::string& why) { refusal_ = why; }
                                           : std::function<void(const std::string&)>{});
}

bool GatewayDevices::may_have_waited(ano::TimePoint came_at) {
    gateway_.turn();
    return gateway_.loop().may_have_waited(came_at);
}

std::string GatewayDevices::send(ano::FrameView frame) {
    ControlLink* const link = gateway_.control();
    if (!link) return "all 64 links are in use: there is no place for the link 'control'";
    if (frame.destination() == gateway_.settings().gateway.id) {
        if (!is_device(gateway_.settings().gateway)) return ano::hex_byte(frame.destination()) + " is the gateway itself";
        if (ano::is_control(frame) && !gateway_.settings().control.manage)
            return "the control interface may not manage the gateway (control.manage)";
    }
    was_taken_ = false;
    refusal_.clear();
    sends_ = true;
    link->send(frame);
    sends_ = false;
    gateway_.flush();
    return was_taken_ ? std::string{} : std::exchange(refusal_, {});
}

bool GatewayDevices::passes(const Channel& from, ano::FrameView frame) {
    if (from.id == ourselves) return false;
    heard_by_ = from.link;
    return service_.hear(frame, gateway_.time());
}

void GatewayDevices::offered(const Channel&, ano::FrameView, ChannelId from) {
    if (sends_ && from == ourselves) was_taken_ = true;
}

void GatewayDevices::dropped(const Channel& from, ano::FrameView, ReceiveCause cause) {
    if (!sends_ || from.id != ourselves || !is_for_good(cause)) return;
    refusal_ = cause == &ReceiveCounters::inhibited ? "a GPIO switch that inhibits the link 'control' keeps this off"
                                                    : "the rules 'control.receive' do not let this pass";
}

void GatewayDevices::refused(LinkId to, ano::FrameView, SendCause cause) {
    if (!sends_ || !is_for_good(cause)) return;
    const std::string& name = gateway_.name(to);
    refusal_ = cause == &SendCounters::too_big ? "it has more DATA than the link '" + name + "' carries"
                                               : "the rules 'send' of the link '" + name + "' do not let this pass";
}

std::vector<HeardAddress> GatewayDevices::heard(ano::TimePoint now) {
    std::vector<HeardAddress> all;
    if (const GatewaySettings& gateway = gateway_.settings().gateway; is_device(gateway))
        all.push_back({gateway.id, {}, {}, now});
    for (const RouteRow& row : route_rows(gateway_, now)) {
        if (row.via != Via::learned || ano::address::is_host(row.address) || row.address == service_.own()) continue;
        HeardAddress heard{row.address, {}, {}, row.heard_at};
        for (const ChannelId id : gateway_.forwarder().channels()) {
            const Channel& channel = gateway_.channel(id);
            const auto at = gateway_.forwarder().router().heard_at(row.address, id);
            if (!at || (!heard.link.empty() && *at < *heard.heard_at)) continue;
            heard.link = gateway_.name(channel.link);
            heard.peer = channel.peer;
            heard.heard_at = at;
        }
        all.push_back(std::move(heard));
    }
    return all;
}

ano::host::Whereabouts GatewayDevices::whereabouts(std::uint8_t address, ano::TimePoint now) {
    const Forwarder& forwarder = gateway_.forwarder();
    const Router& router = forwarder.router();
    ano::host::Whereabouts where;
    LinkSet links = router.port(address);
    if (links.empty()) links = router.pinned(address);
    if (links.empty()) links = router.learned(address, now).links;
    where.is_known = !links.empty() || address == gateway_.settings().gateway.id;
    const auto conflicts = router.conflicts(now);
    where.in_conflict = std::any_of(conflicts.begin(), conflicts.end(), [&](const Conflict& c) { return c.address == address; });
    std::size_t channels = 0;
    std::string group;
    for (const ChannelId id : forwarder.channels()) {
        const LinkId link = gateway_.channel(id).link;
        if (!links.contains(link) || !router.heard_at(address, id)) continue;
        const std::string& of_link = gateway_.settings(link).group;
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
        for (const LinkId link : conflict.links) names.emplace_back(gateway_.name(link));
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
    const bool speaks_itself = !(router.learned(port, gateway_.time()).links & ways).empty();
    return source != port && !speaks_itself && ways.contains(heard_by_);
}

// The manners for the strictest of the links to this address.
DeviceManners GatewayDevices::manners(std::uint8_t address) {
    const Router& router = gateway_.forwarder().router();
    const LinkSet links = router.learned(address, gateway_.time()).links | router.pinned(address) | router.port(address);
    DeviceManners manners;
    for (const LinkState& state : gateway_.links()) {
        if (!links.contains(state.link->id())) continue;
        const LinkSettings& link = state.link->settings();
        if (link.profile == Profile::vendor) manners.text.max_bytes = vendor_text;
        manners.value_type_7 = link.meaning_of_type_7();
        manners.max_data = std::min<std::size_t>(manners.max_data, link.effective_max_data_out());
    }
    return manners;
}

}    // namespace anogate
