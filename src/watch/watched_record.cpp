#include <ano/hex.hpp>
#include <ano/messages.hpp>
#include <config/link_kind.hpp>
#include <link/clocks.hpp>
#include <runtime/gateway.hpp>
#include <watch/watched_record.hpp>

#include <chrono>
#include <utility>

namespace anogate {
namespace {

using Names = std::vector<std::string>;

std::string_view name_numbered(const Names& names, std::size_t number) {
    return number < names.size() ? std::string_view{names[number]} : std::string_view{};
}

RecordedFrame as_recorded(const FrameRecord& record, const Names& links, const Names& peers) {
    const auto causes = frame_causes();
    RecordedFrame frame{.time_ns = record.time_ns,
                        .boottime_ns = record.boottime_ns,
                        .link = name_numbered(links, record.link),
                        .direction = record.direction,
                        .frame = record.frame};
    if (record.direction == Direction::dropped && record.cause < causes.size()) frame.cause = causes[record.cause];
    if (record.channel != FrameRecord::no_channel) {
        frame.channel = record.channel;
        frame.peer = name_numbered(peers, record.channel);
    }
    return frame;
}

std::uint64_t in_nanoseconds(ano::Duration time) {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time).count());
}

}    // namespace

std::size_t RecordedNames::cost() const noexcept {
    std::size_t cost = sizeof *this;
    for (const Names* names : {&links, &kinds, &peers})
        for (const std::string& name : *names) cost += sizeof(std::string) + name.size();
    return cost;
}

RecordedNames recorded_names(const WatchTables& tables, const Gateway& gateway) {
    RecordedNames names{tables.links, Names(tables.links.size()), tables.peers, tables.decoding};
    for (const LinkState& state : gateway.links())
        if (const std::size_t number = index(state.link->id()); number < names.kinds.size())
            names.kinds[number] = state.link->settings().kind->name;
    return names;
}

RecordedFrame as_recorded(const FrameRecord& record, const RecordedNames& names) {
    RecordedFrame frame = as_recorded(record, names.links, names.peers);
    frame.link_description = name_numbered(names.kinds, record.link);
    return frame;
}

RecordedFrame as_recorded(const FrameRecord& record, const WatchTables& tables) {
    return as_recorded(record, tables.links, tables.peers);
}

std::uint64_t count_of_records(std::string_view records) noexcept {
    std::uint64_t count = 0;
    while (next_record(records)) ++count;
    return count;
}

std::string loss_names(const LostFrames& lost) {
    std::string names;
    for (unsigned n = 0; n < lost.by_id.size(); ++n) {
        if (lost.by_id[n] == 0) continue;
        const auto id = static_cast<std::uint8_t>(n);
        const ano::Message* message = ano::find_message(id);
        names += (names.empty() ? "" : ", ") + (message ? std::string{message->name} : ano::hex_byte(id)) + " " +
                 std::to_string(lost.by_id[n]);
    }
    return names;
}

RecordingHead recording_head(DecodingPtr decoding) {
    const ClockReading clocks = read_clocks();
    return {"anogated " ANOGATE_VERSION, in_nanoseconds(clocks.real), in_nanoseconds(clocks.boot), std::move(decoding)};
}

}    // namespace anogate
