// Reads the frames of a pcapng file, no matter which program wrote it, in either byte order. No I/O.
//
// Memory is bounded by the largest block, max_block, and the names of the links in the file.
#pragma once
#include <record/recording_reader.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class PcapngReader final : public RecordingReader {
public:
    static constexpr std::size_t max_block = 16 * 1024 * 1024;
    static constexpr std::size_t max_interfaces = 65536;

    void feed(std::string_view bytes) override;
    std::optional<Recorded> next() override;

    RecordingFormat format() const noexcept override { return RecordingFormat::pcapng; }
    const char* fault() const noexcept override { return fault_; }
    SkippedParts skipped() const override { return skipped_; }
    /// The end of the last intact block.
    std::uint64_t good_end() const noexcept { return good_end_; }
    std::uint64_t position() const noexcept override { return position_; }
    std::size_t unfinished() const noexcept override { return buffer_.size() - at_; }

    /// The head of the current section.
    const RecordingHead& head() const noexcept override { return head_; }
    bool has_end() const noexcept override { return has_end_; }
    std::uint64_t foreign() const noexcept override { return foreign_; }
    bool is_strange() const noexcept override { return has_strangers_ && !has_ours_; }

private:
    using Bytes = std::span<const std::uint8_t>;
    struct Interface {
        std::string name, description;
        bool ours = false;               // LINKTYPE_USER0
        std::uint64_t per_second = 0;    // units of its timestamps; 0: not supported
        std::uint64_t offset_s = 0;      // modulo 2^64
    };
    struct Option {
        std::uint16_t code;
        Bytes value;
    };

    std::uint16_t u16(Bytes bytes, std::size_t at) const noexcept;
    std::uint32_t u32(Bytes bytes, std::size_t at) const noexcept;
    std::uint64_t u64(Bytes bytes, std::size_t at) const noexcept;
    std::optional<Option> next_option(Bytes& options) const noexcept;

    std::optional<Bytes> read_block(std::uint32_t& type);
    void begin_section(Bytes body);
    void add_interface(Bytes body);
    void end_interface(Bytes body);
    void read_packet(Bytes body);
    void read_options(Bytes options, RecordedFrame& frame);
    void read_comment(std::string_view text, RecordedFrame& frame);
    void damage(const char* what) noexcept { fault_ = what; }
    void skip(const char* why, bool is_packet);

    std::string buffer_;
    std::size_t at_ = 0;    // end of the part of buffer_ that was read
    std::uint64_t position_ = 0;
    const char* fault_ = nullptr;
    std::size_t block_size_ = 0;    // of the last block
    std::uint64_t good_end_ = 0;
    SkippedParts skipped_;

    bool begun_ = false, swapped_ = false, has_end_ = false;
    bool has_ours_ = false, has_strangers_ = false;    // interfaces of LINKTYPE_USER0, of others
    RecordingHead head_;
    std::vector<Interface> interfaces_;
    std::array<std::string, 256> peers_;
    std::uint64_t foreign_ = 0;
    std::optional<RecordedLoss> loss_;      // of the last block
    std::optional<RecordedFrame> frame_;    // of the last block, after its loss
};

}    // namespace anogate
