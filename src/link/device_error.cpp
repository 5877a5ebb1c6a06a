#include <link/device_error.hpp>
#include <sys/device_holder.hpp>
#include <sys/device_permission.hpp>
#include <sys/errors.hpp>

#include <filesystem>
#include <utility>

namespace anogate {
namespace {

std::string not_permitted_text(const std::string& device) {
    std::error_code ec;
    const std::string real = std::filesystem::canonical(device, ec).string();
    const std::string missing = ec ? std::string{} : missing_permission("/", real, DeviceUser::this_process());
    return device + ": no permission" + (missing.empty() ? "" : ": " + missing);
}

}    // namespace

LinkError device_error(std::string_view id, std::string text, const std::string& device) {
    return {id, std::move(text), {{"device", device}}};
}

LinkError device_in_use(const std::string& device) {
    const auto holder = device_holder(device);
    return device_error("in_use", device + " is in use by " + (holder ? holder->text() : "another program"), device);
}

LinkError device_not_opened(const std::string& device, int error, std::string absent) {
    switch (error) {
    case ENOENT:
    case ENXIO:
    case ENODEV: return device_error("absent", std::move(absent), device);
    case EBUSY: return device_in_use(device);
    case EACCES: return device_error("no_permission", not_permitted_text(device), device);
    default: return error_text(device, error);
    }
}

LinkError device_gone(const std::string& device, int error) {
    if (error == 0 || error == EIO || error == ENXIO || error == ENODEV)
        return device_error("unplugged", device + " was unplugged", device);
    return error_text(device, error);
}

}    // namespace anogate
