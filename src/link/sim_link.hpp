// A simulated device inside the process, as if it were connected.
#pragma once
#include <link/link_context.hpp>
#include <link/raw_port.hpp>
#include <link/v7_edge.hpp>
#include <sys/alarm.hpp>
#include <world/faulty_line.hpp>

#include <memory>
#include <span>
#include <vector>

namespace anogate {

class SimLink final : public Link, public RawPort {
public:
    SimLink(LinkId id, LinkSettings settings, const LinkContext& context);
    void start() override;
    void stop_reading() override { stop(); }
    void stop() override;
    void flush(Channel& channel) override;
    LinkFacts facts() const override;

private:
    void set_tap(RawTap* tap) override { tap_ = tap; }
    bool write_raw(std::span<const std::uint8_t> bytes) override;
    void send_to_device(std::span<const std::uint8_t> bytes);
    void set_alarms();
    void tick();
    void answer();
    void receive(std::span<const std::uint8_t> received);
    void write_v7();

    LinkContext context_;
    Channel* channel_ = nullptr;
    RawTap* tap_ = nullptr;
    std::unique_ptr<V7Edge> v7_;    // nullptr: the device uses V8
    std::unique_ptr<ano::world::FaultyLine> line_;
    ano::world::FaultyLine::Send send_;          // to the gateway
    ano::world::FaultyLine::Send send_later_;    // in another turn of the loop
    std::vector<std::uint8_t> answers_;          // waiting for answer()
    Alarm tick_;
    Alarm answer_;
};

}    // namespace anogate
