// The message of a call that fails.
#pragma once
#include <string>

namespace support {

/// The message of the Error that `f` throws; "nothing was thrown" if it throws none.
template <class Error, class F>
std::string thrown(F&& f) {
    try {
        f();
    } catch (const Error& e) {
        return e.what();
    }
    return "nothing was thrown";
}

}    // namespace support
