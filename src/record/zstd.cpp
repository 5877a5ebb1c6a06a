#include <record/zstd.hpp>

#include <zstd.h>

#include <algorithm>
#include <new>

namespace anogate {
namespace {

constexpr int pack_level = 1;     // at least 400 MB/s, so that a recording keeps up
constexpr int max_window = 26;    // 2^26 bytes; chunks are not larger
constexpr std::size_t unpack_step = 1024 * 1024;

}    // namespace

struct ZstdPacker::Context {
    struct Free {
        void operator()(ZSTD_CCtx* context) const { ZSTD_freeCCtx(context); }
    };
    std::unique_ptr<ZSTD_CCtx, Free> zstd{ZSTD_createCCtx()};
};

ZstdPacker::ZstdPacker() : context_{std::make_unique<Context>()} {
    if (!context_->zstd) throw std::bad_alloc{};
}
ZstdPacker::~ZstdPacker() = default;

void ZstdPacker::pack(std::string_view bytes, std::string& out) {
    const std::size_t before = out.size();
    out.resize(before + ZSTD_compressBound(bytes.size()));
    const std::size_t size = ZSTD_compressCCtx(context_->zstd.get(), out.data() + before, out.size() - before, bytes.data(),
                                               bytes.size(), pack_level);
    if (ZSTD_isError(size)) throw std::bad_alloc{};    // the only possible reason: the buffer is large enough
    out.resize(before + size);
}

std::optional<std::size_t> unpacked_size(std::string_view packed) noexcept {
    const unsigned long long size = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR) return std::nullopt;
    return size;
}

struct ZstdUnpacker::Context {
    struct Free {
        void operator()(ZSTD_DCtx* context) const { ZSTD_freeDCtx(context); }
    };
    std::unique_ptr<ZSTD_DCtx, Free> zstd{ZSTD_createDCtx()};
};

ZstdUnpacker::ZstdUnpacker() : context_{std::make_unique<Context>()} {
    if (!context_->zstd) throw std::bad_alloc{};
    ZSTD_DCtx_setParameter(context_->zstd.get(), ZSTD_d_windowLogMax, max_window);
}
ZstdUnpacker::~ZstdUnpacker() = default;

bool ZstdUnpacker::unpack(std::string_view packed, std::size_t size, std::string& out) {
    out.clear();
    ZSTD_DCtx* const zstd = context_->zstd.get();
    ZSTD_DCtx_reset(zstd, ZSTD_reset_session_only);
    ZSTD_inBuffer in{packed.data(), packed.size(), 0};
    std::size_t left = 1;    // 0: at the end
    while (left != 0) {
        const std::size_t before = out.size(), room = std::min(unpack_step, size - before);
        out.resize(before + room);
        ZSTD_outBuffer to{out.data(), out.size(), before};
        const std::size_t begun = in.pos;
        left = ZSTD_decompressStream(zstd, &to, &in);
        out.resize(to.pos);
        if (ZSTD_isError(left)) return false;
        if (left != 0 && to.pos == before && in.pos == begun) return false;    // incomplete, or longer than `size`
    }
    return in.pos == packed.size() && out.size() == size;
}

}    // namespace anogate
