// CPU time per frame of a gateway, between two moments.
#pragma once
#include "forwarder.hpp"
#include "goals.hpp"
#include "processes.hpp"

#include <cstdint>

namespace bench {

/// CPU time and frames of a gateway so far.
struct Used {
    explicit Used(const Forwarder& of) : frames{of.frames()}, cpu{cpu_seconds(of.pid())} {}
    std::uint64_t frames;
    double cpu;
};

inline double microseconds_a_frame(const Used& before, const Used& after) {
    return (after.cpu - before.cpu) * 1e6 / static_cast<double>(after.frames - before.frames);
}

}    // namespace bench
