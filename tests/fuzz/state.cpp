// The files of an earlier run: read or rejected, for any content.
#include <control/flexible_control.hpp>
#include <devices/crash_journal.hpp>
#include <managed/managed_parameters.hpp>
#include <runtime/kept_config.hpp>
#include <runtime/restart_state.hpp>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>

namespace {

using namespace anogate;

void must_hold(bool law) {
    if (!law) std::abort();
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string_view bytes{reinterpret_cast<const char*>(data), size};
    const auto kept = parse_kept_config(bytes);
    must_hold(!kept || !bytes.empty());
    parse_restart_state(bytes, {});
    WrittenValues::parse(bytes);
    KeptFlexible::parse(bytes);
    for (const char* name : {"firmware-0xDC-1a2b3c4d.json", "type7-0xDC-1a2b3c4d.json", "calibration-0xDC-1a2b3c4d-compass.json"})
        damage_of_note(name, std::string{bytes});
    return 0;
}
