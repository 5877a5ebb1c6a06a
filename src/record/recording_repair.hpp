// Repairs a recording that was truncated by a power failure or a kill. No I/O.
//
// Flow:    RecordingRepair repair{format};
//          for (each piece of the file) repair.give(piece);
//          const RecordingRepair::Result result = repair.finish();
//          // cut the file to result.keep bytes, then append result.append
#pragma once
#include <record/recording_writer.hpp>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace anogate {

class RecordingRepair {
public:
    struct Result {
        std::uint64_t keep = 0;      // bytes of the file, from its beginning
        std::string append;          // its new end
        std::uint64_t frames = 0;    // in the repaired file
        bool is_whole = false;       // it was ended properly: nothing to repair
        bool is_recording = true;    // false: not a recording, or damaged before its first frame; leave it as it is
    };

    explicit RecordingRepair(RecordingFormat format);
    ~RecordingRepair();
    RecordingRepair(const RecordingRepair&) = delete;
    RecordingRepair& operator=(const RecordingRepair&) = delete;

    /// The next bytes of the file.
    void feed(std::string_view bytes);
    /// The result if the file ends here; give() may be called again afterwards.
    Result finish();

    /// The repair of one format.
    class Reading {
    public:
        virtual ~Reading() = default;
        virtual void feed(std::string_view bytes) = 0;
        virtual Result finish() = 0;
    };

private:
    std::unique_ptr<Reading> reading_;
};

}    // namespace anogate
