// Converting a recording to tables, compared with only reading it, and to MCAP with JSON messages, compared with CDR.
#include "goals.hpp"

#include <record/csv.hpp>
#include <record/recording_reader.hpp>
#include <record/recording_writer.hpp>
#include <world/flight_controller.hpp>

#include <algorithm>
#include <array>
#include <chrono>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

namespace bench {
namespace {

using namespace std::chrono_literals;
using anogate::DecodedEncoding;
using anogate::RecordedFrame;

constexpr int rounds = 9, devices = 20;
constexpr auto flown = 10s;
constexpr double frames_a_second = 48'000;

double cpu_seconds_so_far() {
    timespec time{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

template <class Work>
double cpu_seconds_of(Work&& work) {
    const double before = cpu_seconds_so_far();
    work();
    return cpu_seconds_so_far() - before;
}

struct Flown {
    std::string link;
    std::uint64_t time_ns;
    std::vector<std::uint8_t> frame;
};

// The simultaneous frames of several flight controllers at 100 Hz.
std::vector<Flown> flights() {
    constexpr ano::TimePoint start{1000s};
    std::vector<std::unique_ptr<ano::world::FlightController>> controllers;
    for (std::uint8_t i = 1; i <= devices; ++i)
        controllers.push_back(
            std::make_unique<ano::world::FlightController>(ano::world::Settings{.id = i, .hz = 100, .seed = i}, start));
    std::vector<Flown> all;
    for (ano::TimePoint now = start; now < start + flown; now += ano::world::SimulatedDevice::step)
        for (std::size_t i = 0; i < controllers.size(); ++i)
            controllers[i]->run(now, [&](ano::Bytes bytes, ano::TimePoint at) {
                all.push_back({"s" + std::to_string(i),
                               static_cast<std::uint64_t>(std::chrono::nanoseconds{at.time_since_epoch()}.count()),
                               {bytes.begin(), bytes.end()}});
            });
    return all;
}

std::string recorded(const std::vector<Flown>& flights, DecodedEncoding encoding) {
    std::string file;
    const auto writer = anogate::make_recording_writer(anogate::RecordingFormat::mcap, {"bench", 0, 0}, file,
                                                       {.encoding = encoding});
    for (const Flown& flight : flights)
        writer->write(RecordedFrame{.time_ns = flight.time_ns, .link = flight.link, .frame = ano::FrameView{flight.frame}}, file);
    writer->end(file);
    return file;
}

template <class Take>
void read(std::string_view file, Take&& take) {
    constexpr std::size_t piece = 256 * 1024;
    const auto reader = anogate::make_recording_reader(file);
    for (; !file.empty(); file.remove_prefix(std::min(piece, file.size()))) {
        reader->feed(file.substr(0, piece));
        while (const auto item = reader->next())
            if (const auto* frame = std::get_if<RecordedFrame>(&*item)) take(*frame);
    }
}

void write_tables(const std::string& file) {
    std::array<std::unique_ptr<anogate::CsvWriter>, 256> writers;
    std::string out;
    read(file, [&](const RecordedFrame& frame) {
        constexpr std::size_t batch = 64 * 1024;
        auto& writer = writers[frame.frame.id()];
        if (!writer) writer = std::make_unique<anogate::CsvWriter>(frame.frame.id(), ano::JsonOptions{});
        writer->write(frame, out);
        if (out.size() > batch) out.clear();
    });
}

}    // namespace

void measure_tables(Run& run) {
    const std::vector<Flown> all = flights();
    const std::string file = recorded(all, DecodedEncoding::cdr);
    const double megabytes = static_cast<double>(file.size()) / 1e6, frames = static_cast<double>(all.size());
    std::vector<double> tables, alone, json, cdr, of_a_core;
    for (int i = 0; i < rounds; ++i) {
        tables.push_back(megabytes / cpu_seconds_of([&] { write_tables(file); }));
        alone.push_back(megabytes / cpu_seconds_of([&] { read(file, [](const RecordedFrame&) {}); }));
        json.push_back(cpu_seconds_of([&] { recorded(all, DecodedEncoding::json); }) * 1e6 / frames);
        cdr.push_back(cpu_seconds_of([&] { recorded(all, DecodedEncoding::cdr); }) * 1e6 / frames);
        of_a_core.push_back(json.back() * frames_a_second / 1e4);
    }
    run.table.measure("A recording of 20 flight controllers as CSV: MB of MCAP a second of CPU", tables, at_least(40));
    run.table.compare("… beside reading it alone", tables, alone, at_least(0.3));
    run.table.measure("48,000 frames/s as MCAP with JSON: % of a core", of_a_core, at_most(25));
    run.table.compare("… CPU µs a frame, beside MCAP with CDR", json, cdr, at_most(2));
}

}    // namespace bench
