#include <log/log_writer.hpp>

#include <gtest/gtest.h>
#include <spdlog/sinks/base_sink.h>

#include <csignal>
#include <new>
#include <semaphore>

namespace anogate::log_writer_tests {
namespace {

using namespace std::chrono_literals;

// A log that accepts a line only when the test allows it.
class Gate final : public spdlog::sinks::base_sink<std::mutex> {
public:
    void open(int lines) { may_.release(lines); }
    void await_a_writer() { came_.acquire(); }
    std::vector<std::string> lines() {
        const std::lock_guard lock{mutex_};
        return lines_;
    }
    int flushes() {
        const std::lock_guard lock{mutex_};
        return flushes_;
    }

private:
    void sink_it_(const spdlog::details::log_msg& message) override {
        came_.release();
        may_.acquire();
        lines_.emplace_back(message.payload.data(), message.payload.size());
    }
    void flush_() override { ++flushes_; }

    int flushes_ = 0;
    std::counting_semaphore<> came_{0}, may_{0};
    std::vector<std::string> lines_;
};

constexpr std::chrono::milliseconds enough = 60s;    // on any computer

struct Log {
    explicit Log(std::chrono::milliseconds finish_patience = enough)
        : writer{std::make_shared<LogWriter>([gate = gate] { return std::make_shared<spdlog::logger>("behind", gate); },
                                             finish_patience)} {}

    std::shared_ptr<Gate> gate = std::make_shared<Gate>();
    std::shared_ptr<LogWriter> writer;
    spdlog::logger front{"front", writer};
};

TEST(LogWriter, has_written_everything_in_order_when_it_is_finished) {
    Log log;
    log.gate->open(1000);
    std::vector<std::string> said;
    for (int i = 0; i < 100; ++i) log.front.info(said.emplace_back(std::to_string(i)));
    EXPECT_TRUE(log.writer->finish());
    EXPECT_EQ(log.gate->lines(), said);
    EXPECT_TRUE(log.writer->finish()) << "again";
    EXPECT_GT(log.gate->flushes(), 0) << "and nothing waits in a buffer";
}

TEST(LogWriter, leaves_signals_to_the_thread_of_the_loop) {
    sigset_t blocked;
    sigemptyset(&blocked);
    LogWriter writer{[&] {
                         ::pthread_sigmask(SIG_SETMASK, nullptr, &blocked);
                         return std::make_shared<spdlog::logger>("behind");
                     },
                     enough};
    EXPECT_TRUE(writer.finish());
    for (const int signal : {SIGTERM, SIGHUP, SIGUSR1, SIGTTOU}) EXPECT_EQ(sigismember(&blocked, signal), 1) << signal;
}

TEST(LogWriter, reports_lost_lines_where_they_are_missing) {
    Log log;
    log.front.info("first");
    log.gate->await_a_writer();
    log.front.info("second");
    log.front.info(std::string(LogQueue::room, 'x'));
    log.front.info("lost");
    log.writer->lose();
    log.gate->open(3);    // for three more lines: the waiting ones, and the one about the loss
    for (int i = 0; i < 3; ++i) log.gate->await_a_writer();
    log.front.info("last");
    log.gate->open(2);
    EXPECT_TRUE(log.writer->finish());
    const std::vector<std::string> lines = log.gate->lines();
    ASSERT_EQ(lines.size(), 5u);
    EXPECT_EQ(lines[1], "second");
    EXPECT_EQ(lines[3], "2 log lines were dropped: the log destination did not accept them");
    EXPECT_EQ(lines[4], "last");
}

TEST(LogWriter, waits_only_for_a_limited_time_at_the_end) {
    const std::chrono::milliseconds finish_patience = 1s;
    Log log{finish_patience};
    log.front.info("nobody takes this");
    const auto begin = std::chrono::steady_clock::now();
    EXPECT_FALSE(log.writer->finish());
    EXPECT_GE(std::chrono::steady_clock::now() - begin, finish_patience);
    log.front.info("nor this");
    const auto again = std::chrono::steady_clock::now();
    EXPECT_FALSE(log.writer->finish());
    EXPECT_LT(std::chrono::steady_clock::now() - again, finish_patience) << "it waits once";
    log.gate->open(2);    // so that the thread ends
}

TEST(LogWriter, without_memory_at_first_the_log_is_opened_later) {
    const auto gate = std::make_shared<Gate>();
    gate->open(1);
    std::binary_semaphore opened{0};
    int tries = 0;
    const auto writer = std::make_shared<LogWriter>(
        [&] {
            if (++tries < 3) throw std::bad_alloc{};
            opened.release();
            return std::make_shared<spdlog::logger>("behind", gate);
        },
        enough);
    spdlog::logger{"front", writer}.info("early");
    opened.acquire();
    EXPECT_TRUE(writer->finish());
    EXPECT_EQ(gate->lines(), std::vector<std::string>{"early"});
}

TEST(LogWriter, finishes_even_without_any_memory) {
    LogWriter writer{[]() -> std::shared_ptr<spdlog::logger> { throw std::bad_alloc{}; }, enough};
    EXPECT_TRUE(writer.finish());
}

TEST(LogWriter, a_log_that_opens_late_contains_earlier_messages) {
    const auto gate = std::make_shared<Gate>();
    std::binary_semaphore there{0};
    LogWriter writer{[&] {
                         there.acquire();
                         return std::make_shared<spdlog::logger>("behind", gate);
                     },
                     enough};
    writer.log({"front", spdlog::level::info, "early"});
    gate->open(1);
    there.release();
    EXPECT_TRUE(writer.finish());
    EXPECT_EQ(gate->lines(), std::vector<std::string>{"early"});
}

}    // namespace
}    // namespace anogate::log_writer_tests
