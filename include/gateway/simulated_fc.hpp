// A flight controller made of arithmetic: for demonstrations, tests and development. Bytes and a time in, bytes out.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>

#include <array>
#include <functional>

namespace anogate {

/// Bears 0xDC. Hovers, sways a little and slowly empties its battery; answers who it is.
class SimulatedFc {
public:
    using Send = std::function<void(ano::FrameView)>;

    /// `rate`: attitude and inertial frames a second, 1 to 100.
    SimulatedFc(unsigned rate, ano::TimePoint start);

    /// Sends every telemetry frame that is due at `now`. After a pause it goes on from `now`: nothing is made up for.
    void run(ano::TimePoint now, const Send& send);
    ano::TimePoint next() const noexcept;
    /// Answers a frame that is for it (0xE0 with cmd 0, addressed or broadcast).
    void receive(ano::FrameView frame, const Send& send) const;

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

    ano::TimePoint start_;
    std::array<Stream, 6> streams_;
};

}    // namespace anogate
