// A capture of frames of protocol version 7, as pcapng for Wireshark.
#pragma once
#include <ano/v7.hpp>
#include <anoctl/recording/recording_output.hpp>
#include <record/pcapng_writer.hpp>

#include <cstdint>
#include <string>

namespace anoctl {

class V7Capture {
public:
    /// `path`, `force` and the errors as of RecordingOutput; `link`: the name of the only link.
    V7Capture(const std::string& path, bool force, std::string link, Streams& streams);
    /// Ends the capture.
    ~V7Capture();
    V7Capture(const V7Capture&) = delete;
    V7Capture& operator=(const V7Capture&) = delete;

    /// `time_ns`: since 1970.
    void add(ano::v7::FrameView frame, anogate::Direction direction, std::uint64_t time_ns);
    /// Why the file can't be written any more; empty: no fault.
    const std::string& fault() const noexcept { return output_.fault(); }

private:
    void write();

    RecordingOutput output_;
    std::string link_;
    std::string waiting_;
    anogate::PcapngWriter writer_;
};

}    // namespace anoctl
