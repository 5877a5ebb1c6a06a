#include <http/range.hpp>
#include <http/served_file.hpp>
#include <sys/descriptors_left.hpp>

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <utility>

namespace anogate {
namespace {

constexpr std::size_t piece_size = 256 * 1024;     // bytes of a read
constexpr std::size_t size_of_part = 64 * 1024;    // bytes of one part of the response, made in one turn of the loop

// Returns fewer bytes at the end of the file, or when it is not readable.
std::string read_piece(int fd, std::uint64_t at, std::size_t size) {
    std::string piece(size, '\0');
    std::size_t have = 0;
    while (have < size) {
        const ssize_t n = ::pread(fd, piece.data() + have, size - have, static_cast<off_t>(at + have));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) break;
        have += static_cast<std::size_t>(n);
    }
    piece.resize(have);
    return piece;
}

class FileParts final : public http::Producer {
public:
    FileParts(TaskPool& disk, UniqueFd file, std::uint64_t at, std::uint64_t size)
        : disk_{disk}, file_{std::make_shared<const UniqueFd>(std::move(file))}, at_{at}, left_{size} {}

    void start(std::function<void()> wake) override { wake_ = std::move(wake); }
    Next next(std::string& into) override {
        if (given_ < piece_.size()) {
            into.assign(piece_, given_, size_of_part);
            given_ += into.size();
            return given_ == piece_.size() && left_ == 0 ? Next::end : Next::part;
        }
        if (left_ == 0 || has_failed_) return Next::end;
        read();
        return Next::later;
    }

private:
    void read() {
        const auto size = static_cast<std::size_t>(std::min<std::uint64_t>(left_, piece_size));
        const auto read = std::make_shared<std::string>();
        ticket_ = disk_.run([read, file = file_, at = at_, size] { *read = read_piece(file->get(), at, size); },
                            [this, read, size](const std::string& fault) {
                                has_failed_ = !fault.empty() || read->size() != size;
                                piece_ = std::move(*read);
                                given_ = 0;
                                at_ += piece_.size();
                                left_ -= piece_.size();
                                wake_();
                            });
    }

    TaskPool& disk_;
    std::shared_ptr<const UniqueFd> file_;    // shared with a thread that may read after this object is destroyed
    std::uint64_t at_, left_;
    std::string piece_;
    std::size_t given_ = 0;    // bytes of piece_ that were already returned
    bool has_failed_ = false;
    std::function<void()> wake_;
    TaskPool::Ticket ticket_;
};

// The entity tag: it differs after each change of the file.
std::string tag_of(const struct stat& is) {
    return "\"" + std::to_string(is.st_ino) + "-" + std::to_string(is.st_size) + "-" + std::to_string(is.st_mtim.tv_sec) + "." +
           std::to_string(is.st_mtim.tv_nsec) + "\"";
}

// The headers of the request that the thread needs.
struct Wanted {
    std::string range, if_range;
};

http::Response response_of(TaskPool& disk, UniqueFd file, const Wanted& wanted, const ServedFile& what) {
    struct stat is {};
    if (::fstat(file.get(), &is) != 0 || !S_ISREG(is.st_mode)) return http::error(404, "it is not a file");
    const auto size = static_cast<std::uint64_t>(is.st_size);
    const std::string tag = tag_of(is);
    const bool is_same = wanted.if_range.empty() || wanted.if_range == tag;
    const http::Range range = http::wanted_range(is_same ? wanted.range : "", size);
    http::Response response;
    if (range.kind == http::Range::Kind::outside) {
        response = http::error(416, "the file has " + std::to_string(size) + " bytes");
        response.headers.push_back({"Content-Range", "bytes */" + std::to_string(size)});
        return response;
    }
    if (range.kind == http::Range::Kind::part) {
        response.status = 206;
        response.headers.push_back({"Content-Range", "bytes " + std::to_string(range.first) + "-" +
                                                         std::to_string(range.first + range.size - 1) + "/" +
                                                         std::to_string(size)});
    }
    response.type = what.type;
    response.headers.push_back({"Accept-Ranges", "bytes"});
    response.headers.push_back({"ETag", tag});
    response.headers.push_back({"X-Content-Type-Options", "nosniff"});
    if (!what.save_as.empty())
        response.headers.push_back({"Content-Disposition", "attachment; filename=\"" + what.save_as + "\""});
    response.length = range.size;
    response.producer = std::make_unique<FileParts>(disk, std::move(file), range.first, range.size);
    return response;
}

}    // namespace

http::Response served(TaskPool& disk, const http::Request& request, ServedFile file) {
    const Wanted wanted{std::string{request.header("Range")}, std::string{request.header("If-Range")}};
    return answer_from(disk, [&disk, wanted, file = std::move(file)] {
        if (descriptors_left() == 0) return http::try_again(ano::Fault{"few_descriptors"});
        auto opened = file.open();
        if (auto* instead = std::get_if<http::Response>(&opened)) return std::move(*instead);
        return response_of(disk, std::move(std::get<UniqueFd>(opened)), wanted, file);
    });
}

// O_NONBLOCK: opening a pipe would otherwise wait for a writer.
UniqueFd open_regular(int folder, const std::string& name, bool writable) {
    const int flags = (writable ? O_RDWR : O_RDONLY) | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC | O_NOCTTY;
    UniqueFd file{::openat(folder, name.c_str(), flags)};
    struct stat is {};
    if (!file || ::fstat(file.get(), &is) != 0) return {};
    if (S_ISREG(is.st_mode)) return file;
    errno = EINVAL;
    return {};
}

}    // namespace anogate
