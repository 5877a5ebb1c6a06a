// Makes a recording that was cut, by a loss of power or by force, a whole one again. No I/O.
//
// Flow:    RecordingRepair repair{format};
//          for (each piece of the file) repair.give(piece);
//          const RecordingRepair::Result result = repair.finish();
//          // the file is cut to result.keep bytes, then result.append is appended
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
        std::uint64_t keep = 0;      // bytes of the file, from its begin
        std::string append;          // what ends it
        std::uint64_t frames = 0;    // that are in it
        bool is_whole = false;       // it was ended: nothing is to be done
        bool is_recording = true;    // false: it is none, or damaged before its first frame, and is left as it is
    };

    explicit RecordingRepair(RecordingFormat format);
    ~RecordingRepair();
    RecordingRepair(const RecordingRepair&) = delete;
    RecordingRepair& operator=(const RecordingRepair&) = delete;

    /// The next bytes of the file.
    void give(std::string_view bytes);
    /// As if the file ended here; more may be given afterwards.
    Result finish();

    /// Of one format.
    class Reading {
    public:
        virtual ~Reading() = default;
        virtual void give(std::string_view bytes) = 0;
        virtual Result finish() = 0;
    };

private:
    std::unique_ptr<Reading> reading_;
};

}    // namespace anogate
