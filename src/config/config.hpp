// Reads a JSON file, LINK texts and command-line options into Settings and reports every error; and prints Settings as JSON.
//
// Flow: read_config() or read_link() any number of times, options set in draft.settings, then validate(draft):
// draft.settings is usable when draft.errors is empty.
#pragma once
#include <config/config_error.hpp>
#include <config/link_kind.hpp>
#include <gateway/settings.hpp>

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// Where a setting was written, so that an error found later can name the place.
struct Origin {
    std::string where;
    bool object = false;    // `where` points to a JSON object; otherwise it names a whole text, such as a LINK
    bool broken = false;    // it had errors, so the settings made of it are incomplete

    std::string key(std::string_view name) const { return object ? where + "/" + std::string{name} : where; }
};

/// What was read so far.
struct Draft {
    explicit Draft(LinkKinds there_are) : kinds{there_are} {}

    LinkKinds kinds;    // all that this program knows
    Settings settings;
    std::vector<Origin> links, routes, aliases, classes, gpio;    // one for each entry of the list in `settings`
    Origin unknown;                                               // of settings.gateway.unknown
    Origin tunnel;                                                // of settings.tunnel
    Origin record;                                                // of settings.record
    Origin control, log;                                          // of settings.control and settings.log
    ConfigErrors errors;
    ConfigErrors warnings;                         // what is allowed but is probably not meant
    std::map<std::string, std::string> said_in;    // key ("/gateway/id") → file, of keys that only one file may set
    bool broken_links = false;                     // a link could not be read: whether a name is that of a link can't be checked

    void add(LinkSettings link, Origin origin);
    void add(RouteSettings route, Origin origin);
    void add(GpioSettings line, Origin origin);
    void add(AliasSettings alias, Origin origin);
    void add(const ClassSettings& of_id, Origin origin);
};

/// A path that a link names, the key that holds it, and where that was written.
struct NamedPath {
    LinkPath path;
    std::string_view key;
    Origin origin;
};
/// The paths of every link that was read without errors.
std::vector<NamedPath> paths_of_links(const Draft& draft);

/// Adds a configuration in JSON (comments allowed); `file` is put before the pointers, "" for none. Links, routes, aliases, classes,
/// GPIO lines and flexible messages of several files are added up; any other key may be set in one file only.
void read_config(std::string_view json, const std::string& file, Draft& draft);

/// Adds a link: KIND:ADDRESS[,KEY=VALUE...]. `where` is put before the text, "" for none.
void read_link(std::string_view text, const std::string& where, Draft& draft);

/// Adds a route: ADDR=LINK. Errors are at `where`.
void read_route(std::string_view text, const std::string& where, Draft& draft);

/// Names the links without a name, and checks what depends on the whole configuration: names, ids and ports used twice,
/// routes to no link.
void validate(Draft& draft);

/// Whether the settings configure the link `control` or refer to it: then it exists from the start.
bool is_control_configured(const Settings& settings);

/// The settings as a JSON configuration that means the same; reading it and printing it again gives the same text.
/// `settings` must be valid. Keys without a value (id, dtr, bind...) are left out.
std::string print_config(const Settings& settings);

/// The JSON Schema (draft 7) of the configuration.
std::string config_schema(LinkKinds kinds);

/// One configuration text by itself.
Draft parse_config(std::string_view json, LinkKinds kinds, const std::string& file = {});

}    // namespace anogate
