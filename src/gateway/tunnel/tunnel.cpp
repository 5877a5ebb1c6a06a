#include <ano/address.hpp>
#include <gateway/tunnel/tunnel.hpp>

#include <algorithm>
#include <cstring>

namespace anogate {
namespace {

constexpr std::size_t prefix_bytes = 3;    // of an address, omitted by 0xB2

IpAddress ip_at(const std::uint8_t* bytes) noexcept { return IpAddress::v4(bytes[0], bytes[1], bytes[2], bytes[3]); }

IpAddress in_network(IpAddress network, std::uint8_t last) noexcept {
    network.bytes[prefix_bytes] = last;
    return network;
}

bool same_short_network(const IpAddress& a, const IpAddress& b) noexcept {
    return !a.v6 && !b.v6 && std::equal(a.bytes.begin(), a.bytes.begin() + prefix_bytes, b.bytes.begin());
}

}    // namespace

std::optional<TunnelContent> unwrap(ano::FrameView frame, const IpAddress& network) noexcept {
    const auto data = frame.data();
    const std::size_t size = tunnel_head_size(frame.id());
    if (!is_tunnel_frame(frame) || data.size() < size) return std::nullopt;
    TunnelContent content;
    content.head.source = size == 10 ? ip_at(data.data()) : in_network(network, data[0]);
    content.head.destination = size == 10 ? ip_at(&data[4]) : in_network(network, data[1]);
    content.head.port = static_cast<std::uint16_t>(data[size - 2] | data[size - 1] << 8);
    content.inner = data.subspan(size);
    return content;
}

std::optional<ano::FrameView> InnerFrames::next() noexcept {
    const auto frame = ano::frame_at(rest_);
    if (frame) rest_ = rest_.subspan(frame->bytes().size());
    return frame;
}

bool may_contain(ano::FrameView frame, bool (*is_meant)(ano::FrameView inner)) noexcept {
    if (!is_tunnel_frame(frame)) return false;
    const auto content = unwrap(frame, {});
    if (!content) return true;
    if (content->inner.empty()) return false;
    InnerFrames frames{content->inner};
    while (const auto inner = frames.next())
        if (is_meant(*inner) || is_tunnel_frame(*inner)) return true;
    return !frames.good();
}

void TunnelWriter::begin(std::uint8_t id, std::uint8_t source, std::uint8_t destination, std::size_t max_data) noexcept {
    ano::write_header({buffer_.get(), ano::header_size}, source, destination, id, 0);
    end_ = inner_at();
    max_end_ = ano::header_size + std::min(max_data, ano::max_len);
}

bool TunnelWriter::add(ano::FrameView inner) noexcept {
    const auto bytes = inner.bytes();
    if (end_ > max_end_ || bytes.size() > max_end_ - end_) return false;
    std::memcpy(buffer_.get() + end_, bytes.data(), bytes.size());
    end_ += bytes.size();
    return true;
}

std::span<const std::uint8_t> TunnelWriter::inner() const noexcept { return {buffer_.get() + inner_at(), end_ - inner_at()}; }

ano::FrameView TunnelWriter::finish(const TunnelHead& head) noexcept {
    std::uint8_t* at = buffer_.get() + ano::header_size;
    if (buffer_[3] == ip_tunnel) {
        at = std::copy_n(head.source.bytes.begin(), 4, at);
        at = std::copy_n(head.destination.bytes.begin(), 4, at);
    } else {
        *at++ = head.source.bytes[prefix_bytes];
        *at++ = head.destination.bytes[prefix_bytes];
    }
    at[0] = static_cast<std::uint8_t>(head.port);
    at[1] = static_cast<std::uint8_t>(head.port >> 8);
    const std::size_t length = end_ - ano::header_size;
    const std::span<std::uint8_t> frame{buffer_.get(), ano::overhead + length};
    ano::write_header(frame, buffer_[1], buffer_[2], buffer_[3], length);
    ano::seal(frame);
    return ano::FrameView{frame};
}

Tunnel::Tunnel(TunnelSettings settings, std::uint8_t own_id, Environment environment)
    : settings_{std::move(settings)},
      own_id_{own_id},
      environment_{std::move(environment)},
      port_{settings_.port},
      policy_{settings_} {}

bool Tunnel::takes(ano::FrameView frame) const noexcept {
    if (!is_tunnel_frame(frame)) return false;
    const std::uint8_t to = frame.destination();
    return to == settings_.address || to == ano::address::broadcast || (to == own_id_ && own_id_ != 0);
}

std::optional<Tunnel::Datagram> Tunnel::out(ano::FrameView frame, const Passes& passes) {
    const auto refused = [this](std::uint64_t TunnelCounters::*cause) {
        refuse(cause);
        return std::nullopt;
    };
    const auto network = frame.id() == ip_tunnel ? IpAddress{} : environment_.our_address({});
    if (!network) return refused(&TunnelCounters::tunnel_no_way);
    const auto content = unwrap(frame, *network);
    if (!content) return refused(&TunnelCounters::tunnel_malformed);
    TunnelHead head = content->head;
    const Endpoint to{head.destination, head.port != 0 ? head.port : port_};
    if (!policy_.allows(to.address)) return refused(&TunnelCounters::tunnel_not_allowed);
    if (policy_.is_own(to.address) && is_own_port(to.port)) return refused(&TunnelCounters::tunnel_own_port);

    out_.begin(frame.id(), frame.source(), frame.destination(), ano::max_len);
    if (!gather(content->inner, passes)) return std::nullopt;
    Datagram datagram{to, out_.inner()};
    if (settings_.deliver == Deliver::tunnel) {
        const auto ours = environment_.our_address(to.address);
        if (!ours) return refused(&TunnelCounters::tunnel_no_way);
        head.source = *ours;
        datagram.bytes = out_.finish(head).bytes();
    }
    if (datagram.bytes.size() > max_datagram) return refused(&TunnelCounters::tunnel_too_big);
    return datagram;
}

// False: nothing is left to send.
bool Tunnel::gather(std::span<const std::uint8_t> inner, const Passes& passes) {
    InnerFrames frames{inner};
    while (const auto frame = frames.next())
        if (passes(*frame)) out_.add(*frame);
    if (!frames.good()) refuse(&TunnelCounters::tunnel_bad_inner);
    return !out_.empty();
}

bool Tunnel::admits(const Endpoint& sender) {
    if (sender.port == 0 || !policy_.allows(sender.address)) {
        refuse(&TunnelCounters::tunnel_not_allowed);
        return false;
    }
    if (policy_.is_own(sender.address) && is_own_port(sender.port)) {
        refuse(&TunnelCounters::tunnel_own_port);
        return false;
    }
    return true;
}

bool Tunnel::in(ano::FrameView frame, const IpAddress& sender, const OnFrame& on_frame) {
    const auto content = unwrap(frame, sender);
    if (!content) {
        refuse(&TunnelCounters::tunnel_malformed);
        return false;
    }
    if (!is_ours(content->head.destination)) {
        refuse(&TunnelCounters::tunnel_other_ip);
        return false;
    }
    InnerFrames frames{content->inner};
    bool taken = false;
    while (const auto inner = frames.next()) {
        on_frame(*inner);
        taken = true;
    }
    if (!frames.good()) refuse(&TunnelCounters::tunnel_bad_inner);
    if (taken) ++counters_.unwrapped;
    return taken;
}

bool Tunnel::is_own_port(std::uint16_t port) const { return port == port_ || environment_.is_own_port(port); }

bool Tunnel::is_ours(const IpAddress& address) const noexcept { return has_ip() ? ip() == address : policy_.is_own(address); }

void Tunnel::set_hosts(HostAddresses hosts) {
    hosts_ = std::move(hosts);
    std::vector<IpAddress> allowed;
    for (const std::string& host : settings_.allow_hosts) {
        const auto addresses = addresses_of(host);
        allowed.insert(allowed.end(), addresses.begin(), addresses.end());
    }
    policy_.set_hosts(std::move(allowed));
}

std::optional<IpAddress> Tunnel::ip() const noexcept {
    if (settings_.ip) return settings_.ip;
    const auto addresses = addresses_of(settings_.ip_host);
    const auto v4 = std::find_if(addresses.begin(), addresses.end(), [](const IpAddress& one) { return !one.v6; });
    return v4 == addresses.end() ? std::nullopt : std::optional{*v4};
}

std::span<const IpAddress> Tunnel::addresses_of(const std::string& host) const noexcept {
    const auto found = hosts_.find(host);
    return found == hosts_.end() ? std::span<const IpAddress>{} : found->second;
}

bool Tunnel::is_from(const WrapSettings& rule, const IpAddress& sender) const noexcept {
    if (rule.from_host.empty()) return rule.from.contains(sender);
    const auto addresses = addresses_of(rule.from_host);
    return std::find(addresses.begin(), addresses.end(), sender) != addresses.end();
}

std::optional<std::size_t> Tunnel::wrap_rule(const IpAddress& sender) const noexcept {
    for (std::size_t i = 0; i < settings_.wrap.size(); ++i)
        if (is_from(settings_.wrap[i], sender)) return i;
    return std::nullopt;
}

bool Tunnel::begin_wrap(std::size_t rule, std::size_t max_data, const Endpoint& sender) {
    const auto ours = environment_.our_address(sender.address);
    if (!ours) return refuse_wrap(&TunnelCounters::tunnel_no_way);
    if (settings_.wrap[rule].id == ip_tunnel_short && !same_short_network(sender.address, *ours))
        return refuse_wrap(&TunnelCounters::tunnel_other_network);
    wrapping_ = rule;
    wrap_max_data_ = max_data;
    wrap_head_ = {sender.address, *ours, sender.port};
    start_wrap();
    return true;
}

bool Tunnel::refuse_wrap(std::uint64_t TunnelCounters::*cause) noexcept {
    refuse(cause);
    refused_wrap_ = true;
    return false;
}

void Tunnel::start_wrap() noexcept {
    const WrapSettings& rule = settings_.wrap[*wrapping_];
    wrap_.begin(rule.id, rule.source, rule.to, wrap_max_data_);
}

void Tunnel::add_to_wrap(ano::FrameView frame, const OnFrame& send) {
    if (wrap_.add(frame)) return;
    send_wrap(send);
    if (!wrap_.add(frame)) refuse(&TunnelCounters::tunnel_too_big);
}

void Tunnel::send_wrap(const OnFrame& send) {
    if (wrap_.empty()) return;
    ++counters_.wrapped;
    send(wrap_.finish(wrap_head_));
    start_wrap();
}

void Tunnel::end_wrap(const OnFrame& send) {
    if (wrapping_) send_wrap(send);
    wrapping_.reset();
    refused_wrap_ = false;
}

}    // namespace anogate
