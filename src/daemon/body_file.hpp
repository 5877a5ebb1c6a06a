// Large bodies of requests in files.
#pragma once
#include <daemon/errand.hpp>
#include <http/large_body.hpp>
#include <link/asio_fwd.hpp>
#include <link/expected.hpp>
#include <link/unique_fd.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

namespace anogate {

/// A file without a name: it is gone when nobody has it any more, also when the program ends.
class BodyFile final : public http::StoredBody {
public:
    /// In `folder`, which is made if need be; or why there can be none.
    static Expected<std::shared_ptr<BodyFile>> make(const std::string& folder);
    explicit BodyFile(UniqueFd fd) : fd_{std::move(fd)} {}

    /// Why not, in words; nothing: it is done.
    std::string append(std::string_view bytes);
    std::uint64_t size() const override { return size_; }
    bool read(std::uint64_t at, std::span<std::uint8_t> into) const override;

private:
    UniqueFd fd_;
    std::uint64_t size_ = 0;
};

/// In the state folder, or where that can't be in $TMPDIR or /tmp. Its disk is waited for beside the loop.
class FileKeeper final : public http::BodyKeeper {
public:
    explicit FileKeeper(asio::io_context& io) : io_{io}, errand_{io} {}
    void put(std::string part, std::function<void(std::string fault)> done) override;
    std::shared_ptr<const http::StoredBody> whole() const override { return kept_->file; }

private:
    struct Kept {
        std::shared_ptr<BodyFile> file;
        std::string fault;
    };

    asio::io_context& io_;
    std::shared_ptr<Kept> kept_ = std::make_shared<Kept>();    // with the thread
    Errand errand_;
};

}    // namespace anogate
