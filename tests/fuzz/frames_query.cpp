// The query of GET /frames, as text: it is parsed or rejected with a message, and a parsed query filters frames.
#include <ano_json/text.hpp>
#include <http/target.hpp>
#include <watch/frame_filter.hpp>

#include <support/bytes.hpp>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <string_view>
#include <variant>

namespace {

using namespace anogate;

void require(bool holds) {
    if (!holds) std::abort();
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    constexpr std::string_view links[] = {"fc", "ground", "control"};
    const auto query = http::parse_query({reinterpret_cast<const char*>(data), size});
    if (!query) return 0;
    const auto parsed = parse_frame_query(*query, links);
    if (const auto* wrong = std::get_if<std::string>(&parsed)) {
        require(!wrong->empty() && wrong->find('\n') == std::string::npos);
        return 0;
    }
    const FrameFilterSettings& settings = std::get<FrameQuery>(parsed).filter;
    FrameFilter filter{settings};
    static const support::Bytes frames[] = {support::frame(0xDC, 0xFE, 0x03, {1}), support::frame(0xFE, 0xDC, 0xE0, {0, 1, 0})};
    for (const support::Bytes& bytes : frames) {
        const ano::FrameView frame{bytes};
        const bool is_meant = settings.ids[frame.id()] && settings.from[frame.source()] && settings.to[frame.destination()] &&
                              settings.directions[0];
        require(filter.takes(Direction::in, 0, frame, ano::TimePoint{}) == is_meant);    // no limit withholds the first frame
    }
    require(!query->empty() || settings == FrameFilterSettings{});
    return 0;
}
