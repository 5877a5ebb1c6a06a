// Compression by zstd, which no other source knows.
#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace anogate {

class ZstdPacker {
public:
    ZstdPacker();
    ~ZstdPacker();
    ZstdPacker(const ZstdPacker&) = delete;
    ZstdPacker& operator=(const ZstdPacker&) = delete;

    /// Appends `bytes`, packed. Throws std::bad_alloc.
    void pack(std::string_view bytes, std::string& out);

private:
    struct Context;
    std::unique_ptr<Context> context_;
};

class ZstdUnpacker {
public:
    ZstdUnpacker();
    ~ZstdUnpacker();
    ZstdUnpacker(const ZstdUnpacker&) = delete;
    ZstdUnpacker& operator=(const ZstdUnpacker&) = delete;

    /// Makes `out` of what was packed; false: that is not whole, or not `size` bytes long. Takes memory for what it gives only, not for
    /// what is said of its size.
    bool unpack(std::string_view packed, std::size_t size, std::string& out);

private:
    struct Context;
    std::unique_ptr<Context> context_;
};

}    // namespace anogate
