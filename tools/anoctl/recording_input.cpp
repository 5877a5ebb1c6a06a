#include "recording_input.hpp"

#include "counted.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

namespace anoctl {
namespace {

constexpr std::size_t piece = 256 * 1024;

[[noreturn]] void fail_to_read(const std::string& path) {
    throw UsageError{path + ": it can't be read: " + std::generic_category().message(errno)};
}

}    // namespace

RecordingInput::RecordingInput(const std::string& path, Streams& streams) : path_{path}, fd_{-1}, room_(piece) {
    if (path.empty()) throw UsageError{"a FILE has a name"};
    fd_ = path == "-" ? ::dup(streams.in) : ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY);
    if (fd_ < 0) fail_to_read(path);
}

RecordingInput::~RecordingInput() { ::close(fd_); }

// False: that is the end.
bool RecordingInput::read() {
    ssize_t n = 0;
    do n = ::read(fd_, room_.data(), room_.size());
    while (n < 0 && errno == EINTR);
    if (n < 0) fail_to_read(path_);
    reader_.give({room_.data(), static_cast<std::size_t>(n)});
    size_ += static_cast<std::size_t>(n);
    return n > 0;
}

std::optional<anogate::Recorded> RecordingInput::next() {
    do
        if (const auto item = reader_.next()) return item;
    while (read());
    if (reader_.position() > 0) return std::nullopt;
    const char* const why = size_ == 0 ? "it is empty" : reader_.is_damaged() ? reader_.fault() : "it ends before its head does";
    throw Failure{path_ + ": " + why};
}

RecordingFacts RecordingInput::facts() const {
    RecordingFacts facts;
    facts.head = reader_.head();
    facts.size = size_;
    facts.read = reader_.position();
    facts.has_end = reader_.has_end();
    facts.foreign = reader_.foreign();
    if (reader_.is_damaged()) facts.fault = reader_.fault();
    return facts;
}

RecordingFacts read_recording(const std::string& path, Streams& streams, const TakeRecorded& take) {
    RecordingInput input{path, streams};
    while (const auto item = input.next()) take(*item, input.head());
    return input.facts();
}

std::vector<std::string> RecordingFacts::notes() const {
    std::vector<std::string> lines;
    const std::string rest = std::to_string(size - read) + " of " + std::to_string(size) + " bytes";
    if (!fault.empty()) lines.push_back("damaged behind byte " + std::to_string(read) + ", " + rest + " are not read: " + fault);
    else if (read < size) lines.push_back("cut off: the last " + rest + " are no whole block");
    const bool ours = head.program.starts_with("ano");
    if (fault.empty() && !has_end && ours) lines.push_back("not ended: what records it still runs, or was ended by force");
    if (foreign > 0) lines.push_back(counted(foreign, "packet") + " in it that are no whole frame");
    return lines;
}

}    // namespace anoctl
