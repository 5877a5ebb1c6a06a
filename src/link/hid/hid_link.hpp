// A USB device of class HID whose reports carry a byte stream. The link waits while the device is absent, unplugged or in use.
#pragma once
#include <link/hid/hid_report.hpp>
#include <link/hid/hid_settings.hpp>
#include <link/hid/hid_writer.hpp>
#include <link/stream_link.hpp>

#include <array>

namespace anogate {

class HidLink final : public StreamLink, public KernelQueue {
public:
    HidLink(LinkId id, LinkSettings settings, const LinkContext& context)
        : StreamLink{id, std::move(settings), context}, writer_{context.io} {
        translate(this->settings().as<HidSettings>().v7, this->settings());
    }
    std::size_t unsent() const override { return writer_.has_unsent() ? 1 : 0; }
    LinkFacts facts() const override;

private:
    Opened<UniqueFd> open_wire() override;
    const std::string& peer() const override { return settings().as<HidSettings>().device; }
    ssize_t read_some(std::span<std::uint8_t> room) override;
    ssize_t write_some(std::span<const iovec> pieces) override { return writer_.write_some(pieces); }
    void write_later() override;
    void leave_wire(int fd) override;
    LinkError why_gone(int error) const override;

    Opened<std::string> find_device() const;

    std::string path_;    // of the open device
    HidWriter writer_;
    std::array<std::uint8_t, hid::max_report> report_{};    // the last one received
    std::span<const std::uint8_t> rest_;                    // of its bytes: not delivered yet
    std::int64_t bad_reports_ = 0;                          // received, with an impossible first byte
};

}    // namespace anogate
