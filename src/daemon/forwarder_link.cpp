#include <daemon/forwarder_link.hpp>
#include <gateway/pacer.hpp>

namespace anogate {
namespace {

constexpr Duration datagram_quiet = std::chrono::milliseconds{100};
constexpr Duration stream_quiet = std::chrono::milliseconds{50};

// What the line carries, to know when the rest of a frame is overdue.
std::uint32_t line_rate(const LinkSettings& s) {
    return s.kind == "serial" ? uart_rate(s.serial.baud, s.serial.parity != Parity::none, s.serial.stop_bits) : 0;
}

ano::FrameParser::Options parser_options(const LinkSettings& s) {
    const bool datagrams = s.kind == "udp" || s.kind == "udp-listen" || s.kind == "tunnel";
    return {s.max_data, line_rate(s), datagrams ? datagram_quiet : stream_quiet};
}

// Whether a probe may leave by it: never to devices, nor to those who do not take broadcasts.
bool takes_probes(const LinkSettings& s) { return s.broadcast && s.kind != "serial" && s.kind != "can" && s.kind != "sim"; }

}    // namespace

bool is_stream(const LinkSettings& s) { return s.kind == "serial" || s.kind == "pty"; }

ForwarderLink forwarder_link(const LinkSettings& s, std::uint8_t group, const std::vector<AliasSettings>& aliases) {
    ForwarderLink link;
    link.route = {s.id, s.flood, s.broadcast, group};
    link.parser = parser_options(s);
    link.outbox = {s.queue, s.effective_max_data_out(), s.age};
    link.rules = s.rules;
    link.takes_few_questions = s.profile == Profile::vendor;
    link.sends_empty = !link.takes_few_questions;
    link.takes_probes = takes_probes(s);
    for (const AliasSettings& alias : aliases)
        if (alias.link == s.name) link.aliases.push_back({alias.device, alias.as});
    link.present_as = s.present_as;
    link.hello = s.hello_interval();
    return link;
}

}    // namespace anogate
