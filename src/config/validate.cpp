#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano_json/nearest.hpp>
#include <config/check_network.hpp>
#include <config/config.hpp>
#include <config/link_kind.hpp>
#include <config/values.hpp>
#include <gateway/ids.hpp>

#include <algorithm>
#include <set>

namespace anogate {
namespace {

constexpr std::uint64_t slow_frame = 100;    // ms

// Words with a special meaning in place of a link name, and the gateway's built-in links.
constexpr std::string_view reserved_names[] = {"flood", "drop", "none", "tunnel", "control"};

bool is_reserved(std::string_view name) {
    return std::find(std::begin(reserved_names), std::end(reserved_names), name) != std::end(reserved_names);
}

bool is_number(const std::string& line) { return parse_number(line).has_value(); }

/// The default name, not yet made unique.
std::string usual_name(const LinkSettings& link) {
    constexpr std::size_t max_length = 60;    // max_name minus room for the suffix "-64"
    const std::string name = link.kind->usual_name ? link.kind->usual_name(link) : "";
    return name.empty() || name.size() > max_length ? std::string{link.kind->name} : name;
}

void name_links(std::vector<LinkSettings>& links) {
    std::set<std::string> taken{std::begin(reserved_names), std::end(reserved_names)};
    for (const LinkSettings& link : links) taken.insert(link.name);
    for (LinkSettings& link : links) {
        if (!link.name.empty()) continue;
        const std::string usual = usual_name(link);
        link.name = usual;
        for (int n = 2; taken.contains(link.name); ++n) link.name = usual + "-" + std::to_string(n);
        taken.insert(link.name);
    }
}

/// 32 KiB, or room for two frames if that is more.
std::uint32_t default_queue(std::size_t max_data) {
    const std::uint32_t usual = LinkSettings{}.queue;
    return std::max(usual, static_cast<std::uint32_t>(2 * (ano::overhead + max_data)));
}

bool collide(const BoundPort& one, const BoundPort& other) {
    const EndpointSpec &a = one.local, &b = other.local;
    if (one.is_tcp != other.is_tcp || a.port == 0 || a.port != b.port) return false;
    if (!one.interface.empty() && !other.interface.empty() && one.interface != other.interface) return false;
    if (a.address.v6 != b.address.v6) return (a.address.v6 ? a : b).address.is_any();    // [::] receives IPv4 too
    return a == b || a.address.is_any() || b.address.is_any();
}

/// Adds errors and warnings of one link to the draft.
class Faults final : public LinkFaults {
public:
    Faults(Draft& draft, const Origin& origin) : draft_{draft}, origin_{origin} {}
    bool is_whole() const override { return !origin_.broken; }
    void error(std::string_view key, std::string what) override { draft_.errors.push_back({origin_.key(key), std::move(what)}); }
    void warning(std::string_view key, const std::string& what) override {
        draft_.warnings.push_back({origin_.key(key), "warning: " + what});
    }

private:
    Draft& draft_;
    const Origin& origin_;
};

class Validation {
public:
    explicit Validation(Draft& draft) : draft_{draft}, links_{draft.settings.links} {}

    void all() {
        for (std::size_t i = 0; i < links_.size(); ++i) {
            link(i);
            Faults faults{draft_, draft_.links[i]};
            if (const LinkKind& kind = *links_[i].kind; kind.validate) kind.validate(links_[i], faults);
            for (std::size_t k = 0; k < i; ++k) pair(k, i);
        }
        groups();
        gateway();
        for (std::size_t i = 0; i < draft_.settings.routes.size(); ++i) route(draft_.settings.routes[i], draft_.routes[i]);
        for (std::size_t i = 0; i < draft_.settings.aliases.size(); ++i) alias(i);
        for (std::size_t i = 0; i < draft_.settings.classes.size(); ++i) frame_class(i);
        if (draft_.settings.tunnel) tunnel(*draft_.settings.tunnel);
        control(draft_.settings.control);
        if (draft_.settings.record) record(*draft_.settings.record);
        for (std::size_t i = 0; i < draft_.settings.gpio.size(); ++i)
            if (!draft_.gpio[i].broken) gpio(i);
    }

private:
    void error(const Origin& origin, std::string_view key, std::string what) {
        draft_.errors.push_back({origin.key(key), std::move(what)});
    }
    void warning(std::string where, const std::string& what) {
        draft_.warnings.push_back({std::move(where), "warning: " + what});
    }
    /// The link in an error text: its name, and its place in the configuration.
    std::string who(std::size_t i) const { return in_quotes(links_[i].name) + " (" + draft_.links[i].where + ")"; }

