#include <record/mcap/mcap_items.hpp>

namespace anogate::mcap {
namespace {

constexpr std::string_view little_endian_cdr{"\0\1\0\0", 4};

// In CDR numbers are aligned to their size, counted from the end of its header.
std::size_t cdr_padding(std::size_t size, std::size_t of_number) {
    const std::size_t behind_head = size - little_endian_cdr.size();
    return (of_number - behind_head % of_number) % of_number;
}

template <std::unsigned_integral T>
void append_cdr(std::string& out, T number) {
    out.append(cdr_padding(out.size(), sizeof number), '\0');
    append_le(out, number);
}

void append_cdr_text(std::string& out, std::string_view text) {
    text = text_that_fits(text);
    append_cdr(out, static_cast<std::uint32_t>(text.size() + 1));
    out += text;
    out += '\0';
}

class CdrFields {
public:
    explicit CdrFields(std::string_view data) : size_{data.size()}, fields_{data} {
        is_cdr_ = fields_.bytes(little_endian_cdr.size()) == little_endian_cdr;
    }
    template <std::unsigned_integral T>
    T number() {
        if (is_bad()) return 0;
        fields_.bytes(cdr_padding(size_ - fields_.rest().size(), sizeof(T)));
        return fields_.number<T>();
    }
    std::string_view bytes() { return fields_.bytes(number<std::uint32_t>()); }
    std::string_view text() {
        std::string_view text = bytes();
        return text.substr(0, text.find('\0'));
    }
    bool is_bad() const { return !is_cdr_ || fields_.is_bad(); }

private:
    std::size_t size_;
    Fields fields_;
    bool is_cdr_ = false;
};

std::optional<RecordedFrame> frame_of(const Message& message) {
    CdrFields fields{message.data};
    RecordedFrame item{.time_ns = message.log_time, .boottime_ns = fields.number<std::uint64_t>(), .frame = ano::FrameView{{}}};
    item.link = fields.text();
    item.link_description = fields.text();
    const auto direction = fields.number<std::uint8_t>();
    item.cause = fields.text();
    const auto channel = fields.number<std::uint16_t>();
    item.peer = fields.text();
    const std::string_view bytes = fields.bytes();
    if (fields.is_bad() || direction > static_cast<std::uint8_t>(Direction::dropped)) return std::nullopt;
    item.direction = static_cast<Direction>(direction);
    if (channel <= 0xFF) item.channel = static_cast<std::uint8_t>(channel);
    const auto frame = ano::frame_at({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    if (!frame || frame->bytes().size() != bytes.size()) return std::nullopt;
    item.frame = *frame;
    return item;
}

}    // namespace

void encode(const RecordedFrame& frame, std::string& out) {
    constexpr std::uint16_t no_channel = 0xFFFF;    // -1
    out = little_endian_cdr;
    append_cdr(out, frame.boottime_ns);
    append_cdr_text(out, frame.link);
    append_cdr_text(out, frame.link_description);
    append_cdr(out, static_cast<std::uint8_t>(frame.direction));
    append_cdr_text(out, frame.cause);
    append_cdr(out, frame.channel ? std::uint16_t{*frame.channel} : no_channel);
    append_cdr_text(out, frame.peer);
    const auto bytes = frame.frame.bytes();
    append_cdr(out, static_cast<std::uint32_t>(bytes.size()));
    out.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void encode(const RecordedLoss& loss, std::string& out) {
    out = little_endian_cdr;
    append_cdr(out, loss.count);
    append_cdr_text(out, loss.names);
}

void Items::add_channel(std::string_view body) {
    const auto channel = channel_of(body);
    if (!channel) return;
    const bool is_cdr = channel->encoding == "cdr";
    const bool has_frames = is_cdr && channel->topic == frames_topic, has_losses = is_cdr && channel->topic == losses_topic;
    set_kind(channel->id, has_frames ? Kind::frames : has_losses ? Kind::losses : Kind::other);
    if (has_frames || has_losses) has_channel_ = true;
}

Items::Kind Items::kind_of(std::uint16_t channel) const noexcept {
    return channel < kinds_.size() ? kinds_[channel] : Kind::unknown;
}

void Items::set_kind(std::uint16_t channel, Kind kind) {
    if (channel >= kinds_.size()) kinds_.resize(std::size_t{channel} + 1);
    kinds_[channel] = kind;
}

bool Items::has_frames(std::uint16_t channel) const noexcept { return kind_of(channel) == Kind::frames; }

std::optional<Recorded> Items::item_of(const Message& message) {
    const Kind kind = kind_of(message.channel);
    if (kind == Kind::unknown && misses_channels_) {
        const auto frame = frame_of(message);
        if (!frame) return std::nullopt;
        set_kind(message.channel, Kind::frames);
        has_channel_ = true;
        return Recorded{*frame};
    }
    if (kind == Kind::losses) {
        CdrFields fields{message.data};
        RecordedLoss loss{fields.number<std::uint64_t>(), fields.text()};
        if (!fields.is_bad() && loss.count > 0) return Recorded{loss};
        ++foreign_;
    } else if (kind == Kind::frames) {
        if (const auto frame = frame_of(message)) return Recorded{*frame};
        ++foreign_;
    }
    return std::nullopt;
}

}    // namespace anogate::mcap
