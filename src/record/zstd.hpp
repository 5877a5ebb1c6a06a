// Compression by zstd. Only zstd.cpp includes the library.
#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace anogate {

class ZstdPacker {
public:
    ZstdPacker();
    ~ZstdPacker();
    ZstdPacker(const ZstdPacker&) = delete;
    ZstdPacker& operator=(const ZstdPacker&) = delete;

    /// Appends `bytes`, compressed. Throws std::bad_alloc.
    void pack(std::string_view bytes, std::string& out);

private:
    struct Context;
    std::unique_ptr<Context> context_;
};

/// The size that `packed` claims to have when it is decompressed; std::nullopt: it is not compressed by ZstdPacker.
std::optional<std::size_t> unpacked_size(std::string_view packed) noexcept;

class ZstdUnpacker {
public:
    ZstdUnpacker();
    ~ZstdUnpacker();
    ZstdUnpacker(const ZstdUnpacker&) = delete;
    ZstdUnpacker& operator=(const ZstdUnpacker&) = delete;

    /// Sets `out` to the decompressed bytes. False: the data are incomplete, or not `size` bytes long. Memory is allocated only
    /// for data that are there, not for a claimed size.
    bool unpack(std::string_view packed, std::size_t size, std::string& out);

private:
    struct Context;
    std::unique_ptr<Context> context_;
};

}    // namespace anogate
