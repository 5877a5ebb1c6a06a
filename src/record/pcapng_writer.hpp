// Writes a recording as pcapng, for Wireshark. No I/O.
//
// Flow:    std::string bytes;
//          PcapngWriter writer{head, bytes};
//          writer.write(frame, bytes); ...    // appends complete blocks, so a file may be cut after any call
//          writer.end(bytes);
#pragma once
#include <ano/v7.hpp>
#include <record/recording_writer.hpp>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class PcapngWriter final : public RecordingWriter {
public:
    /// Appends the head of the file to `out`.
    PcapngWriter(const RecordingHead& head, std::string& out);

    /// Appends a frame, preceded by its link if that is new. `peer` is written only with `channel`.
    void write(const RecordedFrame& frame, std::string& out) override;
    /// Appends a frame of protocol version 7, which no other format can store. `direction`: in or out.
    void write_v7(ano::v7::FrameView frame, std::string_view link, Direction direction, std::uint64_t time_ns, std::string& out);
    void write(const RecordedLoss& loss) override;
    void use(const DecodingPtr& decoding, std::string&) override { decoding_ = decoding ? decoding->text() : "{}"; }
    void flush(std::string&) override {}    // everything is appended at once
    void end(std::string& out) override;

private:
    struct Interface {
        std::uint64_t frames = 0;
        std::uint64_t last_ns = 0;
    };
    /// The number of the interface of a packet that is written now.
    std::uint32_t count_packet(std::string_view link, std::string_view description, std::uint64_t time_ns, std::string& out);
    std::uint32_t interface_of(std::string_view link, std::string_view description, std::string& out);
    std::string pop_lost_names();

    std::vector<Interface> interfaces_;
    std::map<std::string, std::uint32_t, std::less<>> numbers_;    // index in interfaces_, by name
    std::array<std::string, 256> peers_;                           // by channel number: the peer already written
    std::string decoding_;                                         // not written yet
    std::uint64_t lost_ = 0;                                       // not written yet
    std::string lost_names_;
    std::uint64_t all_lost_ = 0;
};

}    // namespace anogate
