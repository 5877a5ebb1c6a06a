// A serial port. Absent, unplugged, in use: waited for.
#pragma once
#include <link/stream_link.hpp>

namespace anogate {

class SerialLink final : public StreamLink {
public:
    using StreamLink::StreamLink;
    std::size_t unsent() const override;
    LinkFacts facts() const override;

private:
    Opened open_wire() override;
    const std::string& peer() const override { return settings().serial.device; }
    std::uint32_t line_rate() const override;
    std::size_t held_by_driver() const override { return unsent(); }
    void leave_wire(int fd) override;
    std::string gone_text(int error) const override;

    int wire_ = -1;    // the open descriptor; -1: none
    std::uint32_t actual_baud_ = 0;
};

}  // namespace anogate
