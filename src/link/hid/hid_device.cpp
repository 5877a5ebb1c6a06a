#include <link/hid/hid_device.hpp>

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>

namespace anogate::hid {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view name_prefix = "hidraw";

template <class Number>
std::optional<Number> hex(std::string_view text) {
    Number number = 0;
    const auto [last, bad] = std::from_chars(text.data(), text.data() + text.size(), number, 16);
    return bad == std::errc{} && last == text.data() + text.size() ? std::optional{number} : std::nullopt;
}

/// "0003:00000483:0000A005": bus, vendor, product.
std::optional<UsbId> parse_hid_id(std::string_view text) {
    if (text.size() != 22 || text[4] != ':' || text[13] != ':') return std::nullopt;
    const auto vendor = hex<std::uint32_t>(text.substr(5, 8)), product = hex<std::uint32_t>(text.substr(14));
    if (!vendor || !product || *vendor > 0xFFFF || *product > 0xFFFF) return std::nullopt;
    return UsbId{static_cast<std::uint16_t>(*vendor), static_cast<std::uint16_t>(*product)};
}

/// `folder`: /sys/class/hidraw/hidrawN
std::optional<Device> read_device(const fs::path& folder) {
    Device device;
    device.path = "/dev/" + folder.filename().string();
    std::optional<UsbId> id;
    std::ifstream facts{folder / "device/uevent"};
    for (std::string line; std::getline(facts, line);) {
        const std::string_view text{line};
        if (text.starts_with("HID_ID=")) id = parse_hid_id(text.substr(7));
        if (text.starts_with("HID_NAME=")) device.name = text.substr(9);
    }
    if (!id) return std::nullopt;
    device.id = *id;
    std::ifstream file{folder / "device/report_descriptor", std::ios::binary};
    const std::vector<char> descriptor{std::istreambuf_iterator<char>{file}, {}};
    device.reports = report_sizes({reinterpret_cast<const std::uint8_t*>(descriptor.data()), descriptor.size()});
    return device;
}

std::optional<unsigned> number_of(const fs::path& folder) {
    const std::string name = folder.filename().string();
    unsigned number = 0;
    const char* const end = name.data() + name.size();
    if (!name.starts_with(name_prefix)) return std::nullopt;
    const auto [last, bad] = std::from_chars(name.data() + name_prefix.size(), end, number);
    return bad == std::errc{} && last == end ? std::optional{number} : std::nullopt;
}

}    // namespace

std::optional<UsbId> UsbId::parse(std::string_view text) {
    if (text.size() != 4 && (text.size() != 9 || text[4] != ':')) return std::nullopt;
    const auto vendor = hex<std::uint16_t>(text.substr(0, 4));
    const auto product = text.size() == 4 ? std::nullopt : hex<std::uint16_t>(text.substr(5));
    if (!vendor || (text.size() > 4 && !product)) return std::nullopt;
    return UsbId{*vendor, product};
}

std::vector<Device> devices(const fs::path& root) {
    std::vector<std::pair<unsigned, fs::path>> folders;
    std::error_code ec;
    for (fs::directory_iterator i{root / "sys/class/hidraw", ec}, end; !ec && i != end; i.increment(ec))
        if (const auto number = number_of(i->path())) folders.emplace_back(*number, i->path());
    std::sort(folders.begin(), folders.end());
    std::vector<Device> all;
    for (const auto& [number, folder] : folders)
        if (auto device = read_device(folder)) all.push_back(std::move(*device));
    return all;
}

}    // namespace anogate::hid
