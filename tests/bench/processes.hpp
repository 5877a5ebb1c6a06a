// Measured processes: their CPU time, memory, wake-ups and processor.
#pragma once
#include <sys/types.h>

#include <cstdint>
#include <vector>

namespace bench {

double cpu_seconds(pid_t process);
/// Its CPU use in each of the next 8 seconds, in percent of one processor.
std::vector<double> percent_of_a_core(pid_t process);
std::uint64_t wake_ups(pid_t process);    // voluntary context switches so far
std::uint64_t resident_bytes(pid_t process);
std::uint64_t max_resident_bytes(pid_t process);    // the maximum so far

/// Keeps a measured process on the second processor, if there is one: each calls this first.
void stay_on_second_processor();

/// The measuring process and its threads stay on the first processor.
void stay_on_first_processor();

/// While this object exists, its thread has real-time priority, if the system permits it; processes and threads started meanwhile
/// inherit it. Other load on the machine then does not affect the measurement.
class Undisturbed {
public:
    Undisturbed();
    ~Undisturbed();
    Undisturbed(const Undisturbed&) = delete;
    Undisturbed& operator=(const Undisturbed&) = delete;
};

/// A counter in shared memory: a forked process counts and its parent reads.
std::uint64_t* shared_word();

}    // namespace bench
