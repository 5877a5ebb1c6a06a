#include <record/mcap/mcap_records.hpp>

#include <algorithm>

namespace anogate::mcap {

void Records::feed(std::string_view bytes) {
    buffer_.erase(0, at_);
    at_ = 0;
    if (fault_ == nullptr) buffer_ += bytes;
}

// Returns true if the magic is complete and correct.
bool Records::read_magic() {
    constexpr std::size_t version_at = 5;
    const std::string_view rest = std::string_view{buffer_}.substr(at_);
    const std::string_view there = rest.substr(0, magic.size()), wanted = magic.substr(0, there.size());
    if (there != wanted) {
        const bool is_other_version = place_ == Place::before && there.substr(0, version_at) == magic.substr(0, version_at);
        fault_ = place_ == Place::at_end ? "it does not end like an MCAP file"
                 : is_other_version      ? "it uses an unsupported version of MCAP"
                                         : "it is not an MCAP file";
        return false;
    }
    if (there.size() < magic.size()) return false;
    at_ += magic.size();
    position_ += magic.size();
    return true;
}

std::optional<Record> Records::next() {
    if (fault_ != nullptr) return std::nullopt;
    if (place_ == Place::before) {
        if (!read_magic()) return std::nullopt;
        place_ = Place::among;
    }
    if (place_ == Place::at_end && read_magic()) place_ = Place::behind;
    if (place_ == Place::behind && unfinished() > 0) fault_ = "there is data after its end";
    if (place_ != Place::among) return std::nullopt;

    std::string_view rest = std::string_view{buffer_}.substr(at_);
    Fields head{rest};
    const auto opcode = head.number<std::uint8_t>();
    if (!head.is_bad() && opcode == 0) {
        fault_ = "it has a record of an unknown type";
        return std::nullopt;
    }
    const auto size = head.number<std::uint64_t>();
    if (!head.is_bad() && size > max_record) {
        fault_ = "a record is longer than 64 MiB";
        return std::nullopt;
    }
    const auto record = next_record(rest);
    if (!record) return std::nullopt;
    at_ += record->whole.size();
    position_ += record->whole.size();
    if (record->opcode == Opcode::footer) place_ = Place::at_end;
    return record;
}

void Records::refuse(const char* why, const Record& record) noexcept {
    at_ -= record.whole.size();
    position_ -= record.whole.size();
    fault_ = why;
}

}    // namespace anogate::mcap
