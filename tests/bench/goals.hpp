// The goals that are measured, each by a function that adds rows to the table.
#pragma once
#include "table.hpp"

namespace bench {

struct Run {
    std::string anogated;    // the program
    Table table;
};

void measure_parser(Run& run);
void measure_messages(Run& run);
void measure_udp(Run& run);
void measure_packed(Run& run);
void measure_pty(Run& run);
void measure_broadcast(Run& run);
void measure_latency(Run& run);
void measure_ports(Run& run);
void measure_line(Run& run);
void measure_idle(Run& run);
void measure_calls(Run& run);
void measure_watchers(Run& run);
void measure_page(Run& run);
void measure_recording(Run& run);
void measure_replay(Run& run);
void measure_tables(Run& run);
void measure_tcp(Run& run);
void measure_tcp_urgent(Run& run);
void measure_dead_peers(Run& run);
void measure_simulated(Run& run);
void measure_devices(Run& run);

}    // namespace bench
