// Batches of records: their JSON, one per line, compressed by zstd. No I/O.
#pragma once
#include <mqtt/telemetry.hpp>
#include <record/zstd.hpp>

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct Batch {
    Keep keep = Keep::normal;
    std::uint64_t records = 0;
    std::uint64_t time_s = 0;    // since 1970, of its first record
    std::string body;            // compressed, at most max_payload bytes
};

class BatchPacker {
public:
    /// Bytes before compression. Even what can't be compressed fits max_payload.
    static constexpr std::size_t max_lines = 62 * 1024;

    /// Batches of `records` in their order, each with records of one class. A record larger than max_lines is left out.
    std::vector<Batch> pack(std::span<const Record> records);

private:
    void close(Batch& batch, std::string& lines, std::vector<Batch>& out);
    ZstdPacker packer_;
};

class BatchUnpacker {
public:
    /// The lines of a batch; std::nullopt: it is damaged or too large. Valid until the next call.
    std::optional<std::string_view> unpack(std::string_view body);

private:
    ZstdUnpacker unpacker_;
    std::string lines_;
};

}    // namespace anogate
