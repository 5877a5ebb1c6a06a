// Frames to JSON and back: the bytes are equal. Any text as the JSON of a frame: a frame, or an error in one line of UTF-8; and
// the resulting frame is again converted without change. A first byte of '{' or '[' begins text, everything else is id, then
// DATA.
#include <ano_json/frame_json.hpp>

#include <nlohmann/json.hpp>

#include <cstdint>
#include <cstdlib>
#include <string>
#include <variant>
#include <vector>

namespace {

using namespace ano;
using FrameBytes = std::vector<std::uint8_t>;

void must(bool law) {
    if (!law) std::abort();
}

void survives(const FrameBytes& bytes) {
    const auto frame = frame_at(bytes);
    must(frame.has_value());
    for (const Encoding encoding : {Encoding::utf8, Encoding::gbk, Encoding::automatic}) {
        const Json read = Json::parse(frame_to_json(*frame, {nullptr, encoding}).dump());
        const auto again = frame_from_json(read);
        must(std::holds_alternative<FrameBytes>(again) && std::get<FrameBytes>(again) == bytes);
    }
}

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* input, std::size_t size) {
    if (size == 0) return 0;
    if (input[0] != '{' && input[0] != '[') {
        FrameBytes bytes(overhead + size - 1);
        if (encode(bytes, 0xDC, 0xFE, input[0], {input + 1, size - 1}) == bytes.size()) survives(bytes);
        return 0;
    }
    const Json json = Json::parse(input, input + size, nullptr, false);
    if (json.is_discarded()) return 0;
    const auto made = frame_from_json(json);
    if (const auto* fault = std::get_if<JsonFault>(&made)) {
        must(!fault->what.empty() && fault->what.find('\n') == std::string::npos);
        must(from_utf8(fault->what, Encoding::utf8).has_value());
    } else {
        survives(std::get<FrameBytes>(made));
    }
    return 0;
}
