#include <sys/asio.hpp>
#include <sys/descriptor.hpp>

namespace anogate {

struct Descriptor::Stream : asio::posix::stream_descriptor {
    using asio::posix::stream_descriptor::stream_descriptor;
};

Descriptor::Descriptor(asio::io_context& io) : stream_{std::make_unique<Stream>(io)} {}

Descriptor::~Descriptor() { close(); }

void Descriptor::open(UniqueFd fd) {
    stream_->assign(fd.get());
    fd_ = fd.release();
    ++generation_;
}

void Descriptor::read_with(std::function<void()> call) {
    if (reading_) return;
    on_readable_ = std::move(call);
    reading_ = true;
    if (!waits_readable_) wait_readable();
}

void Descriptor::wait_readable() {
    waits_readable_ = true;
    stream_->async_wait(Stream::wait_read, [this, mine = generation_](error_code ec) {
        if (ec || mine != generation_) return;
        waits_readable_ = false;
        if (!reading_) return;
        on_readable_();
        if (mine == generation_ && reading_) wait_readable();
    });
}

void Descriptor::when_writable(std::function<void()> call) {
    if (waits_writable_) return;
    waits_writable_ = true;
    on_writable_ = std::move(call);
    stream_->async_wait(Stream::wait_write, [this, mine = generation_](error_code ec) {
        if (ec || mine != generation_) return;
        waits_writable_ = false;
        const auto now_writable = std::move(on_writable_);    // may call when_writable() again
        now_writable();
    });
}

void Descriptor::close() noexcept {
    ++generation_;
    reading_ = false;
    waits_readable_ = waits_writable_ = false;
    error_code ignored;
    if (stream_->is_open()) stream_->close(ignored);
    fd_ = -1;
}

}    // namespace anogate
