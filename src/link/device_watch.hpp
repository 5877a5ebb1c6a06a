// Says when device nodes of a name come, go, or change their permissions.
#pragma once
#include <link/descriptor.hpp>

#include <functional>
#include <string>

namespace anogate {

/// Watches /dev itself, not the folders in it. Where that can't be done it is silent for ever.
class DeviceWatch {
public:
    /// `call` comes from the loop, once for all that happened; not after stop().
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
