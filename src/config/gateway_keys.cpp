// The keys of the short sections: gateway, routes, alias, classes, control, log.
#include <config/frame_words.hpp>
#include <config/rule_keys.hpp>
#include <config/values.hpp>

namespace anogate {
namespace {

using namespace key_rows;
using G = GatewaySettings;
using R = RouteSettings;
using A = AliasSettings;
using F = ClassSettings;

constexpr std::uint64_t max_socket_path = 107, max_host = 253;

Value get_unknown(const KeyFacts&, const GatewaySettings& gateway) {
    if (gateway.unknown == Unknown::link) return gateway.unknown_link;
    return std::string{gateway.unknown == Unknown::flood ? "flood" : "drop"};
}

std::string put_unknown(const KeyFacts&, Value value, GatewaySettings& gateway) {
    auto& text = std::get<std::string>(value);
    gateway.unknown = text == "flood" ? Unknown::flood : text == "drop" ? Unknown::drop : Unknown::link;
    gateway.unknown_link = gateway.unknown == Unknown::link ? std::move(text) : std::string{};
    return {};
}

Value get_addresses(const KeyFacts&, const RouteSettings& route) {
    return route.last == 0 ? Value{} : Value{ByteRange{route.first, route.last}};
}

std::string put_addresses(const KeyFacts&, Value value, RouteSettings& route) {
    const auto range = std::get<ByteRange>(value);
    route.first = range.first;
    route.last = range.last;
    return {};
}

constexpr Key<G> gateway_rows[] = {
    address<&G::id>("id", first_id, last_id, "the gateway's own hardware id (default: none)") | by("--id"),
    text<&G::name>("name", 1, max_name, "the gateway's name in the status") | as("NAME"),
    Key<G>{{.name = "unknown",
            .form = Form::choice_or_link,
            .help = "frames to an address that nobody has used: flood them, drop them, or the one link they go to",
            .min = 1,
            .max = max_name,
            .choices = "flood|drop",
            .option = "--unknown"},
           get_unknown,
           put_unknown},
    duration<&G::forget_after>("forget_after", second, day, "an address not heard for so long is forgotten"),
};

Value get_class_id(const KeyFacts&, const ClassSettings& of_id) {
    return of_id.id == 0 ? Value{} : Value{address_text(of_id.id)};
}

std::string put_class_id(const KeyFacts& key, Value value, ClassSettings& of_id) {
    const auto& text = std::get<std::string>(value);
    const auto ids = parse_frames(text);
    if (!ids || ids->size() != 1 || ids->front().first != ids->front().last)
        return must_be(key, in_quotes(text)) + (ids ? ", which is several" : meant_frames(text));
    const std::uint8_t id = ids->front().first;
    if (!may_have_class(id))
        return in_quotes(text) + " can't have another class: each of these commands, parameters and answers must arrive";
    of_id.id = id;
    return {};
}

constexpr Key<F> class_rows[] = {
    Key<F>{{.name = "id",
            .form = Form::text,
            .help = "the id of the frames, such as 0xF5, or the name of the message",
            .min = 1,
            .max = max_name,
            .stands_for = "ID",
            .required = true},
           get_class_id,
           put_class_id},
    choice<&F::frame_class>("class", "control|urgent|telemetry|bulk",
                            "control: sent first and before older frames of its sender, for setpoints; urgent: sent first; "
                            "telemetry; bulk: sent last") |
        needed,
    boolean<&F::replaces>("replaces", "a newer frame replaces the one that waits (default: yes for control, otherwise no)"),
    duration<&F::age>("age", 1, day, "frames that waited longer are dropped (default: the link's limit for the class)"),
};

constexpr Key<A> alias_rows[] = {
    text<&A::link>("link", 1, max_name, "the name of the link that the device is behind") | as("LINK") | needed,
    address<&A::device>("device", 0, 255, "the id that the device has; also 0x00 and 0xFF") | needed,
    address<&A::as>("as", first_id, last_id, "the id under which all others see it") | needed,
};

constexpr Key<R> route_rows[] = {
    Key<R>{{.name = "address",
            .form = Form::addresses,
            .help = "the address or range to pin",
            .min = first_id,
            .max = last_id,
            .required = true},
           get_addresses,
           put_addresses},
    text<&R::link>("link", 1, max_name, "the name of the link that leads there") | as("LINK") | needed,
};

using C = ControlSettings;

constexpr Key<C> own_control_rows[] = {
    text<&ControlSettings::socket>("socket", 0, max_socket_path,
                                   "path of the control socket, or none (default: /run/anogate/control.sock, "
                                   "for users $XDG_RUNTIME_DIR/anogate.sock)") |
        as("PATH|none") | by("--control"),
    endpoint<&C::http>("http",
                       "the same interface over TCP, at this address (default: off); who asks from the network needs a token") |
        local | by("--http"),
    text<&C::token_file>("token_file", 0, max_path,
                         "lines 'view TOKEN' and 'control TOKEN', made when missing (default: /var/lib/anogate/token, for users "
                         "~/.local/state/anogate/token)") |
        as("PATH"),
    row<&C::hosts>({.name = "hosts",
                    .form = Form::texts,
                    .help = "names under which it is asked over TCP, beside the host's own name and address",
                    .min = 1,
                    .max = max_host}),
    row<&C::origins>(
        {.name = "origins",
         .form = Form::texts,
         .help = "origins of other pages that may ask it, such as https://app.foxglove.dev or file://; null never may",
         .min = 1,
         .max = max_path}),
    address<&C::host>("host", first_id, last_id, "the address of the host that asks devices for parameters and all else"),
    boolean<&C::manage>("manage", "who asks by it may change the gateway itself as a device, where it has an id"),
    text<&C::tls, &TlsFiles::certificate>("tls.certificate", 0, max_path, "TCP is encrypted: the certificate, a PEM file") |
        as("PATH"),
    text<&C::tls, &TlsFiles::key>("tls.key", 0, max_path, "and its key, a PEM file without a password") | as("PATH"),
    text<&C::map, &MapSettings::file>("map.file", 0, max_path,
                                      "raster tiles that the page shows under a track, a .pmtiles file") |
        as("PATH"),
    choice<&C::map, &MapSettings::datum>("map.datum", "wgs84|gcj02",
                                         "the coordinates that its tiles are drawn in: gcj02 for maps made in China"),
};

constexpr auto control_rows = own_control_rows + rules_of<ControlSettings, &ControlSettings::rules>();

constexpr Key<LogSettings> log_rows[] = {
    choice<&LogSettings::level>("level", "trace|debug|info|warn|error", "what is logged") | by("--log-level"),
    text<&LogSettings::file>("file", 0, max_path, "where to (default: standard error)") | as("PATH"),
    size<&LogSettings::rotate>("rotate", "a log file of this size is put aside and a new one begun; 0: never"),
};

}    // namespace

Keys<GatewaySettings> gateway_keys() noexcept { return gateway_rows; }
Keys<RouteSettings> route_keys() noexcept { return route_rows; }
Keys<AliasSettings> alias_keys() noexcept { return alias_rows; }
Keys<ClassSettings> class_keys() noexcept { return class_rows; }
Keys<ControlSettings> control_keys() noexcept { return control_rows; }
Keys<LogSettings> log_keys() noexcept { return log_rows; }

}    // namespace anogate
