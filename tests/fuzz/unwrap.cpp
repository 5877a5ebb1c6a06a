// Any bytes as the DATA of a tunnel frame, out and in: the result is exactly the contained frames, complete, each once.
#include <gateway/tunnel/tunnel.hpp>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

namespace {

using namespace anogate;

void must(bool law) {
    if (!law) std::abort();
}

const IpAddress us = IpAddress::v4(192, 168, 0, 5), sender = IpAddress::v4(192, 168, 0, 20);

Tunnel make_tunnel(Deliver deliver) {
    TunnelSettings settings;
    settings.deliver = deliver;
    auto& rule = settings.wrap.emplace_back();
    rule.from = {sender, 24};
    Tunnel tunnel{settings, 0, {[](const IpAddress&) { return std::optional{us}; }, [](std::uint16_t p) { return p == 8088; }}};
    tunnel.set_networks({{IpAddress::v4(127, 0, 0, 1), 8}, {us, 24}});
    return tunnel;
}

/// The frames at the beginning of `bytes`, found by the simplest method.
std::vector<std::uint8_t> whole_frames(std::span<const std::uint8_t> bytes) {
    std::size_t end = 0;
    while (const auto frame = ano::frame_at(bytes.subspan(end))) end += frame->bytes().size();
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end)};
}

std::uint64_t refused(const TunnelCounters& counters) {
    std::uint64_t sum = 0;
    for (const auto& row : tunnel_counters)
        if (row.name.starts_with("tunnel_")) sum += counters.*row.value;
    return sum;
}

void out(ano::FrameView frame, const std::vector<std::uint8_t>& whole, Deliver deliver) {
    Tunnel tunnel = make_tunnel(deliver);
    const auto datagram = tunnel.out(frame, [](ano::FrameView) { return true; });
    must(datagram || refused(tunnel.counters()) > 0);
    if (!datagram) return;
    must(!datagram->to.address.v6 && Network{us, 24}.contains(datagram->to.address) && datagram->to.address != us);
    must(datagram->to.port != 0 && datagram->bytes.size() <= max_datagram && !whole.empty());
    if (deliver == Deliver::frames)
        return must(std::equal(whole.begin(), whole.end(), datagram->bytes.begin(), datagram->bytes.end()));
    const auto sent = ano::frame_at(datagram->bytes);
    must(sent && sent->bytes().size() == datagram->bytes.size());
    const auto content = unwrap(*sent, us);
    must(content && content->head.source == us && content->head.destination == datagram->to.address);
    must(std::equal(whole.begin(), whole.end(), content->inner.begin(), content->inner.end()));
}

void in(ano::FrameView frame, const std::vector<std::uint8_t>& whole) {
    Tunnel tunnel = make_tunnel(Deliver::frames);
    std::vector<std::uint8_t> taken;
    const bool any = tunnel.in(frame, sender,
                               [&](ano::FrameView f) { taken.insert(taken.end(), f.bytes().begin(), f.bytes().end()); });
    must(any == !taken.empty() && (any || refused(tunnel.counters()) == 1));
    must(taken.empty() || taken == whole);

    // The accepted content, wrapped again in pieces: the same frames.
    std::vector<std::uint8_t> again;
    const auto collect = [&](ano::FrameView f) {
        must(f.data().size() <= 300);
        const auto content = unwrap(f, us);
        must(content && content->head == TunnelHead{sender, us, 6670});
        again.insert(again.end(), content->inner.begin(), content->inner.end());
    };
    must(tunnel.begin_wrap(0, 300, {sender, 6670}));
    std::vector<std::uint8_t> fits;
    for (InnerFrames frames{taken}; const auto f = frames.next();) {
        tunnel.add_to_wrap(*f, collect);
        if (f->bytes().size() <= 290) fits.insert(fits.end(), f->bytes().begin(), f->bytes().end());
    }
    tunnel.end_wrap(collect);
    must(again == fits);
}

}    // namespace

/// The first byte selects 0xB1 or 0xB2.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    if (size == 0 || size - 1 > ano::max_len) return 0;
    const std::span content{data + 1, size - 1};
    const std::uint8_t id = data[0] % 2 == 0 ? ip_tunnel : ip_tunnel_short;
    std::vector<std::uint8_t> bytes(ano::overhead + content.size());
    ano::encode(bytes, 0xDC, 0xE6, id, content);
    const ano::FrameView frame{bytes};
    const std::size_t head = tunnel_head_size(id);
    const auto whole = content.size() < head ? std::vector<std::uint8_t>{} : whole_frames(content.subspan(head));
    out(frame, whole, Deliver::frames);
    out(frame, whole, Deliver::tunnel);
    in(frame, whole);
    return 0;
}
