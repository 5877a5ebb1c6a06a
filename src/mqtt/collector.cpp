#include <ano_json/frame_json.hpp>
#include <mqtt/collector.hpp>
#include <mqtt/topics.hpp>
#include <sys/errors.hpp>

#include <nlohmann/json.hpp>

#include <fcntl.h>
#include <unistd.h>

#include <charconv>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t max_outputs = 512;    // open files
constexpr std::uint64_t flush_s = 1;

// A folder never leaves the one that was given.
std::string folder_name(std::string_view gateway) {
    std::string name{gateway};
    if (name.front() == '.') name.front() = '_';
    return name;
}

std::string day_of(std::uint64_t now_s, const char* format) {
    const auto time = static_cast<std::time_t>(now_s);
    std::tm utc{};
    ::gmtime_r(&time, &utc);
    char text[32];
    return {text, std::strftime(text, sizeof text, format, &utc)};
}

struct Identity {
    std::string gateway, stream;
    std::uint64_t seq = 0;
};

std::optional<Identity> identity_of(std::string_view line) {
    const Json record = Json::parse(line, nullptr, false);
    if (!record.is_object()) return std::nullopt;
    const auto gateway = record.find("gateway"), stream = record.find("stream"), seq = record.find("seq");
    if (gateway == record.end() || !gateway->is_string() || stream == record.end() || !stream->is_string() ||
        seq == record.end() || !seq->is_number_unsigned())
        return std::nullopt;
    return Identity{gateway->get<std::string>(), stream->get<std::string>(), seq->get<std::uint64_t>()};
}

template <class Call>
void for_each_line(std::string_view lines, Call call) {
    while (!lines.empty()) {
        const std::size_t end = std::min(lines.find('\n'), lines.size());
        if (end > 0) call(lines.substr(0, end));
        lines.remove_prefix(std::min(end + 1, lines.size()));
    }
}

Expected<void> append(int fd, std::string_view bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(fd, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written < 0) return Unexpected{error_text(errno)};
        bytes.remove_prefix(static_cast<std::size_t>(written));
    }
    return {};
}

std::uint64_t ns_of(const Json& record, const char* name) {
    const auto found = record.find(name);
    if (found == record.end() || !found->is_number()) return 0;
    const double seconds = found->get<double>();
    return seconds > 0 && seconds < 1e10 ? static_cast<std::uint64_t>(std::llround(seconds * 1e6)) * 1000 : 0;
}

}    // namespace

struct Collector::Output {
    std::string day;
    UniqueFd lines;
    UniqueFd recording;
    std::string bytes;    // of the recording, not written yet
    std::unique_ptr<RecordingWriter> writer;
    std::uint64_t flushed_s = 0;
};

Collector::Collector(std::string folder, bool mcap) : folder_{std::move(folder)}, mcap_{mcap} {}
Collector::~Collector() = default;

Expected<void> Collector::open() {
    std::error_code error;
    std::filesystem::create_directories(folder_, error);
    if (error) return Unexpected{folder_ + ": " + error.message()};
    for (const auto& entry : std::filesystem::recursive_directory_iterator{folder_, error})
        if (entry.path().extension() == ".ndjson")
            if (auto read = read_file(entry.path().string()); !read) return read;
    if (error) return Unexpected{folder_ + ": " + error.message()};
    return {};
}

Expected<void> Collector::read_file(const std::string& path) {
    std::ifstream file{path, std::ios::binary};
    std::uintmax_t complete = 0;
    for (std::string line; std::getline(file, line);) {
        if (file.eof()) break;    // without a line end
        complete += line.size() + 1;
        if (const auto identity = identity_of(line)) seen_.add(identity->gateway + '/' + identity->stream, identity->seq);
    }
    std::error_code error;
    if (complete < std::filesystem::file_size(path, error)) std::filesystem::resize_file(path, complete, error);
    return error ? Expected<void>{Unexpected{path + ": " + error.message()}} : Expected<void>{};
}

Expected<void> Collector::receive(const BrokerMessage& message, std::uint64_t now_s) {
    const std::string_view gateway = gateway_of(message.topic);
    if (!is_level(gateway) || message.topic.ends_with("/status")) return {};
    std::string_view lines = message.payload;
    if (is_backlog(message.topic)) {
        const auto unpacked = unpacker_.unpack(message.payload);
        if (!unpacked) {
            ++counts_.invalid;
            return {};
        }
        lines = *unpacked;
    }
    return add_lines(gateway, lines, now_s);
}

