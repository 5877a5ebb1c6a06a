#include <record/mcap/mcap_writer.hpp>
#include <record/pcapng_writer.hpp>
#include <record/recording_writer.hpp>

#include <ano_json/lower_case.hpp>

#include <iterator>

namespace anogate {
namespace {

constexpr std::string_view names[] = {"pcapng", "mcap"};

}    // namespace

std::string_view text(RecordingFormat format) noexcept { return names[static_cast<std::size_t>(format)]; }

std::optional<RecordingFormat> recording_format_of(std::string_view file) {
    const std::size_t dot = file.rfind('.');
    if (dot == std::string_view::npos) return std::nullopt;
    const std::string ending = ano::lower_case(file.substr(dot + 1));
    for (std::size_t i = 0; i < std::size(names); ++i)
        if (ending == names[i]) return static_cast<RecordingFormat>(i);
    return std::nullopt;
}

std::unique_ptr<RecordingWriter> make_recording_writer(RecordingFormat format, const RecordingHead& head, std::string& out,
                                                       RecordingOptions options) {
    if (format == RecordingFormat::mcap) return std::make_unique<McapWriter>(head, out, options);
    return std::make_unique<PcapngWriter>(head, out);
}

}    // namespace anogate
