// A serial port. The link waits while the port is absent, unplugged or in use.
#pragma once
#include <link/serial/half_duplex.hpp>
#include <link/serial/port_identity.hpp>
#include <link/serial/serial_settings.hpp>
#include <link/stream_link.hpp>
#include <sys/alarm.hpp>
#include <sys/device_holder.hpp>

#include <memory>
#include <optional>
#include <utility>

namespace anogate {

class SerialLink final : public StreamLink, public KernelQueue, public StorableLink {
public:
    SerialLink(LinkId id, LinkSettings settings, const LinkContext& context)
        : StreamLink{id, std::move(settings), context}, twin_again_{context.alarms, [this] { look_for_twin(); }} {
        translate(this->settings().as<SerialSettings>().v7, this->settings());
    }
    std::size_t unsent() const override;
    /// To be called before start() for RS-485: `send(true)` switches the transceiver to sending, `send(false)` back.
    void half_duplex(bool active_low, std::function<void(bool)> send);
    LinkFacts facts() const override;
    LinkError trouble() const override;
    int storable_wire() const override { return wire_; }

private:
    Opened<UniqueFd> open_wire() override;
    const std::string& peer() const override { return settings().as<SerialSettings>().device; }
    ssize_t write_some(std::span<const iovec> pieces) override;
    Opened<UniqueFd> open_port();
    Expected<void> make_ready(int fd, bool is_stored);
    Expected<void> begin_half_duplex(int fd);
    std::uint32_t byte_rate() const;
    std::uint32_t line_rate() const override;
    std::size_t held_by_driver() const override;
    void leave_wire(int fd) override;
    void look_for_twin();
    LinkError why_gone(int error) const override;

    int wire_ = -1;    // the open descriptor; -1: none
    std::uint32_t actual_baud_ = 0;
    std::optional<DeviceHolder> shared_with_;    // another program that has the port open
    SocketWatch socket_;
    Alarm twin_again_;

    std::unique_ptr<HalfDuplex> rs485_;    // nullptr: full duplex
    bool rs485_active_low_ = false;
    bool rs485_by_driver_ = false;    // the driver also switches the transceiver, by RTS
};

}    // namespace anogate
