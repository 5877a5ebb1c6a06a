// A flight controller made of arithmetic: for demonstrations, tests and development. Bytes and a time in, bytes out.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <device/device.hpp>
#include <gateway/simulated_setup.hpp>

#include <array>
#include <functional>

namespace anogate {

/// Bears 0xDC. Hovers, sways a little and slowly empties its battery; answers as a device does, and can be set and commanded.
class SimulatedFc {
public:
    using Send = std::function<void(ano::FrameView)>;

    /// `rate`: attitude and inertial frames a second, 1 to 100.
    SimulatedFc(unsigned rate, ano::TimePoint start);

    /// Sends every telemetry frame that is due at `now`. After a pause it goes on from `now`: nothing is made up for.
    void run(ano::TimePoint now, const Send& send);
    ano::TimePoint next() const noexcept;
    /// A frame came in, for whomever.
    void receive(ano::FrameView frame, ano::TimePoint now, const Send& send);

private:
    struct Stream {
        void (SimulatedFc::*make)(double, const Send&) const;
        ano::Duration period;
        ano::TimePoint next;
    };
    void inertial(double t, const Send&) const;
    void euler(double t, const Send&) const;
    void altitude(double t, const Send&) const;
    void mode(double t, const Send&) const;
    void velocity(double t, const Send&) const;
    void power(double t, const Send&) const;

    ano::device::Device device_;
    SimulatedSetup setup_{device_};
    ano::TimePoint start_;
    std::array<Stream, 6> streams_;
};

}    // namespace anogate
