// The files of a recording in a folder, and the numbers of the frames in them.
#pragma once
#include "files.hpp"
#include "numbered_frames.hpp"
#include "recorded.hpp"

#include <record/rotation.hpp>

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace support {

/// The number of a frame that numbered() made.
inline int number_of(const Bytes& frame) {
    const auto data = ano::FrameView{frame}.data();
    int number = 0;
    for (std::size_t i = 0; i < 4; ++i) number |= data[i] << 8 * i;
    return number;
}

struct RecordedFiles {
    std::vector<ReadRecording> files;    // NAME.pcapng, NAME-2.pcapng and so on, up to the first missing number
    std::vector<int> numbers;            // of the frames in all files, in order
    std::uint64_t lost = 0;              // sum of the losses in them
    std::string names;                   // names of the losses

    bool are_whole() const {
        for (const ReadRecording& file : files)
            if (!file.has_end || file.unfinished > 0 || !file.fault.empty()) return false;
        return !files.empty();
    }
};

inline RecordedFiles recorded_files(const std::string& folder, const std::string& name) {
    RecordedFiles all;
    for (unsigned n = 1;; ++n) {
        const auto path = std::filesystem::path{folder} / anogate::recording_file_name(name, n, anogate::RecordingFormat::pcapng);
        if (!std::filesystem::exists(path)) return all;
        all.files.push_back(read_pcapng(file_text(path)));
        for (const KeptItem& item : all.files.back().items) {
            if (item.frame.empty()) {
                all.lost += item.lost;
                all.names += item.names;
            } else if (item.frame[3] == 0xF1) {
                all.numbers.push_back(number_of(item.frame));
            }
        }
    }
}

/// 0, 1, 2 and so on.
inline std::vector<int> numbers_to(int end) {
    std::vector<int> numbers;
    for (int n = 0; n < end; ++n) numbers.push_back(n);
    return numbers;
}

}    // namespace support
