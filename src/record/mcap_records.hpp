// The records of an MCAP file that comes in pieces. No I/O.
#pragma once
#include <record/mcap_format.hpp>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace anogate::mcap {

/// Nothing in a file makes it take more memory than its largest record, max_record.
class Records {
public:
    /// The next bytes of the file.
    void give(std::string_view bytes);
    /// Valid until the next call.
    std::optional<Record> next();

    /// In a clause; nullptr: it is not damaged.
    const char* fault() const noexcept { return fault_; }
    /// How many bytes of the file were taken: both magics and whole records.
    std::uint64_t position() const noexcept { return position_; }
    std::size_t unfinished() const noexcept { return buffer_.size() - at_; }
    /// Footer and magic were there.
    bool is_ended() const noexcept { return place_ == Place::behind; }
    /// Takes a record that next() gave last back: it is damaged.
    void refuse(const char* why, const Record& record) noexcept;

private:
    enum class Place : std::uint8_t { before, among, at_end, behind };    // the records
    bool take_magic();

    std::string buffer_;
    std::size_t at_ = 0;    // in buffer_: what was taken ends
    std::uint64_t position_ = 0;
    const char* fault_ = nullptr;
    Place place_ = Place::before;
};

}    // namespace anogate::mcap
