#include <record/pcapng_format.hpp>
#include <record/pcapng_reader.hpp>

#include <ano/wire.hpp>

#include <algorithm>
#include <charconv>
#include <utility>

namespace anogate {
namespace {

using namespace pcapng;

constexpr std::uint64_t second_ns = 1'000'000'000;
constexpr std::size_t min_block = 12;
constexpr std::size_t min_section_header = 28;

std::string_view text_in(std::span<const std::uint8_t> bytes) {
    const std::string_view text{reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    return text.substr(0, text.find('\0'));
}

// From if_tsresol; 0: does not fit into 64 bits.
std::uint64_t units_per_second(std::uint8_t resolution) {
    const unsigned exponent = resolution & 0x7F;
    if (resolution & 0x80) return exponent < 64 ? std::uint64_t{1} << exponent : 0;
    if (exponent > 19) return 0;
    std::uint64_t units = 1;
    for (unsigned i = 0; i < exponent; ++i) units *= 10;
    return units;
}

std::uint64_t nanoseconds_of(std::uint64_t units, std::uint64_t per_second) {
    if (per_second == 0) return 0;
    const std::uint64_t rest = units % per_second;
    const bool exact = per_second <= 10 * second_ns;    // the product fits into 64 bits
    const std::uint64_t below = exact ? rest * second_ns / per_second
                                      : static_cast<std::uint64_t>(static_cast<double>(rest) / static_cast<double>(per_second) *
                                                                   static_cast<double>(second_ns));
    return units / per_second * second_ns + below;
}

// Parses "1763898044.123456789" at the front and removes it; the result in ns.
std::optional<std::uint64_t> parse_seconds(std::string_view& text) {
    std::uint64_t seconds = 0, below = 0;
    const char* const end = text.data() + text.size();
    const auto whole = std::from_chars(text.data(), end, seconds);
    if (whole.ec != std::errc{} || whole.ptr == end || *whole.ptr != '.' || end - whole.ptr < 10) return std::nullopt;
    const auto part = std::from_chars(whole.ptr + 1, whole.ptr + 10, below);
    if (part.ec != std::errc{} || part.ptr != whole.ptr + 10 || seconds > ~std::uint64_t{0} / second_ns - 1) return std::nullopt;
    text.remove_prefix(static_cast<std::size_t>(part.ptr - text.data()));
    return seconds * second_ns + below;
}

bool skip_prefix(std::string_view& text, std::string_view words) {
    if (!text.starts_with(words)) return false;
    text.remove_prefix(words.size());
    return true;
}

}    // namespace

std::uint16_t PcapngReader::u16(Bytes bytes, std::size_t at) const noexcept {
    const auto number = ano::load<std::uint16_t>(bytes.data() + at);
    return swapped_ ? static_cast<std::uint16_t>(number >> 8 | number << 8) : number;
}

std::uint32_t PcapngReader::u32(Bytes bytes, std::size_t at) const noexcept {
    const auto number = ano::load<std::uint32_t>(bytes.data() + at);
    return swapped_ ? __builtin_bswap32(number) : number;
}

std::uint64_t PcapngReader::u64(Bytes bytes, std::size_t at) const noexcept {
    const auto number = ano::load<std::uint64_t>(bytes.data() + at);
    return swapped_ ? __builtin_bswap64(number) : number;
}

// The list also ends at the end of the block, and at an invalid option.
std::optional<PcapngReader::Option> PcapngReader::next_option(Bytes& options) const noexcept {
    if (options.size() < 4) return std::nullopt;
    const std::uint16_t code = u16(options, 0);
    const std::size_t size = u16(options, 2);
    if (code == opt_end || size > options.size() - 4) return std::nullopt;
    const Option option{code, options.subspan(4, size)};
    const std::size_t padded = 4 + (size + 3) / 4 * 4;
    options = options.subspan(std::min(padded, options.size()));
    return option;
}

void PcapngReader::feed(std::string_view bytes) {
    loss_.reset();
    frame_.reset();
    buffer_.erase(0, at_);
    at_ = 0;
    if (!is_damaged()) buffer_ += bytes;
}

// The body of the next block.
std::optional<PcapngReader::Bytes> PcapngReader::read_block(std::uint32_t& type) {
    const Bytes rest{reinterpret_cast<const std::uint8_t*>(buffer_.data()) + at_, buffer_.size() - at_};
    if (is_damaged() || rest.size() < min_block) return std::nullopt;
    type = u32(rest, 0);    // the type of a section header is the same in either byte order
    if (type == section_header) {
        const auto magic = ano::load<std::uint32_t>(rest.data() + 8);
        swapped_ = magic == __builtin_bswap32(byte_order_magic);
        if (!swapped_ && magic != byte_order_magic) return damage("the byte order of a section is unknown"), std::nullopt;
    } else if (!begun_) {
        return damage("it is neither pcapng nor MCAP"), std::nullopt;
    }
    const std::size_t size = u32(rest, 4);
    if (size < (type == section_header ? min_section_header : min_block) || size % 4 != 0)
        return damage("a block has an invalid length"), std::nullopt;
    if (size > max_block) return damage("a block is longer than 16 MiB"), std::nullopt;
    if (rest.size() < size) return std::nullopt;
    if (u32(rest, size - 4) != size) return damage("the two lengths of a block differ"), std::nullopt;
    at_ += size;
    position_ += size;
    block_size_ = size;
    return rest.subspan(8, size - min_block);
}

std::optional<Recorded> PcapngReader::next() {
    while (true) {
        if (loss_) return Recorded{*std::exchange(loss_, std::nullopt)};
        if (frame_) return Recorded{*std::exchange(frame_, std::nullopt)};
        std::uint32_t type = 0;
        const auto body = read_block(type);
        if (!body) return std::nullopt;
        const std::uint64_t skipped_before = skipped_.count;
        switch (type) {
        case section_header: begin_section(*body); break;
        case interface_description: add_interface(*body); break;
        case interface_statistics: end_interface(*body); break;
        case enhanced_packet: read_packet(*body); break;
        case old_packet:
        case simple_packet: ++foreign_; break;
        default: break;    // host names, keys and blocks of other programs
        }
        if (skipped_.count == skipped_before && !is_damaged()) good_end_ = position_;
    }
}

// Skips a damaged block. Its two lengths are equal, so the position of the next block is known.
void PcapngReader::skip(const char* why, bool is_packet) {
    skipped_.add({position_ - block_size_, block_size_, is_packet ? 1 : 0, why});
    if (is_packet) ++skipped_.frames;
}

void PcapngReader::begin_section(Bytes body) {
    if (u16(body, 4) != 1) return damage("it uses an unsupported version of pcapng");
    begun_ = true;
    interfaces_.clear();
    for (std::string& peer : peers_) peer.clear();
    head_ = {};
    for (Bytes options = body.subspan(16); const auto option = next_option(options);) {
        std::string_view text = text_in(option->value);
        if (option->code == shb_userappl) head_.program = text;
        if (option->code != opt_comment || !skip_prefix(text, unix_mark)) continue;
        const auto time = parse_seconds(text);
        if (!time || !skip_prefix(text, boot_mark)) continue;
        head_.time_ns = *time;
        head_.boottime_ns = parse_seconds(text).value_or(0);
    }
}

void PcapngReader::add_interface(Bytes body) {
    if (interfaces_.size() >= max_interfaces) return damage("it has more than 65536 interfaces");
    Interface interface;
    if (body.size() < 8) {    // still added, so that the following interfaces keep their numbers
        interfaces_.push_back(std::move(interface));
        return skip("the description of an interface is too short", false);
    }
    interface.ours = u16(body, 0) == link_type_user0;
    (interface.ours ? has_ours_ : has_strangers_) = true;
    interface.per_second = 1'000'000;
    for (Bytes options = body.subspan(8); const auto option = next_option(options);) {
        if (option->code == if_name) interface.name = text_in(option->value);
        if (option->code == if_description) interface.description = text_in(option->value);
        if (option->code == if_tsresol && option->value.size() == 1) interface.per_second = units_per_second(option->value[0]);
        if (option->code == if_tsoffset && option->value.size() == 8) interface.offset_s = u64(option->value, 0);
    }
    interfaces_.push_back(std::move(interface));
}

void PcapngReader::end_interface(Bytes body) {
    has_end_ = true;
    if (body.size() < 12) return;
    RecordedLoss loss;
    for (Bytes options = body.subspan(12); const auto option = next_option(options);) {
        if (option->code == isb_osdrop && option->value.size() == 8) loss.count = u64(option->value, 0);
        std::string_view text = text_in(option->value);
        if (option->code == opt_comment && skip_prefix(text, lost_mark)) loss.names = text;
    }
    if (loss.count > 0) loss_ = loss;
}

void PcapngReader::read_packet(Bytes body) {
    if (body.size() < 20) return skip("a packet is too short", true);
    const std::size_t number = u32(body, 0), size = u32(body, 12), whole_size = u32(body, 16);
    if (number >= interfaces_.size()) return skip("a packet belongs to an interface without a description", true);
    if (size > body.size() - 20) return skip("a packet is longer than its block", true);
    has_end_ = false;
    const Interface& interface = interfaces_[number];
    const auto frame = interface.ours && size == whole_size ? ano::frame_at(body.subspan(20, size)) : std::nullopt;
    if (!frame || frame->bytes().size() != size) {
        ++foreign_;
        return;
    }
    const std::uint64_t units = std::uint64_t{u32(body, 4)} << 32 | u32(body, 8);
    frame_ = RecordedFrame{.time_ns = nanoseconds_of(units, interface.per_second) + interface.offset_s * second_ns,
                           .link = interface.name,
                           .link_description = interface.description,
                           .frame = *frame};
    read_options(body.subspan(20 + std::min((size + 3) / 4 * 4, body.size() - 20)), *frame_);
}

void PcapngReader::read_options(Bytes options, RecordedFrame& frame) {
    RecordedLoss loss;
    std::string decoding;
    while (const auto option = next_option(options)) {
        std::string_view text = text_in(option->value);
        const std::size_t size = option->value.size();
        if (option->code == epb_flags && size == 4 && frame.direction != Direction::dropped)
            frame.direction = (u32(option->value, 0) & 3) == outbound ? Direction::out : Direction::in;
        else if (option->code == epb_dropcount && size == 8) loss.count = u64(option->value, 0);
        else if (option->code == epb_queue && size == 4 && u32(option->value, 0) < peers_.size())
            frame.channel = static_cast<std::uint8_t>(u32(option->value, 0));
        else if (option->code == opt_boottime && size == 8) frame.boottime_ns = u64(option->value, 0);
        else if (option->code == opt_comment && skip_prefix(text, lost_mark)) loss.names = text;
        else if (option->code == opt_comment && skip_prefix(text, decoding_mark)) decoding += text;
        else if (option->code == opt_comment) read_comment(text, frame);
    }
    if (!decoding.empty()) head_.use_decoding(decoding);
    if (frame.channel) frame.peer = peers_[*frame.channel];
    if (loss.count > 0) loss_ = loss;
}

void PcapngReader::read_comment(std::string_view text, RecordedFrame& frame) {
    if (skip_prefix(text, dropped_mark)) {
        frame.direction = Direction::dropped;
        frame.cause = text;
    } else if (skip_prefix(text, channel_mark)) {
        std::uint8_t number = 0;
        const auto [behind, fault] = std::from_chars(text.data(), text.data() + text.size(), number);
        text.remove_prefix(static_cast<std::size_t>(behind - text.data()));
        if (fault == std::errc{} && skip_prefix(text, ": ")) peers_[number] = text;
    }
}

}    // namespace anogate
