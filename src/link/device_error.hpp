// Why the device of a link can't be opened, or is gone.
#pragma once
#include <link/link_error.hpp>

#include <string>
#include <string_view>

namespace anogate {

/// `id`: of link_error_ids, with the argument `device`.
LinkError device_error(std::string_view id, std::string text, const std::string& device);
/// Another program uses `device`.
LinkError device_in_use(const std::string& device);
/// open() failed with `error`; `absent`: the text if there is no such device.
LinkError device_not_opened(const std::string& device, int error, std::string absent);
/// A read failed with `error`, or reached the end (0).
LinkError device_gone(const std::string& device, int error);

}    // namespace anogate
