#include <config/link_kind.hpp>
#include <gateway/outbox.hpp>

#include <algorithm>

namespace anogate {

constinit const LinkKind no_link_kind{};

bool may_use_v7(const LinkKind& kind) noexcept {
    return std::any_of(kind.keys.begin(), kind.keys.end(), [](const auto& key) { return key.name == "v7_device"; });
}

bool uses_v7(const LinkSettings& link) {
    const Key<LinkSettings>* const key = find_key(link.kind->keys, "protocol");
    return key != nullptr && key->text_in(link) == "v7";
}

const LinkKind* find_link_kind(LinkKinds kinds, std::string_view name) noexcept {
    for (const LinkKind* kind : kinds)
        if (kind->name == name) return kind;
    return nullptr;
}

LinkSettings new_link(const LinkKind& kind) {
    LinkSettings link;
    link.kind = &kind;
    link.of_kind = kind.settings();
    link.queue = 0;
    return link;
}

Duration hello_interval(const LinkSettings& link) noexcept {
    if (link.kind->replays) return {};
    const bool is_possible = link.accepts_broadcasts() ||
                             link.profile == Profile::old;    // it sends this broadcast to an old device nevertheless
    const bool on = link.profile != Profile::none && !link.kind->listens && is_possible;
    return link.hello.value_or(on ? LinkSettings::usual_hello : Duration{});
}

LineRate line_rate_of(const LinkSettings& link) { return link.kind->line_rate ? link.kind->line_rate(link) : LineRate{}; }

std::size_t flush_bytes_of(const LinkSettings& link) noexcept {
    if (!link.kind->has_uart || !link.kind->has_uart(link)) return 0;
    const std::size_t stated = link.max_data_out ? *link.max_data_out + ano::overhead : Outbox::usual_flush;
    return std::clamp(stated, Outbox::usual_flush, Outbox::max_flush);
}

std::optional<BoundPort> bound_port_of(const LinkSettings& link) {
    return link.kind->bound_port ? link.kind->bound_port(link) : std::nullopt;
}

std::optional<PeerPort> peer_port_of(const LinkSettings& link) {
    return link.kind->connects_to ? link.kind->connects_to(link) : std::nullopt;
}

Duration quiet_of(const LinkKind& kind) noexcept {
    if (kind.over_network) return std::chrono::seconds{1};
    return std::chrono::milliseconds{kind.carries == Carries::datagrams ? 100 : 50};
}

}    // namespace anogate
