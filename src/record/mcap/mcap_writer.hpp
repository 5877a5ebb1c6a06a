// Writes a recording as MCAP for Foxglove, PlotJuggler and ROS 2: the frames, and their decoded messages. No I/O.
//
// Frames are collected in a chunk; flush() ends it. Chunks of a second or more compress well. Until end() the summary uses about
// 100 bytes of memory for each chunk, and 10 for each channel of it.
#pragma once
#include <record/crc32.hpp>
#include <record/decoded_channels.hpp>
#include <record/mcap/mcap_chunk.hpp>
#include <record/recording_counts.hpp>
#include <record/recording_writer.hpp>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class McapWriter final : public RecordingWriter {
public:
    /// A chunk is ended when it has this many bytes; it may exceed this by one frame with its decoded messages.
    static constexpr std::size_t enough = 1024 * 1024;

    /// Appends the head of the file to `out`.
    McapWriter(const RecordingHead& head, std::string& out, RecordingOptions options = {});

    void write(const RecordedFrame& frame, std::string& out) override;
    void write(const RecordedLoss& loss) override;
    void use(const DecodingPtr& decoding, std::string& out) override;
    void flush(std::string& out) override;
    void end(std::string& out) override;

private:
    void write_loss(std::uint64_t time_ns);
    void write_decoded(const RecordedFrame& frame);
    void define(std::uint16_t channel, std::string_view topic, const mcap::SchemaRecord& schema, std::string_view encoding);
    void put(std::uint16_t channel, std::uint64_t time_ns, std::string_view data);
    void write_decoding(const Decoding& decoding, std::string& out);
    void append(std::string& out, std::string_view bytes);

    DecodedEncoding encoding_;
    DecodedChannels decoded_;
    mcap::ChunkBuilder chunk_;
    mcap::Summary summary_;
    RecordingCounts counts_;
    std::uint64_t position_ = 0;              // bytes of the file
    Crc32 crc_;                               // of these bytes
    std::vector<std::uint32_t> sequences_;    // of the next message, by channel; 0: no Channel record written yet
    std::vector<bool> schemas_;               // by id: whether its record is written
    std::string lost_names_;
    std::uint64_t lost_ = 0;          // not written yet
    std::uint64_t last_ns_ = 0;       // time of the last frame
    std::string message_, record_;    // members only to reuse their memory
};

}    // namespace anogate
