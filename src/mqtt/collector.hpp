// The reader: writes the records of all gateways to files, each record once.
#pragma once
#include <ano/time.hpp>
#include <mqtt/batch.hpp>
#include <mqtt/broker.hpp>
#include <mqtt/seen_records.hpp>
#include <record/recording_writer.hpp>
#include <sys/expected.hpp>
#include <sys/unique_fd.hpp>

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace anogate {

class Collector {
public:
    struct Counts {
        std::atomic<std::uint64_t> records{0}, repeats{0}, invalid{0};
    };

    /// Writes FOLDER/GATEWAY/DATE.ndjson, and FOLDER/GATEWAY/TIME.mcap if `mcap` is set.
    Collector(std::string folder, bool mcap);
    ~Collector();

    /// Reads which records are in the folder. An incomplete last line of a file is removed.
    Expected<void> open();
    /// A message of a gateway. An error: it could not be written.
    Expected<void> receive(const BrokerMessage& message, std::uint64_t now_s);
    /// Ends the files.
    Expected<void> close();

    const Counts& counts() const noexcept { return counts_; }

private:
    struct Output;
    Expected<void> read_file(const std::string& path);
    Expected<void> add_lines(std::string_view gateway, std::string_view lines, std::uint64_t now_s);
    bool is_new(std::string_view gateway, std::string_view line);
    Output& output_of(std::string_view gateway);
    Expected<void> write(Output& output, std::string_view gateway, const std::string& lines, std::uint64_t now_s);
    void add_to_recording(Output& output, std::string_view line, std::uint64_t now_s);

    const std::string folder_;
    const bool mcap_;
    SeenRecords seen_;
    BatchUnpacker unpacker_;
    std::map<std::string, std::unique_ptr<Output>, std::less<>> outputs_;    // by gateway
    Counts counts_;
};

}    // namespace anogate
