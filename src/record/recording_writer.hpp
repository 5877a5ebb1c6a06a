// Writes a recording in either format. No I/O.
//
// Flow:    std::string bytes;
//          const auto writer = make_recording_writer(RecordingFormat::pcapng, head, bytes);
//          writer->write(frame, bytes); ...    // each call may append
//          writer->flush(bytes);               // now everything written is in `bytes`
//          writer->end(bytes);                 // no calls afterwards
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

/// "pcapng", "mcap"; also the file name extension, without the dot.
std::string_view text(RecordingFormat format) noexcept;
/// By the extension of a file name, in lower or upper case; std::nullopt: unknown extension.
std::optional<RecordingFormat> recording_format_of(std::string_view file);

class RecordingWriter {
public:
    virtual ~RecordingWriter() = default;

    virtual void write(const RecordedFrame& frame, std::string& out) = 0;
    /// Frames that could not be recorded; written with the next frame, or at the end.
    virtual void write(const RecordedLoss& loss) = 0;
    /// The frames that follow are decoded with this.
    virtual void use(const DecodingPtr& decoding, std::string& out) = 0;
    /// Appends everything that is buffered, so that a file that ends here contains all that was written.
    virtual void flush(std::string& out) = 0;
    /// Appends the end mark of the recording. Nothing may be written afterwards.
    virtual void end(std::string& out) = 0;
};

/// For MCAP only: pcapng has no decoded messages and no compression.
struct RecordingOptions {
    DecodedEncoding encoding = DecodedEncoding::cdr;    // of decoded messages
    bool packed = true;                                 // compressed by zstd
};

/// Appends the head of the file to `out`.
std::unique_ptr<RecordingWriter> make_recording_writer(RecordingFormat format, const RecordingHead& head, std::string& out,
                                                       RecordingOptions options = {});

}    // namespace anogate
