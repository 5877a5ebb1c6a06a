// Calls back when device nodes whose names begin with a prefix are added, are removed, or change their permissions.
#pragma once
#include <sys/descriptor.hpp>

#include <functional>
#include <string>

namespace anogate {

/// Watches /dev itself, not its subfolders. Makes no calls if inotify is not available.
class DeviceWatch {
public:
    /// `call` is called from the loop, once for several changes at a time; never after stop().
    DeviceWatch(asio::io_context& io, std::string prefix, std::function<void()> call)
        : descriptor_{io}, prefix_{std::move(prefix)}, call_{std::move(call)} {}

    void start();
    void stop() noexcept { descriptor_.close(); }

private:
    void read();

    Descriptor descriptor_;
    std::string prefix_;
    std::function<void()> call_;
};

}    // namespace anogate
