// Processes under measurement: their CPU time, memory and wake-ups, and where they run.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <vector>

namespace bench {

double cpu_seconds(pid_t process);
/// What it takes of one processor in each of the next 8 seconds.
std::vector<double> percent_of_a_core(pid_t process);
std::uint64_t wake_ups(pid_t process);    // voluntary context switches so far
std::uint64_t resident_bytes(pid_t process);
std::uint64_t max_resident_bytes(pid_t process);    // at any time so far

/// The measured processes stay on the second processor where there is one: each calls it first.
void stay_on_second_processor();

/// The measuring process and its threads stay on the first processor.
void stay_on_first_processor();

/// While it lives, its thread has real-time priority, where the system permits that; processes and threads that are started
/// meanwhile keep it. So other load on the machine does not affect the measurement.
class Undisturbed {
public:
    Undisturbed();
    ~Undisturbed();
    Undisturbed(const Undisturbed&) = delete;
    Undisturbed& operator=(const Undisturbed&) = delete;
};

/// A counter in shared memory, for a fork to count and its parent to read.
std::uint64_t* shared_word();

}    // namespace bench
