// A pseudo-terminal whose other end reads bytes like a UART: one by one, at its rate.
#pragma once
#include <ano/parser.hpp>

#include <atomic>
#include <chrono>
#include <functional>
#include <string>
#include <thread>

namespace bench {

class SlowLine {
public:
    /// `on_frame` is called, in another thread, when the last byte of a frame has left.
    SlowLine(double rate, std::function<void(ano::FrameView)> on_frame);
    ~SlowLine();
    SlowLine(const SlowLine&) = delete;
    SlowLine& operator=(const SlowLine&) = delete;

    /// The path to open for sending.
    const std::string& path() const noexcept { return path_; }
    /// Bytes that left, and bytes that should have left.
    struct Count {
        std::uint64_t carried, possible;
    };
    Count count() const noexcept { return {carried_, possible_}; }
    /// The maximum of bytes that waited at the same time.
    double max_waiting() const noexcept { return max_waiting_; }
    /// Bytes that belong to no valid frame.
    std::uint64_t damaged() const noexcept { return damaged_; }

private:
    void run();
    void take(std::size_t bytes);

    double rate_;
    std::function<void(ano::FrameView)> on_frame_;
    int fd_;
    int other_end_ = -1;    // kept open, otherwise ours would report an end until a program opens it
    std::string path_;
    ano::FrameParser parser_{{}};
    std::atomic<std::uint64_t> carried_{0}, possible_{0}, damaged_{0};
    std::atomic<double> max_waiting_{0};
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}    // namespace bench
