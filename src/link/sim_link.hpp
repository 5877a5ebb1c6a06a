// A simulated device inside the process, as if it stood behind a port.
#pragma once
#include <gateway/simulated_fc.hpp>
#include <link/alarm.hpp>
#include <link/link_context.hpp>

namespace anogate {

class SimLink final : public Link {
public:
    SimLink(LinkId id, LinkSettings settings, const LinkContext& context);
    void start() override;
    void stop_reading() override { tick_.cancel(); }
    void stop() override { tick_.cancel(); }
    void flush(Channel& channel) override;

private:
    void tick();
    void say(ano::FrameView frame);
    void deliver();

    LinkContext context_;
    Channel* channel_ = nullptr;
    SimulatedFc fc_;
    Alarm tick_;
};

}    // namespace anogate
