#include <record/mcap/mcap_reader.hpp>
#include <record/pcapng_reader.hpp>
#include <record/recording_reader.hpp>

namespace anogate {

std::unique_ptr<RecordingReader> make_recording_reader(std::string_view begin) {
    if (!begin.empty() && begin.front() == mcap::magic.front()) return std::make_unique<McapReader>();
    return std::make_unique<PcapngReader>();
}

}    // namespace anogate
