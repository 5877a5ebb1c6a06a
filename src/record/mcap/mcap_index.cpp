#include <record/crc32.hpp>
#include <record/mcap/mcap_index.hpp>
#include <record/mcap/mcap_reader.hpp>

#include <algorithm>
#include <vector>

namespace anogate {
namespace {

using mcap::Fields, mcap::Opcode;

constexpr std::size_t summary_piece = 1024 * 1024;
constexpr std::size_t max_metadata_size = 16 * 1024 * 1024;
constexpr std::size_t max_metadata = 64;

struct Span {
    std::uint64_t at = 0, size = 0;
};

class IndexReading {
public:
    IndexReading(std::uint64_t file_size, const ReadAt& read) : file_size_{file_size}, read_{read} {}

    std::optional<McapIndex> index() {
        if (!read_footer() || !read_summary()) return std::nullopt;
        for (const Span& place : metadata_) read_metadata(place);
        // The frames are counted in two places, which must agree.
        if (!has_head_ || !counts_ || counts_->frames != frames_) return std::nullopt;
        return McapIndex{std::move(head_), std::move(*counts_)};
    }

private:
    std::string whole(std::uint64_t at, std::size_t size) const {
        std::string bytes = read_(at, size);
        if (bytes.size() != size) bytes.clear();
        return bytes;
    }

    bool read_footer() {
        constexpr std::size_t size = mcap::footer_size + mcap::magic.size();
        if (file_size_ < mcap::magic.size() + size || whole(0, mcap::magic.size()) != mcap::magic) return false;
        footer_at_ = file_size_ - size;
        footer_ = whole(footer_at_, size);
        if (!footer_.ends_with(mcap::magic)) return false;
        std::string_view rest = footer_;
        const auto footer = mcap::next_record(rest);
        if (!footer || footer->opcode != Opcode::footer || footer->whole.size() != mcap::footer_size) return false;
        Fields fields{footer->body};
        summary_at_ = fields.number<std::uint64_t>();
        fields.number<std::uint64_t>();
        crc_ = fields.number<std::uint32_t>();
        return summary_at_ > mcap::magic.size() && summary_at_ < footer_at_;
    }

    // In parts, because the summary of a recording of many days is long.
    bool read_summary() {
        Crc32 crc;
        std::string waiting;
        for (std::uint64_t at = summary_at_; at < footer_at_;) {
            const std::string piece = read_(at,
                                            static_cast<std::size_t>(std::min<std::uint64_t>(summary_piece, footer_at_ - at)));
            if (piece.empty() || waiting.size() > mcap::max_record) return false;
            at += piece.size();
            crc.add(piece);
            waiting += piece;
            std::string_view rest = waiting;
            while (const auto record = mcap::next_record(rest)) process(*record);
            waiting.erase(0, waiting.size() - rest.size());
        }
        crc.add(std::string_view{footer_}.substr(0, mcap::footer_size - sizeof crc_));
        return waiting.empty() && (crc_ == 0 || crc_ == crc.value());
    }

    void process(const mcap::Record& record) {
        Fields fields{record.body};
        if (record.opcode == Opcode::channel) {
            const auto channel = mcap::channel_of(record.body);
            if (channel && channel->topic == mcap::frames_topic) frames_channel_ = channel->id;
        } else if (record.opcode == Opcode::metadata_index && metadata_.size() < max_metadata) {
            metadata_.push_back({fields.number<std::uint64_t>(), fields.number<std::uint64_t>()});
        } else if (record.opcode == Opcode::statistics) {
            constexpr std::size_t before_counts = 8 + 2 + 4 + 4 + 4 + 4 + 8 + 8;
            fields.bytes(before_counts);
            Fields counts{fields.text()};
            while (!counts.rest().empty() && !counts.is_bad()) {
                const auto channel = counts.number<std::uint16_t>();
                const auto count = counts.number<std::uint64_t>();
                if (channel == frames_channel_) frames_ = count;
            }
        }
    }

    void read_metadata(const Span& place) {
        if (place.size > max_metadata_size || place.at > file_size_) return;
        const std::string bytes = whole(place.at, static_cast<std::size_t>(place.size));
        std::string_view rest = bytes;
        const auto record = mcap::next_record(rest);
        if (!record || record->opcode != Opcode::metadata) return;
        const std::string_view name = mcap::name_of_metadata(record->body);
        if (name == mcap::counts_name) counts_ = RecordingCounts::of_json(mcap::metadata_at(record->body, "json"));
        if (name == mcap::decoding_name) head_.use_decoding(mcap::metadata_at(record->body, "json"));
        if (name != mcap::head_name) return;
        head_ = mcap::recording_head_of(record->body);
        has_head_ = true;
    }

    std::uint64_t file_size_;
    const ReadAt& read_;
    std::uint64_t footer_at_ = 0, summary_at_ = 0;
    std::uint32_t crc_ = 0;
    std::string footer_;
    std::optional<std::uint16_t> frames_channel_;    // known before the statistics are read
    std::uint64_t frames_ = 0;
    std::vector<Span> metadata_;
    RecordingHead head_;
    bool has_head_ = false;
    std::optional<RecordingCounts> counts_;
};

}    // namespace

std::optional<McapIndex> read_mcap_index(std::uint64_t file_size, const ReadAt& read) {
    return IndexReading{file_size, read}.index();
}

}    // namespace anogate
