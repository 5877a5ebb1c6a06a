// From a JSON file, LINK texts and command-line options to Settings, with every fault on the way; and back to JSON.
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

/// Where something was said, so that a fault found later still names its place.
struct Origin {
    std::string where;
    bool object = false;    // a JSON object at the pointer `where`; otherwise a whole text that people wrote
    bool broken = false;    // it had errors: what it would have meant is not known

    std::string key(std::string_view name) const { return object ? where + "/" + std::string{name} : where; }
};

/// What was read so far.
struct Draft {
    explicit Draft(LinkKinds there_are) : kinds{there_are} {}

    LinkKinds kinds;    // those that there are
    Settings settings;
    std::vector<Origin> links, routes, aliases, gpio;    // where each of these in the settings was said
    Origin unknown;                                      // where settings.gateway.unknown was said
    Origin tunnel;                                       // where settings.tunnel was said
    Origin record;                                       // where settings.record was said
    Origin control, log;                                 // and these
    ConfigErrors errors;
    ConfigErrors warnings;                         // of what is allowed and may not be meant
    std::map<std::string, std::string> said_in;    // the file that said a key which only one may: "/gateway/id"
    bool broken_links = false;                     // not every link is known: what names one can't be judged

    void add(LinkSettings link, Origin origin);
    void add(RouteSettings route, Origin origin);
    void add(GpioSettings line, Origin origin);
    void add(AliasSettings alias, Origin origin);
};

/// A path that a link names, the key that says it, and where that was said.
struct NamedPath {
    LinkPath path;
    std::string_view key;
    Origin origin;
};
/// Those of every link whose settings are known.
std::vector<NamedPath> paths_of_links(const Draft& draft);

/// Adds a configuration in JSON (comments allowed); `file` is put before the pointers, "" for none. To what other files said before,
/// it adds links, routes, aliases, GPIO lines and flexible messages; any other key may stand in one file alone.
void read_config(std::string_view json, const std::string& file, Draft& draft);

/// Adds a link: KIND:ADDRESS[,KEY=VALUE...]. `where` is put before the text, "" for none.
void read_link(std::string_view text, const std::string& where, Draft& draft);

/// Adds a route: ADDR=LINK. Errors are at `where`.
void read_route(std::string_view text, const std::string& where, Draft& draft);

/// Names the links that were not given a name, and judges what only the whole can tell: names, ids and ports used
/// twice, routes to no link.
void validate(Draft& draft);

/// The settings say something of the link `control`, or name it: it is there from the start.
bool is_control_configured(const Settings& settings);

/// The settings as a JSON configuration that means the same: read and printed again it is the same text.
/// They must be without fault. Keys without a value (id, dtr, bind...) are left out.
std::string print_config(const Settings& settings);

/// The JSON Schema (draft 7) of the configuration.
std::string config_schema(LinkKinds kinds);

/// One configuration text by itself.
Draft parse_config(std::string_view json, LinkKinds kinds, const std::string& file = {});

}    // namespace anogate
