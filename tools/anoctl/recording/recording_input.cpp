#include "recording_input.hpp"

#include <anoctl/counted.hpp>
#include <anoctl/device/file_text.hpp>

#include <record/mcap/mcap_format.hpp>
#include <record/mcap/mcap_index.hpp>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string_view>
#include <system_error>
#include <utility>

namespace anoctl {
namespace {

constexpr std::size_t piece = 256 * 1024;

[[noreturn]] void fail_to_read(const std::string& path) {
    throw UsageError{path + ": cannot read: " + std::generic_category().message(errno)};
}

}    // namespace

RecordingInput::RecordingInput(const std::string& path, Streams& streams)
    : path_{path}, fd_{-1}, room_(piece), reader_{anogate::make_recording_reader({})} {
    if (path.empty()) throw UsageError{"FILE is an empty name"};
    fd_ = path == "-" ? ::dup(streams.in) : open_input(path);
    if (fd_ < 0) fail_to_read(path);
}

RecordingInput::~RecordingInput() { ::close(fd_); }

// False: end of the file.
bool RecordingInput::read() {
    ssize_t n = 0;
    do n = ::read(fd_, room_.data(), room_.size());
    while (n < 0 && errno == EINTR);
    if (n < 0) fail_to_read(path_);
    const std::string_view bytes{room_.data(), static_cast<std::size_t>(n)};
    if (size_ == 0 && n > 0) reader_ = anogate::make_recording_reader(bytes);
    reader_->feed(bytes);
    size_ += static_cast<std::size_t>(n);
    return n > 0;
}

std::optional<anogate::Recorded> RecordingInput::next() {
    do
        if (const auto item = reader_->next()) return item;
    while (read());
    if (reader_->is_strange() && reader_->format() == anogate::RecordingFormat::pcapng)
        throw Failure{path_ +
                      ": this is a network capture, not a recording of a gateway; to see its frames, open it in Wireshark with "
                      "the dissector from anoctl messages --lua"};
    if (reader_->is_strange())
        throw Failure{path_ + ": this MCAP file is not a recording of a gateway: it has no channel " +
                      std::string{anogate::mcap::frames_topic}};
    if (reader_->position() > 0) return std::nullopt;
    const char* const why = size_ == 0              ? "the file is empty"
                            : reader_->is_damaged() ? reader_->fault()
                                                    : "the file ends within its header";
    throw Failure{path_ + ": " + why};
}

RecordingFacts RecordingInput::facts() const {
    RecordingFacts facts;
    facts.format = reader_->format();
    facts.head = reader_->head();
    facts.size = size_;
    facts.read = reader_->position();
    facts.has_end = reader_->has_end();
    facts.foreign = reader_->foreign();
    facts.skipped = reader_->skipped();
    facts.mismatches = reader_->mismatches();
    if (reader_->is_damaged()) facts.fault = reader_->fault();
    return facts;
}

std::optional<IndexedRecording> read_index(const std::string& path) {
    struct stat about {};
    if (path == "-" || ::stat(path.c_str(), &about) != 0 || !S_ISREG(about.st_mode))
        return std::nullopt;    // a pipe must not be opened here: it can be read only once
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) return std::nullopt;
    const auto index = anogate::read_mcap_index(static_cast<std::uint64_t>(about.st_size),
                                                [fd](std::uint64_t at, std::size_t size) {
                                                    std::string bytes(size, '\0');
                                                    const ssize_t n = ::pread(fd, bytes.data(), size, static_cast<off_t>(at));
                                                    bytes.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
                                                    return bytes;
                                                });
    ::close(fd);
    if (!index) return std::nullopt;
    IndexedRecording recording;
    recording.facts.format = anogate::RecordingFormat::mcap;
    recording.facts.head = index->head;
    recording.facts.size = recording.facts.read = static_cast<std::uint64_t>(about.st_size);
    recording.facts.has_end = true;
    recording.counts = index->counts;
    return recording;
}

RecordingFacts read_recording(const std::string& path, Streams& streams, const OnRecorded& accept) {
    RecordingInput input{path, streams};
    while (const auto item = input.next()) accept(*item, input.head());
    return input.facts();
}

namespace {

// "the chunk at byte 4711 is damaged and skipped, 120 messages: it can't be unpacked"
std::string note_on(const anogate::SkippedPart& part, anogate::RecordingFormat format) {
    std::string line = format == anogate::RecordingFormat::mcap ? "the chunk" : "the block";
    line += " at byte " + std::to_string(part.at) + " is damaged and skipped, ";
    if (!part.messages) line += "its contents are unknown";
    else if (*part.messages == 0) line += "without messages";
    else line += counted(*part.messages, "message");
    return line + ": " + std::string{part.why};
}

void add_notes_on(const anogate::SkippedParts& skipped, anogate::RecordingFormat format, std::vector<std::string>& lines) {
    for (const anogate::SkippedPart& part : skipped.first) lines.push_back(note_on(part, format));
    if (skipped.count > skipped.first.size())
        lines.push_back("and " + counted(skipped.count - skipped.first.size(), "other") + " skipped, " +
                        counted(skipped.bytes, "byte") + " in total");
    if (skipped.frames > 0) lines.push_back(counted(skipped.frames, "frame") + " cannot be read because of this");
}

}    // namespace

std::vector<std::string> RecordingFacts::notes() const {
    std::vector<std::string> lines;
    add_notes_on(skipped, format, lines);
    for (const std::string_view mismatch : mismatches)
        lines.push_back("damaged: " + std::string{mismatch} + "; the readable parts are used as they are");
    const std::string rest = std::to_string(size - read) + " of " + std::to_string(size) + " bytes";
    if (!fault.empty()) lines.push_back("damaged after byte " + std::to_string(read) + ", " + rest + " skipped: " + fault);
    else if (read < size) lines.push_back("cut off: the last " + rest + " are an incomplete block");
    if (head.has_bad_decoding)
        lines.push_back(
            "the layouts in the recording can't be read, so flexible messages are not decoded: give a configuration "
            "with --config");
    const bool ours = head.program.starts_with("ano");
    if (fault.empty() && !has_end && ours) lines.push_back("not finished: the recording is still running or was aborted");
    if (foreign > 0) lines.push_back(counted(foreign, "packet") + " without a complete frame");
    return lines;
}

}    // namespace anoctl
