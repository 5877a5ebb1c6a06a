#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/device_error.hpp>
#include <link/hid/hid_device.hpp>
#include <link/hid/hid_link.hpp>
#include <link/make_link.hpp>
#include <link/v7_keys.hpp>

#include <fcntl.h>
#include <linux/hidraw.h>
#include <sys/file.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>

namespace anogate {
namespace {

bool is_path(const std::string& device) { return device.starts_with('/'); }

std::optional<hid::ReportSizes> report_sizes_of(int fd) {
    int size = 0;
    hidraw_report_descriptor descriptor{};
    if (::ioctl(fd, HIDIOCGRDESCSIZE, &size) != 0 || size < 0 || size > HID_MAX_DESCRIPTOR_SIZE) return std::nullopt;
    descriptor.size = static_cast<__u32>(size);
    if (::ioctl(fd, HIDIOCGRDESC, &descriptor) != 0) return std::nullopt;
    return hid::report_sizes({descriptor.value, descriptor.size});
}

}    // namespace

// A device that is named by its id has another number after each plugging in.
Opened<std::string> HidLink::find_device() const {
    const std::string& device = settings().as<HidSettings>().device;
    if (is_path(device)) return device;
    const auto wanted = hid::UsbId::parse(device);
    std::vector<std::string> found;
    for (const hid::Device& one : hid::devices("/"))
        if (wanted && wanted->matches(one.id) && one.reports) found.push_back(one.path);
    if (found.empty()) return NotOpened{device_error("absent", "no HID device " + device + " with a byte stream found", device)};
    if (found.size() == 1) return found.front();
    std::string all;
    for (const std::string& path : found) all += (all.empty() ? "" : ", ") + path;
    return NotOpened{device_error("unusable", all + " are all HID devices " + device + ": name one by its path", device)};
}

Opened<UniqueFd> HidLink::open_wire() {
    auto path = find_device();
    if (!path) return NotOpened{std::move(path.error())};
    UniqueFd fd{::open(path->c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)};
    if (!fd) return NotOpened{device_not_opened(*path, errno, *path + " not found")};
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return NotOpened{device_in_use(*path)};
    const auto sizes = report_sizes_of(fd.get());
    if (!sizes)
        return NotOpened{device_error(
            "unusable", *path + " is not a hidraw device with a byte stream; `anoctl ports` lists the devices", *path)};
    if (auto opened = writer_.open(fd.get(), sizes->output); !opened)
        return NotOpened{device_error("unusable", *path + ": " + opened.error(), *path)};
    path_ = std::move(*path);
    rest_ = {};
    return fd;
}

// Each read() returns one report. What the room can't take is left to the next call.
ssize_t HidLink::read_some(std::span<std::uint8_t> room) {
    std::size_t filled = 0;
    for (;;) {
        const std::size_t taken = std::min(rest_.size(), room.size() - filled);
        std::copy_n(rest_.begin(), taken, room.subspan(filled).begin());
        rest_ = rest_.subspan(taken);
        filled += taken;
        if (filled == room.size()) return static_cast<ssize_t>(filled);
        const ssize_t n = ::read(fd(), report_.data(), report_.size());
        if (n <= 0) return filled > 0 ? static_cast<ssize_t>(filled) : n;
        const auto bytes = hid::bytes_of_report(std::span{report_}.first(static_cast<std::size_t>(n)));
        if (bytes) rest_ = *bytes;
        else ++bad_reports_;
    }
}

void HidLink::write_later() {
    writer_.when_writable([this] { write(); });
}

// The writer may use the device for some seconds more; the lock must not last as long.
void HidLink::leave_wire(int fd) {
    ::flock(fd, LOCK_UN);
    writer_.close();
}

LinkError HidLink::why_gone(int error) const { return device_gone(path_, error == EPIPE ? ENODEV : error); }

LinkFacts HidLink::facts() const {
    LinkFacts facts{{"device", settings().as<HidSettings>().device}};
    if (!path_.empty() && path_ != settings().as<HidSettings>().device) facts.push_back({"path", path_});
    if (bad_reports_ > 0) facts.push_back({"bad_reports", bad_reports_});
    if (writer_.failed_reports() > 0) facts.push_back({"failed_reports", static_cast<std::int64_t>(writer_.failed_reports())});
    if (pacing().rate() > 0) facts.push_back({"paced", std::int64_t{pacing().rate()}});
    add_facts(facts);
    return facts;
}

namespace {

using namespace key_rows;

constexpr Key<LinkSettings> own_hid_keys[] = {
    text<own<HidSettings>, &HidSettings::device>("device", 1, max_path,
                                                 "path of the device, or its USB id: VENDOR or VENDOR:PRODUCT, four hexadecimal "
                                                 "digits each") |
        as("PATH|ID") | needed,
};
constexpr auto hid_keys = with_v7(own_hid_keys, v7_rows<HidSettings>());

void validate_hid(const LinkSettings& link, LinkFaults& faults) {
    if (!faults.is_whole()) return;
    check_v7(link.as<HidSettings>().v7, faults);
    const std::string& device = link.as<HidSettings>().device;
    if (!is_path(device) && !hid::UsbId::parse(device))
        faults.error("device", in_quotes(device) + " is neither a path such as /dev/hidraw0 nor a USB id such as 0483:A005");
}

std::optional<SharedByTwo> shared_hid(const LinkSettings& a, const LinkSettings& b) {
    const std::string& device = b.as<HidSettings>().device;
    if (device.empty() || a.as<HidSettings>().device != device) return std::nullopt;
    return SharedByTwo{"device", "'device' " + in_quotes(device) + " is already used by "};
}

}    // namespace

extern const LinkKind hid_kind;    // listed in kinds.cpp
constinit const LinkKind hid_kind{
    .name = "hid",
    .address = "device",
    .example = "/dev/hidraw0",
    .help = "a USB device of class HID, as older radios and LX units are; if it is absent or unplugged, the link waits for it",
    .carries = Carries::bytes,
    .may_be_paced = true,
    .devices_only = true,
    .hints = {.nothing_yet = {"nothing_from_device", "nothing received yet: check that the device is powered"}},
    .keys = hid_keys,
    .settings = [] { return KindSettings{HidSettings{}}; },
    .make = make_link_of<HidLink>,
    .usual_name =
        [](const LinkSettings& link) {
            const std::string& device = link.as<HidSettings>().device;
            return is_path(device) ? device.substr(device.rfind('/') + 1) : std::string{"hid"};
        },
    .has_uart = [](const LinkSettings&) { return true; },    // their parsers are those of serial ports
    .path = [](const LinkSettings& link) { return LinkPath{.path = link.as<HidSettings>().device, .noun = "hidraw device"}; },
    .validate = validate_hid,
    .shared = shared_hid,
    .meant_by =
        [](std::string_view text) { return text.starts_with("/dev/hidraw") ? "'hid:" + std::string{text} + "'" : std::string{}; },
};

}    // namespace anogate