    void link(std::size_t i) {
        const LinkSettings& link = links_[i];
        const std::size_t min_queue = ano::overhead + link.effective_max_data_out();
        if (is_reserved(link.name))
            error(draft_.links[i], "name", "'name' can't be " + in_quotes(link.name) + ", a reserved word");
        if (link.queue < min_queue)
            error(draft_.links[i], "queue",
                  "'queue' must be at least max_data_out + 8, here " + std::to_string(min_queue) + ", to hold one frame, not " +
                      std::to_string(link.queue));
        if (link.id != 0 && link.id == draft_.settings.gateway.id)
            error(draft_.links[i], "id", "'id' " + std::to_string(link.id) + " is the gateway's own id");
        for (std::size_t k = 0; k < links_.size(); ++k) ids_of(i, k);
        hello(i);
        slow_line(i);
    }

    // Checks the addresses in the settings of `link` against the port id of `other`.
    void ids_of(std::size_t link, std::size_t other) {
        const std::uint8_t id = links_[other].id;
        if (id == 0) return;
        if (links_[link].present_as == id)
            error(draft_.links[link], "present_as", "'present_as' " + address_text(id) + " is the port id of " + who(other));
        if (link == other) return;
        for (const ByteRange& range : links_[link].rules.receive.allow_sources)
            if (range.first <= id && id <= range.last && ano::address::is_port_id(range.last))
                warning(draft_.links[link].key("receive/allow_sources"),
                        "a device with the address " + std::to_string(id) + " can't be reached: it is also the port id of " +
                            who(other) + ", and frames to it go there; change one of them");
    }

    void hello(std::size_t i) {
        const LinkSettings& link = links_[i];
        if (!link.hello || *link.hello == Duration{} || link.kind->listens) return;
        if (!link.accepts_broadcasts() && link.profile != Profile::old)
            warning(draft_.links[i].key("hello"),
                    "'hello' has no effect: it is a broadcast frame (0xFF), which broadcast=no keeps off this link");
    }

    // Urgent frames must wait for a frame that is already being sent.
    void slow_line(std::size_t i) {
        const LinkSettings& link = links_[i];
        std::uint32_t rate = link.rate;
        if (const LineRate line = line_rate_of(link); rate == 0 && line.is_kept) rate = line.bytes_per_second;
        if (rate == 0) return;
        const std::uint64_t milliseconds = (ano::overhead + link.effective_max_data_out()) * std::uint64_t{1000} / rate;
        if (milliseconds <= slow_frame) return;
        const std::uint64_t fits = rate * slow_frame / 1000;
        const std::string limit = std::to_string(slow_frame) + " ms";
        const std::string bound = "max_data_out";    // max_data would also refuse received frames
        warning(draft_.links[i].key(bound),
                "a frame of " + bound + " " + std::to_string(link.effective_max_data_out()) + " takes " +
                    std::to_string(milliseconds) + " ms at " + std::to_string(rate) +
                    " bytes/s, and urgent frames have to wait for it; " +
                    (fits < ano::overhead ? "even a frame without DATA takes more than " + limit
                                          : bound + " " + std::to_string(fits - ano::overhead) + " keeps this below " + limit));
    }

    void pair(std::size_t first, std::size_t second) {
        const LinkSettings& a = links_[first];
        const LinkSettings& b = links_[second];
        const Origin& origin = draft_.links[second];
        if (!a.name.empty() && a.name == b.name)
            error(origin, "name", "'name' " + in_quotes(b.name) + " is already the name of " + draft_.links[first].where);
        if (b.id != 0 && a.id == b.id)
            error(origin, "id", "'id' " + std::to_string(b.id) + " is already the port id of " + who(first));
        if (const auto shared = a.kind == b.kind && a.kind->shared ? a.kind->shared(a, b) : std::nullopt)
            error(origin, shared->key, shared->what + who(first) + shared->rest);
        const auto bound_a = bound_port_of(a), bound_b = bound_port_of(b);
        if (bound_a && bound_b && collide(*bound_a, *bound_b))
            error(origin, bound_b->key,
                  "local port " + std::to_string(bound_b->local.port) + " is already used by " + who(first));
    }

