#include <record/pcapng_format.hpp>
#include <record/pcapng_writer.hpp>

#include <algorithm>
#include <concepts>
#include <span>
#include <utility>

namespace anogate {
namespace {

using namespace pcapng;

template <class T>
void append_raw(std::string& out, T number) {
    for (std::size_t i = 0; i < sizeof number; ++i) out += static_cast<char>(number >> 8 * i & 0xFF);
}

void pad(std::string& out) { out.append((4 - out.size() % 4) % 4, '\0'); }

// Pads by its own size, so `out` may have any size.
class Block {
public:
    explicit Block(std::uint32_t type) {
        append_raw(bytes_, type);
        append_raw(bytes_, std::uint32_t{0});
    }
    template <std::unsigned_integral T>
    Block& number(T value) {
        append_raw(bytes_, value);
        return *this;
    }
    Block& data(std::span<const std::uint8_t> data) {
        bytes_.append(reinterpret_cast<const char*>(data.data()), data.size());
        pad(bytes_);
        return *this;
    }
    template <std::unsigned_integral T>
    Block& option(std::uint16_t code, T value) {
        append_raw(bytes_, code);
        append_raw(bytes_, static_cast<std::uint16_t>(sizeof value));
        append_raw(bytes_, value);
        pad(bytes_);
        return *this;
    }
    Block& option(std::uint16_t code, std::string_view text) {
        append_raw(bytes_, code);
        append_raw(bytes_, static_cast<std::uint16_t>(text.size()));
        bytes_ += text;
        pad(bytes_);
        return *this;
    }
    void end(std::string& out) {
        option(opt_end, std::string_view{});
        const auto size = static_cast<std::uint32_t>(bytes_.size() + 4);
        for (std::size_t i = 0; i < 4; ++i) bytes_[4 + i] = static_cast<char>(size >> 8 * i & 0xFF);
        append_raw(bytes_, size);
        out += bytes_;
    }

private:
    std::string bytes_;
};

Block begin_packet(std::uint32_t interface, std::uint64_t time_ns, std::span<const std::uint8_t> bytes) {
    const auto size = static_cast<std::uint32_t>(bytes.size());
    Block block{enhanced_packet};
    block.number(interface).number(static_cast<std::uint32_t>(time_ns >> 32)).number(static_cast<std::uint32_t>(time_ns));
    block.number(size).number(size).data(bytes);
    return block;
}

std::uint32_t flags_of(const RecordedFrame& frame) {
    if (frame.direction != Direction::dropped) return frame.direction == Direction::in ? inbound : outbound;
    const bool came = std::any_of(std::begin(receive_counters), std::end(receive_counters),
                                  [&](const auto& row) { return row.name == frame.cause; });
    return came ? inbound : outbound;
}

void append_interface(std::string_view name, std::string_view description, std::string& out) {
    Block block{interface_description};
    block.number(link_type_user0).number(std::uint16_t{0}).number(std::uint32_t{0});    // snap length: no limit
    block.option(if_name, name);
    if (!description.empty()) block.option(if_description, description);
    block.option(if_tsresol, std::uint8_t{9}).end(out);
}

}    // namespace

PcapngWriter::PcapngWriter(const RecordingHead& head, std::string& out) {
    if (head.decoding && !head.decoding->is_usual()) decoding_ = head.decoding->text();
    Block block{section_header};
    block.number(byte_order_magic).number(std::uint16_t{1}).number(std::uint16_t{0});
    block.number(~std::uint64_t{0});    // section length: not known
    std::string clocks{unix_mark};
    append_seconds(head.time_ns, clocks);
    append_seconds(head.boottime_ns, clocks += boot_mark);
    block.option(opt_comment, clocks + " s");
    block.option(shb_userappl, text_that_fits(head.program)).end(out);
}

std::uint32_t PcapngWriter::count_packet(std::string_view link, std::string_view description, std::uint64_t time_ns,
                                         std::string& out) {
    const std::uint32_t number = interface_of(link, description, out);
    ++interfaces_[number].frames;
    interfaces_[number].last_ns = time_ns;
    return number;
}

std::uint32_t PcapngWriter::interface_of(std::string_view link, std::string_view description, std::string& out) {
    const std::string_view name = text_that_fits(link);
    if (const auto known = numbers_.find(name); known != numbers_.end()) return known->second;
    append_interface(name, text_that_fits(description), out);
    const auto number = static_cast<std::uint32_t>(interfaces_.size());
    interfaces_.emplace_back();
    numbers_.emplace(name, number);
    return number;
}

void PcapngWriter::write_v7(ano::v7::FrameView frame, std::string_view link, Direction direction, std::uint64_t time_ns,
                            std::string& out) {
    Block block = begin_packet(count_packet(link, {}, time_ns, out), time_ns, frame.bytes());
    block.option(epb_flags, direction == Direction::in ? inbound : outbound).end(out);
}

void PcapngWriter::write(const RecordedFrame& frame, std::string& out) {
    const std::uint32_t number = count_packet(frame.link, frame.link_description, frame.time_ns, out);
    Block block = begin_packet(number, frame.time_ns, frame.frame.bytes());
    block.option(epb_flags, flags_of(frame));
    if (lost_ > 0) block.option(epb_dropcount, lost_);
    if (frame.channel) block.option(epb_queue, std::uint32_t{*frame.channel});
    if (frame.direction == Direction::dropped)
        block.option(opt_comment, std::string{dropped_mark}.append(text_that_fits(frame.cause)));
    if (lost_ > 0) block.option(opt_comment, pop_lost_names());
    if (const std::string_view peer = text_that_fits(frame.peer); frame.channel && peers_[*frame.channel] != peer) {
        peers_[*frame.channel] = peer;
        block.option(opt_comment, std::string{channel_mark} + std::to_string(*frame.channel) + ": " + std::string{peer});
    }
    for (std::string_view rest = decoding_; !rest.empty(); rest.remove_prefix(std::min(max_decoding_part, rest.size())))
        block.option(opt_comment, std::string{decoding_mark}.append(rest.substr(0, max_decoding_part)));
    decoding_.clear();
    if (frame.boottime_ns > 0) block.option(opt_boottime, frame.boottime_ns);
    block.end(out);
}

void PcapngWriter::write(const RecordedLoss& loss) {
    if (loss.count == 0) return;
    lost_ += loss.count;
    all_lost_ += loss.count;
    const std::string_view names = text_that_fits(loss.names);
    if (!lost_names_.empty() && !names.empty()) lost_names_ += ", ";
    lost_names_ += names;
    lost_names_.resize(text_that_fits(lost_names_).size());
}

std::string PcapngWriter::pop_lost_names() {
    lost_ = 0;
    return std::string{lost_mark} + std::exchange(lost_names_, {});
}

void PcapngWriter::end(std::string& out) {
    if (interfaces_.empty()) {
        append_interface(no_link, {}, out);
        interfaces_.emplace_back();
    }
    for (std::size_t i = 0; i < interfaces_.size(); ++i) {
        const Interface& interface = interfaces_[i];
        Block block{interface_statistics};
        block.number(static_cast<std::uint32_t>(i));
        block.number(static_cast<std::uint32_t>(interface.last_ns >> 32)).number(static_cast<std::uint32_t>(interface.last_ns));
        block.option(isb_ifrecv, interface.frames);
        if (i == 0 && all_lost_ > 0) block.option(isb_ifdrop, all_lost_);    // the link of lost frames is not known
        if (i == 0 && lost_ > 0) block.option(isb_osdrop, lost_).option(opt_comment, pop_lost_names());
        block.end(out);
    }
}

}    // namespace anogate
