// Runs the benchmarks of the library that have goals several times in random order, and compares them.
#include "goals.hpp"

#include <benchmark/benchmark.h>
#include <support/noisy_line.hpp>

#include <algorithm>
#include <map>

namespace bench {
namespace {

struct Result {
    std::vector<double> nanoseconds, gigabytes;    // CPU time of a pass, GB/s; one value per repetition
};
using Results = std::map<std::string, Result>;

class Collector : public benchmark::BenchmarkReporter {
public:
    Results results;

    bool ReportContext(const Context&) override { return true; }
    void ReportRuns(const std::vector<Run>& runs) override {
        for (const Run& run : runs) {
            if (run.run_type != Run::RT_Iteration) continue;
            Result& result = results[run.run_name.function_name];
            result.nanoseconds.push_back(run.GetAdjustedCPUTime());
            const auto bytes = run.counters.find("bytes_per_second");
            if (bytes != run.counters.end()) result.gigabytes.push_back(bytes->second.value / 1e9);
        }
    }
};

Results results_of(const std::string& filter) {
    std::vector<std::string> words{"goals", "--benchmark_filter=" + filter, "--benchmark_repetitions=15",
                                   "--benchmark_min_time=0.02", "--benchmark_enable_random_interleaving=true"};
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    int count = static_cast<int>(arguments.size());
    benchmark::Initialize(&count, arguments.data());
    Collector collector;
    benchmark::RunSpecifiedBenchmarks(&collector);
    return std::move(collector.results);
}

// The % of valid frames that are in time; one value for each seed, the worst of three rates and two drivers.
std::vector<double> in_time(support::Noise noise) {
    std::vector<double> shares;
    for (std::uint64_t seed = 1; seed <= 9; ++seed) {
        double worst = 100;
        for (const std::uint32_t baud : {115200u, 500000u, 1000000u})
            for (const std::size_t at_once : {16u, 62u}) {
                const auto delays = support::delays_on(
                    {.baud = baud, .noise = noise, .noise_one_in = 50, .at_once = at_once, .seed = seed});
                worst = std::min(worst, 100 * delays.share_in_time());
            }
        shares.push_back(worst);
    }
    return shares;
}

}    // namespace

void measure_parser(Run& run) {
    const Results results = results_of("parse/");
    const Result& good = results.at("parse/good_21");
    std::string slowest;
    for (const auto& [name, result] : results)
        if (name.starts_with("parse/crafted") &&
            (slowest.empty() || quantile(result.gigabytes) < quantile(results.at(slowest).gigabytes)))
            slowest = name;
    run.table.measure("Parser, frames of 21 bytes: GB/s", good.gigabytes, at_least(1));
    run.table.measure("Parser, frames of 64 KiB: GB/s", results.at("parse/good_64k").gigabytes, at_least(2));
    run.table.compare("Parser, the slowest of the inputs crafted to be slow (" + slowest.substr(slowest.find('_') + 1) +
                          "): GB/s, beside frames of 21 bytes",
                      results.at(slowest).gigabytes, good.gigabytes, at_least(0.5));
    run.table.measure(
        "Full line, 115200 to 1 Mbaud, a false header of random bytes each 50 frames: good frames within "
        "20 ms + two frame times, %",
        in_time(support::Noise::random_headers), at_least(99.5));
    run.table.measure("… a bit of LEN turned over each 50 frames, %", in_time(support::Noise::flipped_len), at_least(99.5));
    run.table.measure("… a false header with any LEN up to `max_data` each 50 frames, %",
                      in_time(support::Noise::headers_to_max_data), no_goal);
}

// Each pass decodes 256 frames.
void measure_messages(Run& run) {
    Results results = results_of("^(typed|packed_struct|walk|walk_by_hand)$");
    for (auto& [name, result] : results)
        for (double& value : result.nanoseconds) value /= 256;
    run.table.compare("Decoding 7 fields by name: ns a frame, beside a packed struct", results["typed"].nanoseconds,
                      results["packed_struct"].nanoseconds, at_most(1.2));
    run.table.compare("Decoding 7 fields by the table: ns a frame, beside a walk written by hand for one layout",
                      results["walk"].nanoseconds, results["walk_by_hand"].nanoseconds, no_goal);
}

}    // namespace bench
