#include <ano/wire.hpp>
#include <record/mcap_reader.hpp>
#include <record/pcapng_format.hpp>
#include <record/pcapng_reader.hpp>
#include <record/recording_glance.hpp>

namespace anogate {
namespace {

using namespace pcapng;

constexpr std::size_t block_ends = 12;    // type, and the length twice

template <class T>
T loaded_at(std::string_view bytes, std::size_t at) {
    return ano::load<T>(reinterpret_cast<const std::uint8_t*>(bytes.data()) + at);
}

/// The block that ends where `bytes` do, taken off; nothing: none does.
std::optional<std::string_view> take_last_block(std::string_view& bytes) {
    if (bytes.size() < block_ends) return std::nullopt;
    const auto size = loaded_at<std::uint32_t>(bytes, bytes.size() - 4);
    if (size < block_ends || size % 4 != 0 || size > bytes.size()) return std::nullopt;
    const std::string_view block = bytes.substr(bytes.size() - size);
    if (loaded_at<std::uint32_t>(block, 4) != size) return std::nullopt;
    bytes.remove_suffix(size);
    return block;
}

/// Of the statistics of an interface.
std::uint64_t frames_of(std::string_view block) {
    std::string_view options = block.substr(8, block.size() - block_ends);
    options.remove_prefix(options.size() < 12 ? options.size() : 12);    // interface and time
    while (options.size() >= 4) {
        const auto code = loaded_at<std::uint16_t>(options, 0), size = loaded_at<std::uint16_t>(options, 2);
        const std::size_t whole = 4 + (std::size_t{size} + 3) / 4 * 4;
        if (code == opt_end || whole > options.size()) break;
        if (code == isb_ifrecv && size == sizeof(std::uint64_t)) return loaded_at<std::uint64_t>(options, 4);
        options.remove_prefix(whole);
    }
    return 0;
}

// The gateway writes little endian.
RecordingGlance glance_at_pcapng(std::string_view first, std::string_view last) {
    RecordingGlance glance;
    PcapngReader reader;
    reader.give(first);
    while (reader.next()) {}
    if (reader.position() > 0) glance.head = reader.head();
    std::uint64_t frames = 0;
    while (const auto block = take_last_block(last)) {
        if (loaded_at<std::uint32_t>(*block, 0) != interface_statistics) break;
        glance.is_ended = true;
        frames += frames_of(*block);
    }
    if (glance.is_ended) glance.frames = frames;
    return glance;
}

// Whose it is stands behind the Header, where a program that saved it again need not have left it.
RecordingHead head_of_mcap(std::string_view file) {
    if (!file.starts_with(mcap::magic)) return {};
    file.remove_prefix(mcap::magic.size());
    const auto header = mcap::take_record(file), metadata = mcap::take_record(file);
    const bool are_there = header && header->opcode == mcap::Opcode::header && metadata &&
                           metadata->opcode == mcap::Opcode::metadata;
    if (!are_there || mcap::name_of_metadata(metadata->body) != mcap::head_name) return {};
    return mcap::recording_head_of(metadata->body);
}

bool has_end_of_mcap(std::string_view last) {
    constexpr std::size_t size = mcap::footer_size + mcap::magic.size();
    if (last.size() < size) return false;
    last.remove_prefix(last.size() - size);
    const auto footer = mcap::take_record(last);
    return footer && footer->opcode == mcap::Opcode::footer && last == mcap::magic;
}

RecordingGlance glance_at_mcap(std::string_view first, std::string_view last) {
    return {.head = head_of_mcap(first), .is_ended = has_end_of_mcap(last), .frames = std::nullopt};
}

}    // namespace

RecordingGlance glance_at(RecordingFormat format, std::string_view first, std::string_view last) {
    return format == RecordingFormat::mcap ? glance_at_mcap(first, last) : glance_at_pcapng(first, last);
}

}    // namespace anogate
