#include <ano/wire.hpp>
#include <record/pcapng_format.hpp>
#include <record/pcapng_reader.hpp>
#include <record/recording_glance.hpp>

#include <algorithm>
#include <charconv>
#include <string>

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

// Of MCAP only what says whose it is: the Metadata behind the Header, and the magic at both ends.
constexpr std::string_view mcap_magic{"\x89MCAP0\r\n", 8};
constexpr std::uint8_t mcap_header = 1, mcap_metadata = 12;
constexpr std::string_view mcap_head_name = "anogate.recording";

// Takes fields off the front; what is not there is 0 or empty.
class GlanceFields {
public:
    explicit GlanceFields(std::string_view bytes) noexcept : rest_{bytes} {}

    template <class T>
    T number() noexcept {
        const std::string_view taken = bytes(sizeof(T));
        return taken.empty() ? T{} : loaded_at<T>(taken, 0);
    }
    std::string_view bytes(std::uint64_t size) noexcept {
        if (size > rest_.size()) rest_ = {};
        const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(std::min<std::uint64_t>(size, rest_.size())));
        rest_.remove_prefix(taken.size());
        return taken;
    }
    std::string_view text() noexcept { return bytes(number<std::uint32_t>()); }
    bool empty() const noexcept { return rest_.empty(); }

private:
    std::string_view rest_;
};

std::uint64_t decimal(std::string_view text) {
    std::uint64_t number = 0;
    std::from_chars(text.data(), text.data() + text.size(), number);
    return number;
}

RecordingHead head_of_mcap(std::string_view metadata) {
    GlanceFields fields{metadata};
    RecordingHead head;
    if (fields.text() != mcap_head_name) return head;
    GlanceFields pairs{fields.text()};
    while (!pairs.empty()) {
        const std::string_view key = pairs.text(), value = pairs.text();
        if (key == "program") head.program = value;
        else if (key == "time_ns") head.time_ns = decimal(value);
        else if (key == "boottime_ns") head.boottime_ns = decimal(value);
    }
    return head;
}

RecordingGlance glance_at_mcap(std::string_view first, std::string_view last) {
    RecordingGlance glance;
    if (!first.starts_with(mcap_magic)) return glance;
    GlanceFields file{first.substr(mcap_magic.size())};
    for (int record = 0; record < 2; ++record) {
        const auto opcode = file.number<std::uint8_t>();
        const std::string_view body = file.bytes(file.number<std::uint64_t>());
        if (opcode == mcap_metadata) glance.head = head_of_mcap(body);
        if (opcode != mcap_header) break;
    }
    glance.is_ended = last.size() > mcap_magic.size() && last.ends_with(mcap_magic) && first.size() > 2 * mcap_magic.size();
    return glance;
}

}    // namespace

RecordingGlance glance_at(RecordingFormat format, std::string_view first, std::string_view last) {
    return format == RecordingFormat::mcap ? glance_at_mcap(first, last) : glance_at_pcapng(first, last);
}

}    // namespace anogate
