#include <ano/wire.hpp>
#include <record/mcap/mcap_reader.hpp>
#include <record/pcapng_format.hpp>
#include <record/pcapng_reader.hpp>
#include <record/recording_glance.hpp>

#include <algorithm>
#include <variant>

namespace anogate {
namespace {

using namespace pcapng;

constexpr std::size_t block_ends = 12;    // type, and the length twice

template <class T>
T loaded_at(std::string_view bytes, std::size_t at) {
    return ano::load<T>(reinterpret_cast<const std::uint8_t*>(bytes.data()) + at);
}

/// Removes the last block from `bytes` and returns it; std::nullopt: no block ends there.
std::optional<std::string_view> pop_last_block(std::string_view& bytes) {
    if (bytes.size() < block_ends) return std::nullopt;
    const auto size = loaded_at<std::uint32_t>(bytes, bytes.size() - 4);
    if (size < block_ends || size % 4 != 0 || size > bytes.size()) return std::nullopt;
    const std::string_view block = bytes.substr(bytes.size() - size);
    if (loaded_at<std::uint32_t>(block, 4) != size) return std::nullopt;
    bytes.remove_suffix(size);
    return block;
}

constexpr std::size_t before_times = 8 + 4,
                      behind_times = before_times + 8;    // in blocks of frames and of statistics: type, length, interface

/// 0: the block has no time.
std::uint64_t time_of(std::string_view block) {
    if (block.size() < behind_times + 4) return 0;
    return std::uint64_t{loaded_at<std::uint32_t>(block, before_times)} << 32 | loaded_at<std::uint32_t>(block, before_times + 4);
}

/// The value of the option `wanted`; the options of the block begin at `at`. 0: not found.
std::uint64_t number_among_options(std::string_view block, std::size_t at, std::uint16_t wanted) {
    if (at + 4 > block.size()) return 0;
    std::string_view options = block.substr(at, block.size() - at - 4);
    while (options.size() >= 4) {
        const auto code = loaded_at<std::uint16_t>(options, 0), size = loaded_at<std::uint16_t>(options, 2);
        const std::size_t whole = 4 + (std::size_t{size} + 3) / 4 * 4;
        if (code == opt_end || whole > options.size()) break;
        if (code == wanted && size == sizeof(std::uint64_t)) return loaded_at<std::uint64_t>(options, 4);
        options.remove_prefix(whole);
    }
    return 0;
}

/// The boot time of a frame; 0: the block is not a frame, or has none.
std::uint64_t boottime_of(std::string_view block) {
    constexpr std::size_t at_size = behind_times, at_bytes = at_size + 8;
    if (block.size() < at_bytes + 4 || loaded_at<std::uint32_t>(block, 0) != enhanced_packet) return 0;
    const std::size_t bytes = loaded_at<std::uint32_t>(block, at_size);
    return bytes > block.size() ? 0 : number_among_options(block, at_bytes + (bytes + 3) / 4 * 4, opt_boottime);
}

/// The time of a frame: ns since 1970, and ns since the computer was started; 0: not known.
struct Passed {
    std::uint64_t time = 0, boottime = 0;
};
std::optional<double> seconds_between(const Passed& first, const Passed& last) {
    const bool has_boottime = first.boottime > 0 && last.boottime >= first.boottime;
    if (has_boottime) return static_cast<double>(last.boottime - first.boottime) / 1e9;
    if (first.time == 0 || last.time < first.time) return std::nullopt;
    return static_cast<double>(last.time - first.time) / 1e9;
}

// Little-endian files only, as the gateway writes them.
RecordingGlance glance_at_pcapng(std::string_view first, std::string_view last) {
    RecordingGlance glance;
    PcapngReader reader;
    reader.feed(first);
    std::optional<Passed> begin;
    while (const auto item = reader.next())
        if (const auto* const frame = std::get_if<RecordedFrame>(&*item); frame && !begin)
            begin = Passed{frame->time_ns, frame->boottime_ns};
    if (reader.position() > 0) glance.head = reader.head();
    std::uint64_t frames = 0;
    Passed end;
    while (const auto block = pop_last_block(last)) {
        if (loaded_at<std::uint32_t>(*block, 0) != interface_statistics) {
            end.boottime = boottime_of(*block);
            break;
        }
        glance.is_ended = true;
        end.time = std::max(end.time, time_of(*block));
        frames += number_among_options(*block, behind_times, isb_ifrecv);
    }
    if (glance.is_ended) glance.frames = frames;
    if (glance.is_ended && begin) glance.seconds = seconds_between(*begin, end);
    return glance;
}

// The program is in the Metadata after the Header. Another program that saved the file may have removed it.
RecordingHead head_of_mcap(std::string_view file) {
    if (!file.starts_with(mcap::magic)) return {};
    file.remove_prefix(mcap::magic.size());
    const auto header = mcap::next_record(file), metadata = mcap::next_record(file);
    const bool are_there = header && header->opcode == mcap::Opcode::header && metadata &&
                           metadata->opcode == mcap::Opcode::metadata;
    if (!are_there || mcap::name_of_metadata(metadata->body) != mcap::head_name) return {};
    return mcap::recording_head_of(metadata->body);
}

bool has_end_of_mcap(std::string_view last) {
    constexpr std::size_t size = mcap::footer_size + mcap::magic.size();
    if (last.size() < size) return false;
    last.remove_prefix(last.size() - size);
    const auto footer = mcap::next_record(last);
    return footer && footer->opcode == mcap::Opcode::footer && last == mcap::magic;
}

RecordingGlance glance_at_mcap(std::string_view first, std::string_view last) {
    return {.head = head_of_mcap(first), .is_ended = has_end_of_mcap(last), .frames = std::nullopt, .seconds = std::nullopt};
}

}    // namespace

RecordingGlance glance_at(RecordingFormat format, std::string_view first, std::string_view last) {
    return format == RecordingFormat::mcap ? glance_at_mcap(first, last) : glance_at_pcapng(first, last);
}

}    // namespace anogate