    void groups() {
        for (std::size_t i = 0; i < links_.size(); ++i) {
            for (std::size_t k = 0; k < i; ++k) {
                if (links_[i].group.empty() || links_[k].group != links_[i].group) continue;
                const auto differs = [&](const char* key) {
                    error(draft_.links[i], key,
                          in_quotes(key) + " must be the same on all links of a group, but differs on " + who(k));
                };
                if (links_[k].present_as != links_[i].present_as) differs("present_as");
                if (links_[k].manage != links_[i].manage) differs("manage");    // otherwise the first copy would decide
            }
            const std::string& group = links_[i].group;
            const auto in_group = [&](const LinkSettings& link) { return link.group == group; };
            if (!group.empty() && std::count_if(links_.begin(), links_.end(), in_group) == 1)
                warning(draft_.links[i].key("group"), in_quotes(links_[i].name) + " is the only link in the group " +
                                                          in_quotes(group) + ": the group has no effect");
        }
    }

    void gateway() {
        const GatewaySettings& gateway = draft_.settings.gateway;
        if (links_.empty() && draft_.errors.empty())
            warning("", "the configuration has no links, so no frames will be forwarded");
        if (ano::address::is_host(gateway.id))
            warning("",
                    "the gateway's own id " + address_text(gateway.id) +
                        " is the address of hosts: the gateway would consume frames to hosts; choose another id, such as 199");
        if (gateway.unknown == Unknown::link) must_exist(gateway.unknown_link, draft_.unknown, "unknown", {"flood", "drop"});
    }

    void route(const RouteSettings& route, const Origin& origin) {
        must_exist(route.link, origin, "link");
        const auto covers = [&](std::uint8_t id) { return id != 0 && route.first <= id && id <= route.last; };
        if (const std::uint8_t id = draft_.settings.gateway.id; covers(id))
            error(
                origin, "address",
                "'address' " + addresses_text({route.first, route.last}) + ": " + address_text(id) + " is the gateway's own id");
        for (std::size_t i = 0; i < links_.size(); ++i)
            if (covers(links_[i].id))
                error(origin, "address",
                      "'address' " + addresses_text({route.first, route.last}) + ": " + std::to_string(links_[i].id) +
                          " is the port id of " + who(i) + ", and frames to it go there");
    }

    void alias(std::size_t i) {
        const AliasSettings& alias = draft_.settings.aliases[i];
        const Origin& origin = draft_.aliases[i];
        const std::string as = "'as' " + address_text(alias.as);
        must_exist(alias.link, origin, "link", {}, false);
        if (alias.as == alias.device) error(origin, "as", as + " is already the id of the device");
        if (alias.as == draft_.settings.gateway.id) error(origin, "as", as + " is the gateway's own id");
        if (ano::address::is_host(alias.as) || ano::address::is_host(alias.device))
            error(origin, "as", "a host (0xFE, 0xD2) can't have an alias or be one, because there may be several");
        for (std::size_t k = 0; k < links_.size(); ++k)
            if (links_[k].id == alias.as) error(origin, "as", as + " is the port id of " + who(k));
        for (std::size_t k = 0; k < i; ++k) {
            const AliasSettings& other = draft_.settings.aliases[k];
            if (other.as == alias.as) error(origin, "as", as + " is also used at " + draft_.aliases[k].where);
            if (other.link == alias.link) aliases_of_a_link(alias, origin, other, " (" + draft_.aliases[k].where + ")");
        }
    }

    void frame_class(std::size_t i) {
        const std::uint8_t id = draft_.settings.classes[i].id;
        for (std::size_t k = 0; k < i; ++k)
            if (draft_.settings.classes[k].id == id)
                error(draft_.classes[i], "id", "'id' " + address_text(id) + " already has a class at " + draft_.classes[k].where);
    }

    void aliases_of_a_link(const AliasSettings& alias, const Origin& origin, const AliasSettings& other,
                           const std::string& there) {
        const std::string device = "'device' " + address_text(alias.device);
        if (other.device == alias.device)
            error(origin, "device", device + " already has the alias " + address_text(other.as) + there);
        else if (other.as == alias.device)
            error(origin, "device", device + " is the alias of " + address_text(other.device) + there + ": use 'as' there");
        else if (other.device == alias.as)
            error(origin, "as",
                  "'as' " + address_text(alias.as) + " is the id of a device on this link that itself has an alias" + there);
    }

