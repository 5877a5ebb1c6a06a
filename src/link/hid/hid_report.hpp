// The reports of USB devices of class HID that carry a byte stream: the first byte of each is the number of bytes that follow, 0 to
// 63; the rest is not used. Older ANO radios and LX units have no other USB connection.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

namespace anogate::hid {

/// A full-speed device has no longer reports.
constexpr std::size_t max_report = 64;
/// Radios that pass each report on over the air ignore those with more bytes.
constexpr std::size_t max_sent_bytes = 32;

/// The sizes of a device's reports in bytes: sent by the device, and sent to it.
struct ReportSizes {
    std::size_t input = 0, output = 0;
    bool operator==(const ReportSizes&) const = default;
};

/// `descriptor`: the report descriptor (USB HID 1.11, section 6.2.2). std::nullopt if it is damaged, or if the device has reports with
/// ids, or reports that can't carry a stream.
std::optional<ReportSizes> report_sizes(std::span<const std::uint8_t> descriptor) noexcept;

/// The bytes of the stream in a report from the device; std::nullopt: its first byte is larger than the rest of it.
std::optional<std::span<const std::uint8_t>> bytes_of_report(std::span<const std::uint8_t> report) noexcept;

/// The most bytes that a report to the device may have.
constexpr std::size_t bytes_per_report(std::size_t report_size) noexcept {
    return report_size - 1 < max_sent_bytes ? report_size - 1 : max_sent_bytes;
}

}    // namespace anogate::hid
