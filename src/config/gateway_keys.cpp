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

std::string set_unknown(const KeyFacts&, Value value, GatewaySettings& gateway) {
    auto& text = std::get<std::string>(value);
    gateway.unknown = text == "flood" ? Unknown::flood : text == "drop" ? Unknown::drop : Unknown::link;
    gateway.unknown_link = gateway.unknown == Unknown::link ? std::move(text) : std::string{};
    return {};
}

Value get_addresses(const KeyFacts&, const RouteSettings& route) {
    return route.last == 0 ? Value{} : Value{ByteRange{route.first, route.last}};
}

std::string set_addresses(const KeyFacts&, Value value, RouteSettings& route) {
    const auto range = std::get<ByteRange>(value);
    route.first = range.first;
    route.last = range.last;
    return {};
}

constexpr Key<G> gateway_rows[] = {
    address<&G::id>("id", first_id, last_id, "the hardware id of the gateway itself (default: none)") | by("--id"),
    text<&G::name>("name", 1, max_name, "the gateway's name in the status") | as("NAME"),
    Key<G>{{.name = "unknown",
            .form = Form::choice_or_link,
            .help = "what to do with frames to unknown addresses: flood them, drop them, or send them to one link",
            .min = 1,
            .max = max_name,
            .choices = "flood|drop",
            .option = "--unknown"},
           get_unknown,
           set_unknown},
    duration<&G::forget_after>("forget_after", second, day, "forget an address after this time without frames from it"),
};

Value get_class_id(const KeyFacts&, const ClassSettings& of_id) {
    return of_id.id == 0 ? Value{} : Value{address_text(of_id.id)};
}

std::string set_class_id(const KeyFacts& key, Value value, ClassSettings& of_id) {
    const auto& text = std::get<std::string>(value);
    const auto ids = parse_frames(text);
    if (!ids || ids->size() != 1 || ids->front().first != ids->front().last)
        return must_be(key, in_quotes(text)) + (ids ? ", which covers several" : meant_frames(text));
    const std::uint8_t id = ids->front().first;
    if (!may_have_class(id))
        return in_quotes(text) + " can't have another class: these commands, parameters and answers must all arrive";
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
           set_class_id},
    choice<&F::frame_class>(
        "class", "control|urgent|telemetry|bulk",
        "control: sent first, also before older frames of the same sender, for setpoints; urgent: sent first; "
        "telemetry; bulk: sent last") |
        needed,
    boolean<&F::replaces>("replaces", "a newer frame replaces a waiting one (default: yes for control, otherwise no)"),
    duration<&F::age>("age", 1, day, "drop frames that waited longer (default: the link's limit for the class)"),
};

constexpr Key<A> alias_rows[] = {
    text<&A::link>("link", 1, max_name, "the name of the link of the device") | as("LINK") | needed,
    address<&A::device>("device", 0, 255, "the id that the device uses; also 0x00 and 0xFF") | needed,
    address<&A::as>("as", first_id, last_id, "the id under which everyone else sees it") | needed,
};

constexpr Key<R> route_rows[] = {
    Key<R>{{.name = "address",
            .form = Form::addresses,
            .help = "the address or range to pin",
            .min = first_id,
            .max = last_id,
            .required = true},
           get_addresses,
           set_addresses},
    text<&R::link>("link", 1, max_name, "the name of the link to it") | as("LINK") | needed,
};

using C = ControlSettings;

constexpr Key<C> own_control_rows[] = {
    text<&ControlSettings::socket>("socket", 0, max_socket_path,
                                   "path of the control socket, or none (default: /run/anogate/control.sock, "
                                   "for users $XDG_RUNTIME_DIR/anogate.sock)") |
        as("PATH|none") | by("--control"),
    endpoint<&C::http>("http",
                       "the same interface over TCP, at this address (default: off); requests from the network need a token") |
        local | by("--http"),
    text<&C::token_file>(
        "token_file", 0, max_path,
        "file with lines 'view TOKEN' and 'control TOKEN', created if missing (default: /var/lib/anogate/token, for users "
        "~/.local/state/anogate/token)") |
        as("PATH"),
    row<&C::hosts>({.name = "hosts",
                    .form = Form::texts,
                    .help = "host names accepted over TCP, besides the name and addresses of this computer",
                    .min = 1,
                    .max = max_host}),
    row<&C::origins>(
        {.name = "origins",
         .form = Form::texts,
         .help = "origins of other web pages that may use it, such as https://app.foxglove.dev or file://; null is never allowed",
         .min = 1,
         .max = max_path}),
    address<&C::host>("host", first_id, last_id,
                      "the address that the gateway uses as a host for requests to devices, such as for parameters"),
    boolean<&C::manage>("manage", "clients may configure and command the gateway itself as a device, if it has an id"),
    text<&C::tls, &TlsFiles::certificate>("tls.certificate", 0, max_path, "encrypts TCP: the certificate, a PEM file") |
        as("PATH"),
    text<&C::tls, &TlsFiles::key>("tls.key", 0, max_path, "the private key, a PEM file without a password") | as("PATH"),
    text<&C::map, &MapSettings::file>("map.file", 0, max_path, "map for the page: a .pmtiles file with raster tiles") |
        as("PATH"),
    choice<&C::map, &MapSettings::datum>("map.datum", "wgs84|gcj02",
                                         "the coordinate system of its tiles: gcj02 for maps made in China"),
};

constexpr auto control_rows = own_control_rows + rules_of<ControlSettings, &ControlSettings::rules>();

constexpr Key<LogSettings> log_rows[] = {
    choice<&LogSettings::level>("level", "trace|debug|info|warn|error", "the lowest level to log") | by("--log-level"),
    text<&LogSettings::file>("file", 0, max_path, "the log file (default: standard error)") | as("PATH"),
    size<&LogSettings::rotate>("rotate", "rotate the log file at this size; 0: never"),
};

}    // namespace

Keys<GatewaySettings> gateway_keys() noexcept { return gateway_rows; }
Keys<RouteSettings> route_keys() noexcept { return route_rows; }
Keys<AliasSettings> alias_keys() noexcept { return alias_rows; }
Keys<ClassSettings> class_keys() noexcept { return class_rows; }
Keys<ControlSettings> control_keys() noexcept { return control_rows; }
Keys<LogSettings> log_keys() noexcept { return log_rows; }

}    // namespace anogate
