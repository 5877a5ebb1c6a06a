#include <link/hid/hid_report.hpp>

namespace anogate::hid {
namespace {

// The items of a report descriptor that decide the sizes; the two low bits, the length of the data, are 0.
constexpr std::uint8_t input_item = 0x80, output_item = 0x90;
constexpr std::uint8_t size_item = 0x74, id_item = 0x84, count_item = 0x94;
constexpr std::uint8_t push_item = 0xA4, pop_item = 0xB4;
constexpr std::uint8_t long_item = 0xFE;

constexpr std::uint64_t max_bits = 8 * max_report;

struct Sizes {
    std::uint64_t bits = 0, count = 0;    // of one field; fields in a report
};

std::uint64_t number_in(std::span<const std::uint8_t> data) noexcept {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < data.size(); ++i) number |= std::uint64_t{data[i]} << 8 * i;
    return number;
}

bool can_carry_a_stream(std::uint64_t bits) noexcept { return bits >= 16 && bits <= max_bits && bits % 8 == 0; }

}    // namespace

std::optional<ReportSizes> report_sizes(std::span<const std::uint8_t> descriptor) noexcept {
    Sizes sizes, pushed;
    std::uint64_t input = 0, output = 0;
    while (!descriptor.empty()) {
        const std::uint8_t item = descriptor[0];
        if (item == long_item) return std::nullopt;    // reserved
        const std::size_t length = (item & 3) == 3 ? 4 : item & 3;
        if (descriptor.size() < 1 + length) return std::nullopt;
        const std::uint64_t number = number_in(descriptor.subspan(1, length));
        switch (item & 0xFC) {
        case size_item: sizes.bits = number; break;
        case count_item: sizes.count = number; break;
        case id_item: return std::nullopt;
        case push_item: pushed = sizes; break;
        case pop_item: sizes = pushed; break;
        case input_item:
        case output_item:
            if (sizes.bits > max_bits || sizes.count > max_bits) return std::nullopt;
            ((item & 0xFC) == input_item ? input : output) += sizes.bits * sizes.count;
            break;
        default: break;
        }
        descriptor = descriptor.subspan(1 + length);
    }
    if (!can_carry_a_stream(input) || !can_carry_a_stream(output)) return std::nullopt;
    return ReportSizes{static_cast<std::size_t>(input / 8), static_cast<std::size_t>(output / 8)};
}

std::optional<std::span<const std::uint8_t>> bytes_of_report(std::span<const std::uint8_t> report) noexcept {
    if (report.empty() || report[0] >= report.size()) return std::nullopt;
    return report.subspan(1, report[0]);
}

}    // namespace anogate::hid
