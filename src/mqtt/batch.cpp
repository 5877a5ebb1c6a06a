#include <mqtt/batch.hpp>

#include <array>
#include <utility>

namespace anogate {

std::vector<Batch> BatchPacker::pack(std::span<const Record> records) {
    std::vector<Batch> batches;
    std::array<Batch, keep_classes> open;
    std::array<std::string, keep_classes> lines;
    for (const Record& record : records) {
        const auto keep = static_cast<std::size_t>(record.keep);
        const std::size_t size = record.json.size() + 1;
        if (size > max_lines) continue;
        if (lines[keep].size() + size > max_lines) close(open[keep], lines[keep], batches);
        if (open[keep].records == 0) open[keep].keep = record.keep, open[keep].time_s = record.time_ns / 1'000'000'000;
        ++open[keep].records;
        lines[keep].append(record.json).append(1, '\n');
    }
    for (std::size_t keep = 0; keep < keep_classes; ++keep) close(open[keep], lines[keep], batches);
    return batches;
}

void BatchPacker::close(Batch& batch, std::string& lines, std::vector<Batch>& out) {
    if (batch.records == 0) return;
    packer_.pack(lines, batch.body);
    lines.clear();
    out.push_back(std::exchange(batch, {}));
}

std::optional<std::string_view> BatchUnpacker::unpack(std::string_view body) {
    const auto size = unpacked_size(body);
    if (!size || *size > BatchPacker::max_lines || !unpacker_.unpack(body, *size, lines_)) return std::nullopt;
    return lines_;
}

}    // namespace anogate