    void tunnel(const TunnelSettings& tunnel) {
        for (std::size_t i = 0; i < tunnel.links.size(); ++i)
            must_exist(tunnel.links[i], draft_.tunnel, "links/" + std::to_string(i), {}, false);
        for (std::size_t i = 0; i < tunnel.wrap.size(); ++i)
            if (!tunnel.wrap[i].link.empty())
                must_exist(tunnel.wrap[i].link, draft_.tunnel, "wrap/" + std::to_string(i) + "/link", {}, false);
        if (tunnel.links.empty() && tunnel.wrap.empty())
            warning(draft_.tunnel.key("links"), "no tunnel frames are carried: add the links of the devices");
        for (std::size_t i = 0; i < links_.size(); ++i)
            if (const auto bound = bound_port_of(links_[i]);
                bound && collide(*bound, {EndpointSpec{{tunnel.bind, tunnel.port}}, {}, {}}))
                error(draft_.tunnel, "port", "local port " + std::to_string(tunnel.port) + " is already used by " + who(i));
    }

    void record(const RecordSettings& record) {
        if (record.format != "mcap" && record.message_encoding != "cdr")
            warning(draft_.record.key("message_encoding"), "'message_encoding' has no effect on the format " + record.format +
                                                               ": set 'format' to \"mcap\", the only one with decoded messages");
        for (std::size_t i = 0; i < record.links.size(); ++i)
            must_exist(record.links[i], draft_.record, "link/" + std::to_string(i), {}, true);
        if (record.keep_size != 0 && record.keep_size < record.rotate_size)
            warning(draft_.record.key("keep/size"),
                    "'keep.size' is smaller than 'rotate.size', " + size_text(record.rotate_size) +
                        ": only finished files are deleted, so the current one can exceed it; set a smaller 'rotate.size'");
        if (record.keep_free != 0 && record.keep_free < record.free)
            error(draft_.record, "keep/free",
                  "'keep.free' must be at least 'free', " + size_text(record.free) +
                      ": otherwise recording stops before old files are deleted");
    }

    void control(const ControlSettings& control) {
        const Origin& origin = draft_.control;
        if (control.tls.certificate.empty() != control.tls.key.empty())
            error(origin, control.tls.key.empty() ? "tls/key" : "tls/certificate", "'tls' needs both 'certificate' and 'key'");
        for (std::size_t i = 0; i < control.origins.size(); ++i)
            if (const std::string& page = control.origins[i];
                !page.starts_with("http://") && !page.starts_with("https://") && page != "file://")
                error(origin, "origins/" + std::to_string(i),
                      in_quotes(page) + " must begin with http:// or https://, as sent by a browser, or be file://");
        for (std::size_t i = 0; control.http && i < links_.size(); ++i) {
            const BoundPort page{*control.http, {}, {}, true};
            if (const auto bound = bound_port_of(links_[i]); bound && collide(*bound, page))
                error(origin, "http", "local port " + std::to_string(control.http->port) + " is already used by " + who(i));
        }
        if (control.http && !control.http->address.is_loopback() && control.tls.key.empty())
            draft_.warnings.push_back({origin.key("http"),
                                       "note: without 'tls' other hosts on the local networks can read the tokens in transit; "
                                       "\"127.0.0.1:PORT\" with ssh -L needs no TLS"});
    }

    void gpio(std::size_t i) {
        const GpioSettings& line = draft_.settings.gpio[i];
        const Origin& origin = draft_.gpio[i];
        if (line.chip.empty() && is_number(line.line))
            error(origin, "line", "'line' " + line.line + " is a number: 'chip' must name its chip");
        if (!line.link.empty()) must_exist(line.link, origin, "link");
        for (std::size_t k = 0; k < line.links.size(); ++k) must_exist(line.links[k], origin, "links/" + std::to_string(k));
        if (line.link.empty() && line.links.empty()) gpio_without_link(line, origin);
        if (line.use == GpioUse::rs485) rs485(line, origin);
        for (std::size_t k = 0; k < i; ++k) {
            const GpioSettings& other = draft_.settings.gpio[k];
            if (other.chip == line.chip && other.line == line.line)
                error(origin, "line", "'line' " + in_quotes(line.line) + " is already used by " + draft_.gpio[k].where);
            else if (line.use == GpioUse::rs485 && other.use == line.use && other.link == line.link)
                error(origin, "link",
                      "'link' " + in_quotes(line.link) + " already has a line for rs485 at " + draft_.gpio[k].where);
        }
    }

    void gpio_without_link(const GpioSettings& line, const Origin& origin) {
        const auto missing = [&](const char* what) { draft_.errors.push_back({origin.where, what}); };
        if (line.use == GpioUse::inhibit) missing("'links' is missing: the links whose control frames to block");
        else if (line.use == GpioUse::reset && line.silent_for) missing("'link' is missing: the link to monitor for silence");
        else if (line.use != GpioUse::reset && line.use != GpioUse::power) missing("'link' is missing: the name of the link");
    }

