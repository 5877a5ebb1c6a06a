// Measures the goals of anogate, and for each one the minimum cost of the same work, alternating in short rounds, so that other
// load on the machine affects both. Prints a table in Markdown. Exit status 1: a goal is missed.
// Usage: goals PATH-TO-anogated [NAME...]
#include "goals.hpp"

#include "processes.hpp"

#include <algorithm>
#include <iostream>
#include <span>

namespace {

struct Goals {
    std::string_view name;
    void (*measure)(bench::Run&);
};

constexpr Goals all[]{
    {"parser", bench::measure_parser},
    {"messages", bench::measure_messages},
    {"udp", bench::measure_udp},
    {"packed", bench::measure_packed},
    {"pty", bench::measure_pty},
    {"broadcast", bench::measure_broadcast},
    {"latency", bench::measure_latency},
    {"ports", bench::measure_ports},
    {"line", bench::measure_line},
    {"idle", bench::measure_idle},
    {"calls", bench::measure_calls},
    {"watchers", bench::measure_watchers},
    {"page", bench::measure_page},
    {"recording", bench::measure_recording},
    {"replay", bench::measure_replay},
    {"simulated", bench::measure_simulated},
    {"devices", bench::measure_devices},
    {"tables", bench::measure_tables},
    {"tcp", bench::measure_tcp},
    {"tcp-urgent", bench::measure_tcp_urgent},
    {"dead-peers", bench::measure_dead_peers},
};

int usage(const char* program) {
    std::cerr << "usage: " << program << " PATH-TO-anogated [NAME...]\nnames:";
    for (const Goals& goals : all) std::cerr << ' ' << goals.name;
    std::cerr << '\n';
    return 2;
}

}    // namespace

int main(int argc, char** argv) {
    if (argc < 2) return usage(argv[0]);
    const std::span<char*> names{argv + 2, argv + argc};
    for (const std::string_view name : names)
        if (std::none_of(std::begin(all), std::end(all), [&](const Goals& goals) { return goals.name == name; }))
            return usage(argv[0]);
    bench::stay_on_first_processor();
    bench::Run run{argv[1], {}};
    for (const Goals& goals : all)
        if (names.empty() || std::find(names.begin(), names.end(), goals.name) != names.end()) goals.measure(run);
    run.table.print();
    return run.table.all_met() ? 0 : 1;
}
