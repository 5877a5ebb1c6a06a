// Compares secrets.
#pragma once
#include <cstddef>
#include <string_view>

namespace anogate::http {

/// Its duration does not depend on where the texts differ. `known` must not be empty.
inline bool is_same_token(std::string_view known, std::string_view given) {
    unsigned different = known.size() == given.size() ? 0u : 1u;
    for (std::size_t i = 0; i < given.size(); ++i)
        different |= static_cast<unsigned>(static_cast<unsigned char>(known[i % known.size()]) ^
                                           static_cast<unsigned char>(given[i]));
    return different == 0;
}

}    // namespace anogate::http