    // The driver may control the transceiver by RTS, so the RTS line must be unused.
    void rs485(const GpioSettings& line, const Origin& origin) {
        const auto link = std::find_if(links_.begin(), links_.end(), [&](const LinkSettings& l) { return l.name == line.link; });
        if (link == links_.end() && line.link != "tunnel" && line.link != "control") return;
        if (link == links_.end() || !link->kind->rs485)
            error(origin, "link", "'link' " + in_quotes(line.link) + " is not a serial port: rs485 needs one");
        else if (const std::string fault = link->kind->rs485->fault(*link); !fault.empty())
            error(origin, "link", "'link' " + in_quotes(line.link) + " " + fault);
    }

    /// `words`: allowed values besides names of links.
    void must_exist(const std::string& name, const Origin& origin, std::string_view key,
                    std::initializer_list<std::string_view> words = {}, bool or_tunnel = true) {
        if (or_tunnel && ((draft_.settings.tunnel && name == "tunnel") || name == "control")) return;
        std::vector<std::string_view> names;
        std::string listed, others;
        for (const LinkSettings& link : links_) {
            names.push_back(link.name);
            listed += (listed.empty() ? "" : ", ") + link.name;
        }
        if (draft_.broken_links || std::find(names.begin(), names.end(), name) != names.end()) return;
        std::vector<std::string_view> meant{words};
        meant.insert(meant.end(), names.begin(), names.end());
        for (const std::string_view word : words) others += std::string{word} + ", ";
        std::string what = "there is no link " + in_quotes(name) + ano::did_you_mean(name, meant);
        if (!others.empty()) others += "or ";
        if (!meant.empty()) what += "; use " + others + (names.empty() ? "a link" : "one of " + listed);
        error(origin, key, std::move(what));
    }

    Draft& draft_;
    const std::vector<LinkSettings>& links_;
};

}    // namespace

bool is_control_configured(const Settings& settings) {
    const std::string_view control = "control";
    return settings.control.rules != RuleSettings{} || settings.gateway.unknown_link == control ||
           std::any_of(settings.routes.begin(), settings.routes.end(),
                       [&](const auto& route) { return route.link == control; }) ||
           std::any_of(settings.gpio.begin(), settings.gpio.end(), [&](const GpioSettings& line) {
               return line.link == control || std::find(line.links.begin(), line.links.end(), control) != line.links.end();
           });
}

std::vector<NamedPath> paths_of_links(const Draft& draft) {
    std::vector<NamedPath> paths;
    for (std::size_t i = 0; i < draft.settings.links.size(); ++i) {
        const LinkSettings& link = draft.settings.links[i];
        if (draft.links[i].broken || !link.kind->path) continue;
        paths.push_back({link.kind->path(link), link.kind->address, draft.links[i], link.enabled});
    }
    return paths;
}

void Draft::add(LinkSettings link, Origin origin) {
    broken_links = broken_links || origin.broken;
    if (!link.kind) link.kind = &no_link_kind;
    settings.links.push_back(std::move(link));
    links.push_back(std::move(origin));
}

void Draft::add(RouteSettings route, Origin origin) {
    settings.routes.push_back(std::move(route));
    routes.push_back(std::move(origin));
}

void Draft::add(GpioSettings line, Origin origin) {
    settings.gpio.push_back(std::move(line));
    gpio.push_back(std::move(origin));
}

void Draft::add(AliasSettings alias, Origin origin) {
    settings.aliases.push_back(std::move(alias));
    aliases.push_back(std::move(origin));
}

void Draft::add(const ClassSettings& of_id, Origin origin) {
    settings.classes.push_back(of_id);
    classes.push_back(std::move(origin));
}

void validate(Draft& draft) {
    std::vector<LinkSettings>& links = draft.settings.links;
    const std::size_t max_configured = max_links - (draft.settings.tunnel ? 1 : 0) -
                                       (is_control_configured(draft.settings) ? 1 : 0);
    if (links.size() > max_configured) {
        const Origin& first_above = draft.links[max_configured];
        draft.errors.push_back({first_above.where, std::to_string(links.size()) + " links; at most " +
                                                       std::to_string(max_configured) + " are supported"});
        return;
    }
    name_links(links);
    for (LinkSettings& link : links)
        if (link.queue == 0) link.queue = default_queue(link.effective_max_data_out());
    Validation{draft}.all();
    check_peers(draft);
    check_relay(draft);
    check_channels(draft);
}

}    // namespace anogate
