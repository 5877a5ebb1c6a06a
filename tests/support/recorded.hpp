// The content of a recording, with its own memory, for comparisons.
#pragma once
#include "bytes.hpp"

#include <record/recording_reader.hpp>
#include <record/recording_writer.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace support {

/// A frame, or a loss, which has no bytes.
struct KeptItem {
    std::uint64_t time_ns = 0, boottime_ns = 0;
    std::string link, description;
    anogate::Direction direction = anogate::Direction::in;
    std::string cause;
    std::optional<std::uint8_t> channel;
    std::string peer;
    Bytes frame;
    std::uint64_t lost = 0;
    std::string names;

    friend bool operator==(const KeptItem&, const KeptItem&) = default;
};

inline KeptItem kept(const anogate::Recorded& item) {
    KeptItem kept;
    if (const auto* loss = std::get_if<anogate::RecordedLoss>(&item)) {
        kept.lost = loss->count;
        kept.names = loss->names;
        return kept;
    }
    const auto& frame = std::get<anogate::RecordedFrame>(item);
    const auto bytes = frame.frame.bytes();
    return {frame.time_ns,
            frame.boottime_ns,
            std::string{frame.link},
            std::string{frame.link_description},
            frame.direction,
            std::string{frame.cause},
            frame.channel,
            std::string{frame.peer},
            {bytes.begin(), bytes.end()},
            0,
            {}};
}

inline anogate::RecordedFrame frame_of(const KeptItem& item) {
    return {item.time_ns, item.boottime_ns, item.link, item.description,          item.direction,
            item.cause,   item.channel,     item.peer, ano::FrameView{item.frame}};
}

struct ReadRecording {
    std::vector<KeptItem> items;
    anogate::RecordingHead head;
    bool has_end = false;
    std::uint64_t foreign = 0;
    std::string fault;
    anogate::SkippedParts skipped;
    std::uint64_t position = 0;
    std::size_t unfinished = 0;
};

/// Reads a recording of any format, `step` bytes at a time.
inline ReadRecording read_recording(std::string_view file, std::size_t step = 4096) {
    const auto reader = anogate::make_recording_reader(file);
    ReadRecording read;
    for (std::size_t at = 0; at < file.size(); at += step) {
        reader->feed(file.substr(at, step));
        while (const auto item = reader->next()) read.items.push_back(kept(*item));
    }
    read.head = reader->head();
    read.has_end = reader->has_end();
    read.foreign = reader->foreign();
    if (reader->is_damaged()) read.fault = reader->fault();
    read.skipped = reader->skipped();
    read.position = reader->position();
    read.unfinished = reader->unfinished();
    return read;
}
inline ReadRecording read_pcapng(std::string_view file, std::size_t step = 4096) { return read_recording(file, step); }

/// `often`: flushes after this many items; 0: never.
inline std::string write_recording(anogate::RecordingFormat format, const std::vector<KeptItem>& items,
                                   const anogate::RecordingHead& head, bool end = true, std::size_t often = 0) {
    std::string file;
    const auto writer = anogate::make_recording_writer(format, head, file);
    for (std::size_t i = 0; i < items.size(); ++i) {
        if (items[i].frame.empty()) writer->write(anogate::RecordedLoss{items[i].lost, items[i].names});
        else writer->write(frame_of(items[i]), file);
        if (often > 0 && (i + 1) % often == 0) writer->flush(file);
    }
    if (end) writer->end(file);
    else writer->flush(file);
    return file;
}
inline std::string write_pcapng(const std::vector<KeptItem>& items, const anogate::RecordingHead& head, bool end = true) {
    return write_recording(anogate::RecordingFormat::pcapng, items, head, end);
}

/// True if these rules hold for `file`, which may be any bytes: the result of reading does not depend on the sizes of the pieces.
/// If the items read are recorded and read again, recording them again gives the same bytes.
inline bool holds_the_laws_of_recordings(std::string_view file) {
    const ReadRecording read = read_recording(file), in_pieces = read_recording(file, 13);
    if (read.items != in_pieces.items || read.fault != in_pieces.fault || read.position != in_pieces.position) return false;
    if (read.skipped != in_pieces.skipped || read.skipped.bytes > read.position) return false;
    if (read.position > file.size()) return false;
    for (const auto format : {anogate::RecordingFormat::pcapng, anogate::RecordingFormat::mcap}) {
        const std::string recorded = write_recording(format, read.items, read.head);
        const ReadRecording again = read_recording(recorded);
        if (!again.fault.empty() || again.skipped.count != 0 || !again.has_end || again.unfinished != 0) return false;
        if (write_recording(format, again.items, again.head) != recorded) return false;
    }
    return true;
}

}    // namespace support
