// Splits an MCAP file, passed in parts, into its records. No I/O.
#pragma once
#include <record/mcap/mcap_format.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate::mcap {

/// Memory is bounded by the largest record, max_record.
class Records {
public:
    /// The next bytes of the file.
    void feed(std::string_view bytes);
    /// Valid until the next call.
    std::optional<Record> next();

    /// What is damaged, in a clause; nullptr: nothing.
    const char* fault() const noexcept { return fault_; }
    /// Bytes of the file that were consumed: the magics and complete records.
    std::uint64_t position() const noexcept { return position_; }
    std::size_t unfinished() const noexcept { return buffer_.size() - at_; }
    /// Whether Footer and magic were read.
    bool is_ended() const noexcept { return place_ == Place::behind; }
    /// Undoes the last next(), because its record is damaged.
    void refuse(const char* why, const Record& record) noexcept;

private:
    enum class Place : std::uint8_t { before, among, at_end, behind };    // relative to the records
    bool read_magic();

    std::string buffer_;
    std::size_t at_ = 0;    // end of the consumed part of buffer_
    std::uint64_t position_ = 0;
    const char* fault_ = nullptr;
    Place place_ = Place::before;
};

}    // namespace anogate::mcap
