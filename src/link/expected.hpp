// A value, or why there is none.
#pragma once
#include <string>

#include <tl/expected.hpp>

namespace anogate {

/// A T, or a clause for the user that says why not. Expected<void> holds nothing: it was done, or why not.
template <class T>
using Expected = tl::expected<T, std::string>;
using Unexpected = tl::unexpected<std::string>;

}    // namespace anogate
