// What form of an answer a client wants.
#pragma once
#include <optional>
#include <string_view>

namespace anogate::http {

/// How much the Accept header `accept` wants `type`, in thousandths; nothing: it does not name it. Wildcards name nothing. An entry
/// with a version other than `version` is another type.
std::optional<unsigned> quality(std::string_view accept, std::string_view type, std::string_view version = {});

}    // namespace anogate::http
