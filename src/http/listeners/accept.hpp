// Reads the media types that a client accepts (the header Accept).
#pragma once
#include <optional>
#include <string_view>

namespace anogate::http {

/// The quality of `type` in the header `accept`, in thousandths; std::nullopt: it is not named. Wildcards are ignored. An entry with a
/// version other than `version` counts as another type.
std::optional<unsigned> quality(std::string_view accept, std::string_view type, std::string_view version = {});

}    // namespace anogate::http
