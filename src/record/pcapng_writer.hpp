// A recording as pcapng, which Wireshark opens. No I/O.
//
// Flow:    std::string bytes;
//          PcapngWriter writer{head, bytes};
//          writer.write(frame, bytes); ...    // append; each call appends whole blocks, so a file may be cut behind any of them
//          writer.end(bytes);
#pragma once
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

    /// Appends a frame, and its link when that is new. `peer` without `channel` is not kept.
    void write(const RecordedFrame& frame, std::string& out) override;
    void write(const RecordedLoss& loss) override;
    void flush(std::string&) override {}    // it holds nothing back
    void end(std::string& out) override;

private:
    struct Interface {
        std::uint64_t frames = 0;
        std::uint64_t last_ns = 0;
    };
    std::uint32_t interface_of(const RecordedFrame& frame, std::string& out);
    void append_comments(const RecordedFrame& frame, std::string& out);
    std::string take_lost_names();

    std::vector<Interface> interfaces_;
    std::map<std::string, std::uint32_t, std::less<>> numbers_;    // of them, by name
    std::array<std::string, 256> peers_;                           // that were told, by the number of the channel
    std::uint64_t lost_ = 0;                                       // not told yet
    std::string lost_names_;
    std::uint64_t all_lost_ = 0;
};

}    // namespace anogate