// All lines of a message are written at once: a file never ends inside of one, unless the computer fails.
Expected<void> Collector::add_lines(std::string_view gateway, std::string_view lines, std::uint64_t now_s) {
    std::string fresh;
    Output& output = output_of(gateway);
    for_each_line(lines, [&](std::string_view line) {
        if (!is_new(gateway, line)) return;
        fresh.append(line).append(1, '\n');
        if (mcap_) add_to_recording(output, line, now_s);
    });
    return fresh.empty() ? Expected<void>{} : write(output, gateway, fresh, now_s);
}

// A gateway may publish only its own records: the broker checks its topic.
bool Collector::is_new(std::string_view gateway, std::string_view line) {
    const auto identity = identity_of(line);
    if (!identity || identity->gateway != gateway) {
        ++counts_.invalid;
        return false;
    }
    const bool is_new = seen_.add(identity->gateway + '/' + identity->stream, identity->seq);
    ++(is_new ? counts_.records : counts_.repeats);
    return is_new;
}

Collector::Output& Collector::output_of(std::string_view gateway) {
    if (const auto found = outputs_.find(gateway); found != outputs_.end()) return *found->second;
    if (outputs_.size() == max_outputs) {
        close();
        outputs_.clear();
    }
    return *(outputs_[std::string{gateway}] = std::make_unique<Output>());
}

Expected<void> Collector::write(Output& output, std::string_view gateway, const std::string& lines, std::uint64_t now_s) {
    const std::string folder = folder_ + '/' + folder_name(gateway);
    if (const std::string day = day_of(now_s, "%Y-%m-%d"); output.day != day) {
        std::error_code error;
        std::filesystem::create_directories(folder, error);
        const std::string path = folder + '/' + day + ".ndjson";
        output.lines = UniqueFd{::open(path.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0640)};
        if (!output.lines) return Unexpected{error_text(path, errno)};
        output.day = day;
    }
    if (auto written = append(output.lines.get(), lines); !written) return Unexpected{folder + ": " + written.error()};
    if (!output.writer) return {};
    if (!output.recording) {
        const std::string path = folder + '/' + day_of(now_s, "%Y-%m-%dT%H-%M-%SZ") + ".mcap";
        output.recording = UniqueFd{::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640)};
        if (!output.recording) return Unexpected{error_text(path, errno)};
    }
    if (now_s >= output.flushed_s + flush_s) {
        output.writer->flush(output.bytes);
        output.flushed_s = now_s;
    }
    return append(output.recording.get(), std::exchange(output.bytes, {}));
}

// Flexible messages can't be restored without their layouts, which are not in the records.
void Collector::add_to_recording(Output& output, std::string_view line, std::uint64_t now_s) {
    Json record = Json::parse(line, nullptr, false);
    const std::uint64_t time_ns = ns_of(record, "time"), boottime_ns = ns_of(record, "boottime");
    const auto name = record.find("link");
    const std::string link = name != record.end() && name->is_string() ? name->get<std::string>() : "";
    for (const char* own : {"gateway", "stream", "seq", "time", "boottime", "link", "device"}) record.erase(own);
    const auto frame = ano::frame_from_json(record);
    const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&frame);
    if (bytes == nullptr) return;
    if (!output.writer)
        output.writer = make_recording_writer(
            RecordingFormat::mcap, {.program = "anogate-mqtt " ANOGATE_VERSION, .time_ns = now_s * 1'000'000'000}, output.bytes);
    output.writer->write(
        RecordedFrame{.time_ns = time_ns, .boottime_ns = boottime_ns, .link = link, .frame = ano::FrameView{*bytes}},
        output.bytes);
}

Expected<void> Collector::close() {
    Expected<void> result;
    for (auto& [gateway, output] : outputs_) {
        if (!output->writer || !output->recording) continue;
        output->writer->end(output->bytes);
        output->writer.reset();
        if (auto written = append(output->recording.get(), output->bytes); !written) result = written;
    }
    return result;
}

}    // namespace anogate
