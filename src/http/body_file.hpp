// Keeps large request bodies in files.
#pragma once
#include <http/large_body.hpp>
#include <sys/asio_fwd.hpp>
#include <sys/background_task.hpp>
#include <sys/expected.hpp>
#include <sys/unique_fd.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

/// A file without a name: the system deletes it when it is closed, also when the program is killed.
class BodyFile final : public http::StoredBody {
public:
    /// In `folder`, which is created when it is missing; or the reason why no file can be made.
    static Expected<std::shared_ptr<BodyFile>> make(const std::string& folder);
    explicit BodyFile(UniqueFd fd) : fd_{std::move(fd)} {}

    /// Empty: done; otherwise the reason of the failure, in words.
    std::string append(std::string_view bytes);
    std::uint64_t size() const override { return size_; }
    bool read(std::uint64_t at, std::span<std::uint8_t> into) const override;

private:
    UniqueFd fd_;
    std::uint64_t size_ = 0;
};

/// Makes files in the state folder, or in $TMPDIR or /tmp when that is impossible. Blocking calls of the disk are made in a thread.
class FileKeeper final : public http::BodyKeeper {
public:
    explicit FileKeeper(asio::io_context& io) : io_{io}, background_task_{io} {}
    void put(std::string part, std::function<void(std::string fault)> done) override;
    std::shared_ptr<const http::StoredBody> whole() const override { return kept_->file; }

private:
    struct Kept {
        std::shared_ptr<BodyFile> file;
        std::string fault;
    };

    asio::io_context& io_;
    std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();    // shared with the thread
    BackgroundTask background_task_;
};

}    // namespace anogate
