#include "wanted_frames.hpp"

#include <anoctl/anoctl.hpp>

#include <ano_json/frame_json.hpp>

#include <cstdint>
#include <variant>

namespace anoctl {
namespace {

using IdSet = std::bitset<256>;

IdSet ids_of(const std::vector<std::string>& words) {
    if (words.empty()) return IdSet{}.set();
    IdSet set;
    for (const std::string& word : words) set.set(message_id_of(word, "--id: "));
    return set;
}

IdSet addresses_of(const char* option, const std::vector<std::string>& words) {
    if (words.empty()) return IdSet{}.set();
    IdSet set;
    for (const std::string& word : words) {
        const auto address = ano::address_called(word);
        if (const auto* fault = std::get_if<ano::JsonFault>(&address)) throw UsageError{std::string{option} + ": " + fault->what};
        set.set(std::get<std::uint8_t>(address));
    }
    return set;
}

}    // namespace

WantedFrames::WantedFrames(const std::vector<std::string>& ids, const std::vector<std::string>& from,
                           const std::vector<std::string>& to)
    : ids_{ids_of(ids)}, from_{addresses_of("--from", from)}, to_{addresses_of("--to", to)} {}

}    // namespace anoctl
