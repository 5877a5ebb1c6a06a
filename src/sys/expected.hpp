// A value, or the reason why there is none.
#pragma once
#include <string>

#include <tl/expected.hpp>

namespace anogate {

/// A T, or the reason as text for the user. Expected<void>: success, or the reason.
template <class T>
using Expected = tl::expected<T, std::string>;
using Unexpected = tl::unexpected<std::string>;

}    // namespace anogate
