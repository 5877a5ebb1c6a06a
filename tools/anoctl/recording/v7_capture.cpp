#include "v7_capture.hpp"

#include <link/clocks.hpp>

#include <chrono>
#include <utility>

namespace anoctl {
namespace {

anogate::RecordingHead head_now() {
    const anogate::ClockReading clocks = anogate::read_clocks();
    return {"anoctl " ANOGATE_VERSION,
            static_cast<std::uint64_t>(std::chrono::nanoseconds{clocks.real}.count()),
            static_cast<std::uint64_t>(std::chrono::nanoseconds{clocks.boot}.count()),
            {}};
}

}    // namespace

V7Capture::V7Capture(const std::string& path, bool force, std::string link, Streams& streams)
    : output_{path, force, streams}, link_{std::move(link)}, writer_{head_now(), waiting_} {
    write();
}

V7Capture::~V7Capture() {
    writer_.end(waiting_);
    write();
    output_.sync();
}

void V7Capture::add(ano::v7::FrameView frame, anogate::Direction direction, std::uint64_t time_ns) {
    writer_.write_v7(frame, link_, direction, time_ns, waiting_);
    write();
}

void V7Capture::write() {
    output_.write(waiting_);
    waiting_.clear();
}

}    // namespace anoctl
