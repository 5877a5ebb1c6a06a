#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <config/unlikely.hpp>
#include <link/device_error.hpp>
#include <link/make_link.hpp>
#include <link/serial/port_identity.hpp>
#include <link/serial/serial_link.hpp>
#include <link/serial/serial_settings.hpp>
#include <link/serial/termios.hpp>
#include <link/v7_keys.hpp>
#include <sys/device_holder.hpp>

#include <algorithm>
#include <cerrno>
#include <limits>

#include <fcntl.h>
#include <sys/file.h>

namespace anogate {
namespace {

/// The error for an absent port, with a suggestion for "ttyUSB0" and "/dev/ttyUSB0:115200", the forms of other programs.
std::string absent_text(const std::string& device) {
    const std::size_t colon = device.rfind(':');
    const bool baud = colon != device.npos && device.size() - colon > 3 &&
                      device.find_first_not_of("0123456789", colon + 1) == device.npos;
    std::string meant = device.find('/') == device.npos ? "/dev/" : "";
    if (meant.empty() && !baud) return device + " not found";
    meant += baud ? device.substr(0, colon) + ",baud=" + device.substr(colon + 1) : device;
    return device + " not found (did you mean " + meant + "?)";
}

constexpr Duration between_looks_for_twin = std::chrono::seconds{5};    // a look reads files of each port

// The other program did not lock the port: each received byte goes to only one of the two.
LinkError of_shared_port(const std::string& device, const DeviceHolder& holder) {
    return {"shared_port",
            holder.text() + " has " + device + " open, too, without a lock, and reads part of the data: stop it",
            {{"device", device}, {"program", holder.program}, {"pid", std::to_string(holder.pid)}}};
}

LinkError of_other_adapter(const std::string& device, const SocketWatch& socket) {
    return {"other_adapter",
            device + " was the adapter in USB port " + socket.from() + " and is now the one in " + socket.to() + "; " +
                socket.twin() +
                " is the same model. Check that this is the right device, and use its /dev/serial/by-path/ name (anoctl ports)",
            {{"device", device}, {"from", socket.from()}, {"to", socket.to()}, {"twin", socket.twin()}}};
}

LinkError of_twin(const std::string& device, const std::string& twin) {
    return {"twin_adapter",
            device + " may lead to either of two adapters: " + twin +
                " is the same model. Check that this is the right device, and use its /dev/serial/by-path/ name (anoctl ports)",
            {{"device", device}, {"twin", twin}}};
}

}    // namespace

Opened<UniqueFd> SerialLink::open_port() {
    const std::string& device = settings().as<SerialSettings>().device;
    UniqueFd fd{::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)};
    if (!fd) return NotOpened{device_not_opened(device, errno, absent_text(device))};
    // Two locks: flock() for programs that use it; TIOCEXCL for all others except root's, where the kernel removes it with us.
    if (::flock(fd.get(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) return NotOpened{device_in_use(device)};
    return fd;
}

// A stored port is not opened again: that would reset many boards through the DTR line.
Opened<UniqueFd> SerialLink::open_wire() {
    const std::string& device = settings().as<SerialSettings>().device;
    auto stored = context_.host.claim_stored(*this);
    const bool is_stored = stored && terminal::is_port_at(stored->wire.get(), device);
    auto fd = is_stored ? Opened<UniqueFd>{std::move(stored->wire)} : open_port();
    if (!fd) return fd;
    terminal::claim(fd->get());
    if (auto ready = make_ready(fd->get(), is_stored); !ready) {
        terminal::release_exclusive(fd->get());
        return NotOpened{device_error("unusable", device + ": " + ready.error(), device)};
    }
    if (is_stored) go_on_from(std::move(*stored));
    else terminal::discard_input(fd->get());
    wire_ = fd->get();
    shared_with_ = device_holder(device, OtherSide::does_not_count);
    socket_.opened("/", device);
    if (socket_.awaits_twin()) twin_again_.set(context_.host.now() + between_looks_for_twin);
    return fd;
}

// Both may have been unplugged, and this one is the first that is back.
void SerialLink::look_for_twin() {
    socket_.look_for_twin("/", settings().as<SerialSettings>().device);
    if (socket_.awaits_twin()) twin_again_.set(context_.host.now() + between_looks_for_twin);
}

LinkError SerialLink::trouble() const {
    const std::string& device = settings().as<SerialSettings>().device;
    if (wire_ < 0) return {};
    if (!socket_.twin().empty()) return of_other_adapter(device, socket_);
    if (shared_with_ && shared_with_->is_there()) return of_shared_port(device, *shared_with_);
    if (!socket_.beside().empty()) return of_twin(device, socket_.beside());
    return {};
}

Expected<void> SerialLink::make_ready(int fd, bool is_stored) {
    const auto baud = terminal::configure(fd, settings().as<SerialSettings>(), is_stored);
    if (!baud) return Unexpected{baud.error()};
    actual_baud_ = *baud;
    return begin_half_duplex(fd);
}

// Closing would wait for the driver's output, so it is discarded. Without such output nothing is discarded: a pseudo-terminal
// may hold data that the other side has not read yet.
void SerialLink::leave_wire(int fd) {
    if (terminal::unsent(fd) > 0 || rs485_) terminal::discard_output(fd);
    if (rs485_) rs485_->close();
    if (rs485_by_driver_) terminal::disable_rs485(fd);
    terminal::release_exclusive(fd);
    twin_again_.cancel();
    wire_ = -1;
}

void SerialLink::half_duplex(bool active_low, std::function<void(bool)> send) {
    rs485_active_low_ = active_low;
    rs485_ = std::make_unique<HalfDuplex>(context_.io, std::move(send));
}

// Enables the driver's own RS-485 control by RTS where it has one. We can't see whether the transceiver is connected to RTS or to the
// configured GPIO line, so the GPIO line is driven as well.
Expected<void> SerialLink::begin_half_duplex(int fd) {
    if (!rs485_) return {};
    rs485_by_driver_ = terminal::enable_rs485_by_rts(fd, rs485_active_low_);
    return rs485_->open(fd, std::chrono::duration_cast<Duration>(std::chrono::nanoseconds{std::nano::den / byte_rate()}));
}

ssize_t SerialLink::write_some(std::span<const iovec> pieces) {
    if (!rs485_) return StreamSession::write_some(pieces);
    rs485_->writing();
    const ssize_t n = StreamSession::write_some(pieces);
    const int error = errno;
    rs485_->written();
    errno = error;
    return n;
}

LinkError SerialLink::why_gone(int error) const { return device_gone(settings().as<SerialSettings>().device, error); }

std::size_t SerialLink::unsent() const {
    if (wire_ < 0) return 0;
    return std::max<std::size_t>(terminal::unsent(wire_), rs485_ && rs485_->is_sending() ? 1 : 0);
}

std::size_t SerialLink::held_by_driver() const { return wire_ < 0 ? 0 : terminal::unsent(wire_); }

std::uint32_t SerialLink::byte_rate() const {
    const SerialSettings& s = settings().as<SerialSettings>();
    return uart_rate(actual_baud_ != 0 ? actual_baud_ : s.baud, s.parity != Parity::none, s.stop_bits);
}

// A USB modem class device (cdc_acm) ignores the rate: it is as fast as USB.
std::uint32_t SerialLink::line_rate() const {
    const Pace pace = settings().as<SerialSettings>().pace;
    const bool is_off = pace == Pace::off && settings().gap == Duration{};    // a gap begins when the frame is on the line
    if (is_off || (pace == Pace::automatic && terminal::driver(fd()) == "cdc_acm")) return 0;
    return byte_rate();
}

LinkFacts SerialLink::facts() const {
    LinkFacts facts{{"device", settings().as<SerialSettings>().device},
                    {"baud", std::int64_t{wire_ < 0 || actual_baud_ == 0 ? settings().as<SerialSettings>().baud : actual_baud_}}};
    if (rs485_) facts.push_back({"rs485", rs485_by_driver_ ? "by the driver and a GPIO line" : "by a GPIO line"});
    if (pacing().rate() > 0) facts.push_back({"paced", std::int64_t{pacing().rate()}});
    add_facts(facts);
    return facts;
}

namespace {

using namespace key_rows;
using Serial = SerialSettings;

constexpr Key<LinkSettings> own_serial_keys[] = {
    text<own<Serial>, &Serial::device>("device", 1, max_path, "path of the port") | as("PATH") | needed,
    integer<own<Serial>, &Serial::baud>("baud", 1, std::numeric_limits<std::uint32_t>::max(),
                                        "baud rate; any rate that the driver supports"),
    choice<own<Serial>, &Serial::parity>("parity", "none|even|odd", "parity bit"),
    integer<own<Serial>, &Serial::stop_bits>("stop_bits", 1, 2, "stop bits"),
    choice<own<Serial>, &Serial::flow>("flow", "none|hardware", "flow control; hardware means RTS/CTS"),
    boolean<own<Serial>, &Serial::low_latency>("low_latency", "ask the driver to deliver bytes without delay"),
    choice<own<Serial>, &Serial::pace>("pace", "auto|on|off",
                                       "send no faster than the baud rate, so that urgent frames can overtake others; auto: "
                                       "off for cdc_acm ports, where the baud rate has no effect"),
    boolean<own<Serial>, &Serial::dtr>("dtr", "set the DTR line on or off (default: left to the driver)"),
    boolean<own<Serial>, &Serial::rts>("rts", "set the RTS line on or off (default: left to the driver)"),
};
constexpr auto serial_keys = with_v7(own_serial_keys, v7_rows<Serial>());

std::string name_of_port(const LinkSettings& link) {
    const std::string& device = link.as<Serial>().device;
    return device.substr(device.rfind('/') + 1);
}

LineRate rate_of_port(const LinkSettings& link) {
    const Serial& s = link.as<Serial>();
    return {uart_rate(s.baud, s.parity != Parity::none, s.stop_bits), s.pace != Pace::off};
}

void validate_serial(const LinkSettings& link, LinkFaults& faults) {
    if (!faults.is_whole()) return;
    check_v7(link.as<Serial>().v7, faults);
    if (std::string fault = fault_of_device(link.as<Serial>().device); !fault.empty()) faults.error("device", std::move(fault));
}

std::optional<SharedByTwo> shared_port(const LinkSettings& a, const LinkSettings& b) {
    const std::string& device = b.as<Serial>().device;
    if (device.empty() || a.as<Serial>().device != device) return std::nullopt;
    return SharedByTwo{"device", "'device' " + in_quotes(device) + " is already used by "};
}

std::string meant_port(std::string_view text) {
    if (text.starts_with("/dev/hidraw")) return "";
    if (text.starts_with('/')) return "'serial:" + std::string{text} + "'";
    return text.substr(0, text.find(',')).starts_with("tty") ? "'serial:/dev/" + std::string{text} + "'" : "";
}

// The driver may control the transceiver by RTS: then RTS must not be used otherwise.
constexpr Rs485 rs485{[](const LinkSettings& link) {
                          const bool is_used = link.as<Serial>().flow != FlowControl::none || link.as<Serial>().rts;
                          return std::string{is_used ? "uses the RTS line by 'flow' or 'rts', which rs485 needs" : ""};
                      },
                      [](Link& link, bool active_low, std::function<void(bool)> send) {
                          static_cast<SerialLink&>(link).half_duplex(active_low, std::move(send));
                      }};

}    // namespace

extern const LinkKind serial_kind;    // listed in kinds.cpp
constinit const LinkKind serial_kind{
    .name = "serial",
    .address = "device",
    .example = "/dev/ttyUSB0",
    .help = "a serial port; if it is absent or unplugged, the link waits for it",
    .carries = Carries::bytes,
    .may_be_paced = true,
    .devices_only = true,
    .number_means = "baud",
    .hints = {.nothing_yet = {"nothing_on_line",
                              "nothing received yet: check that the device is powered and that RX and TX are crossed"},
              .may_wait_for_hello = true,
              .no_frames = {"no_frames_at_baud", "data but no valid frames: check baud rate and protocol"},
              .no_frames_any_more = {"no_frames_at_baud_any_more", ": check baud rate and firmware"}},
    .keys = serial_keys,
    .settings = [] { return KindSettings{Serial{}}; },
    .make = make_link_of<SerialLink>,
    .usual_name = name_of_port,
    .line_rate = rate_of_port,
    .has_uart = [](const LinkSettings&) { return true; },
    .path = [](const LinkSettings& link) { return LinkPath{.path = link.as<Serial>().device}; },
    .rs485 = &rs485,
    .validate = validate_serial,
    .shared = shared_port,
    .meant_by = meant_port,
};

}    // namespace anogate
