// Writes a recording in one format or another. No I/O.
//
// Flow:    std::string bytes;
//          const auto writer = make_recording_writer(RecordingFormat::pcapng, head, bytes);
//          writer->write(frame, bytes); ...    // each call may append
//          writer->flush(bytes);               // now all that was written is in the bytes
//          writer->end(bytes);                 // nothing is written behind it
#pragma once
#include <record/decoded_channels.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

enum class RecordingFormat : std::uint8_t { pcapng, mcap };

/// "pcapng", "mcap": also the end of the name of a file, behind its dot.
std::string_view text(RecordingFormat format) noexcept;
/// Of a file's name, whose end may be in capitals.
std::optional<RecordingFormat> recording_format_of(std::string_view file);

class RecordingWriter {
public:
    virtual ~RecordingWriter() = default;

    virtual void write(const RecordedFrame& frame, std::string& out) = 0;
    /// Frames that are not in it; is told with the next frame, or at the end.
    virtual void write(const RecordedLoss& loss) = 0;
    /// Appends what it holds back: whatever was written until now is read of a file that ends here.
    virtual void flush(std::string& out) = 0;
    /// Appends what tells that the recording was ended; nothing is written behind it.
    virtual void end(std::string& out) = 0;
};

/// Of MCAP: pcapng has frames alone, and packs nothing.
struct RecordingOptions {
    DecodedEncoding encoding = DecodedEncoding::cdr;    // of what frames say
    bool packed = true;                                 // by zstd
};

/// Appends the head of the file to `out`.
std::unique_ptr<RecordingWriter> make_recording_writer(RecordingFormat format, const RecordingHead& head, std::string& out,
                                                       RecordingOptions options = {});

}    // namespace anogate
