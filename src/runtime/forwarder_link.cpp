#include <config/link_kind.hpp>
#include <runtime/forwarder_link.hpp>

namespace anogate {

ForwarderLink forwarder_link(const LinkSettings& s, std::uint8_t group, const std::vector<AliasSettings>& aliases) {
    ForwarderLink link;
    const bool takes = !s.kind->replays;
    const bool is_for_programs = s.kind->listens || (s.kind->path != nullptr && s.kind->path(s).is_made);
    link.route = {.port_id = s.id,
                  .flood = takes && s.accepts_floods(),
                  .broadcast = takes && s.accepts_broadcasts(),
                  .group = group,
                  .teaches = takes,
                  .acts_for_others = s.profile == Profile::old,
                  .may_have_devices = takes && !is_for_programs,
                  .drops_copies = !uses_v7(s)};
    // The rate determines when the rest of a frame is overdue.
    link.parser = {s.max_data, line_rate_of(s).bytes_per_second, quiet_of(*s.kind), s.frame_gap.value_or(Duration{})};
    link.outbox = {s.queue, s.effective_max_data_out(), s.age, flush_bytes_of(s)};
    link.rules = s.rules;
    link.limits_questions = s.profile == Profile::vendor;
    link.sends_empty = !link.limits_questions;
    // Probes are never sent to devices, nor to links without broadcasts.
    link.allows_probes = link.route.broadcast && !s.kind->devices_only;
    for (const AliasSettings& alias : aliases)
        if (alias.link == s.name) link.aliases.push_back({alias.device, alias.as});
    link.present_as = s.present_as;
    link.hello = hello_interval(s);
    link.attitude = s.attitude;
    return link;
}

}    // namespace anogate
