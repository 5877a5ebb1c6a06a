// Reads a JSON file, LINK texts and command-line options into Settings, and reports every error. Prints Settings as JSON.
//
// Flow: call read_config() or read_link() any number of times, set options in draft.settings, then call validate(draft).
// draft.settings is usable if draft.errors is empty.
#pragma once
#include <config/config_error.hpp>
#include <config/link_kind.hpp>
#include <gateway/settings.hpp>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// The place of a setting in its source, for errors that are found later.
struct Origin {
    std::string where;
    bool object = false;    // `where` points to a JSON object; otherwise it names a whole text, such as a LINK
    bool broken = false;    // it had errors, so its settings are incomplete

    std::string key(std::string_view name) const { return object ? where + "/" + std::string{name} : where; }
};

/// The configuration read so far.
struct Draft {
    explicit Draft(LinkKinds there_are) : kinds{there_are} {}

    LinkKinds kinds;    // all kinds known to this program
    Settings settings;
    std::vector<Origin> links, routes, aliases, classes, gpio;    // one per entry of the list in `settings`
    Origin unknown;                                               // of settings.gateway.unknown
    Origin tunnel;                                                // of settings.tunnel
    Origin record;                                                // of settings.record
    Origin control, log;                                          // of settings.control and settings.log
    ConfigErrors errors;
    ConfigErrors warnings;                        // allowed, but probably not intended
    std::map<std::string, std::string> set_in;    // key ("/gateway/id") → file, for keys that only one file may set
    bool broken_links = false;                    // a link could not be read, so references to link names can't be checked

    void add(LinkSettings link, Origin origin);
    void add(RouteSettings route, Origin origin);
    void add(GpioSettings line, Origin origin);
    void add(AliasSettings alias, Origin origin);
    void add(const ClassSettings& of_id, Origin origin);
};

/// A path in the settings of a link, its key, the place of the link, and whether the link is enabled.
struct NamedPath {
    LinkPath path;
    std::string_view key;
    Origin origin;
    bool is_enabled;
};
/// The paths of all links that were read without errors.
std::vector<NamedPath> paths_of_links(const Draft& draft);

/// Adds a configuration in JSON (comments allowed). `file` is the prefix of the JSON pointers, "" for none. Links, routes,
/// aliases, classes, GPIO lines and flexible messages of several files are combined; any other key may be set in only one file.
void read_config(std::string_view json, const std::string& file, Draft& draft);

/// Adds a link: KIND:ADDRESS[,KEY=VALUE...]. In errors, `where` precedes the text, "" for none.
void read_link(std::string_view text, const std::string& where, Draft& draft);

/// Adds a route: ADDR=LINK. Errors are at `where`.
void read_route(std::string_view text, const std::string& where, Draft& draft);

/// Assigns names to the links without a name, and checks rules of the whole configuration: duplicate names, ids and ports, routes
/// to links that do not exist.
void validate(Draft& draft);

/// Whether the settings configure the link `control` or refer to it. If so, it exists from the start.
bool is_control_configured(const Settings& settings);

/// Returns the settings as an equivalent JSON configuration; reading it and printing it again returns the same text. `settings`
/// must be valid. Keys without a value (id, dtr, bind...) are omitted.
std::string print_config(const Settings& settings);

/// The JSON Schema (draft 7) of the configuration.
std::string config_schema(LinkKinds kinds);

/// Reads and validates a single configuration text.
Draft parse_config(std::string_view json, LinkKinds kinds, const std::string& file = {});

}    // namespace anogate
