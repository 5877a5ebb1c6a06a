// Shows a job to a person while it runs.
#pragma once
#include <anoctl/anoctl.hpp>

#include <ano/time.hpp>
#include <ano_json/frame_json.hpp>

#include <cstddef>
#include <string>
#include <vector>

namespace anoctl {

class JobView {
public:
    virtual ~JobView() = default;
    /// It has changed, or goes on.
    virtual void show(const ano::Json& job) = 0;
    /// Nothing more is shown: the terminal is as it was.
    virtual void end() {}
    /// Somebody pressed Enter so often: the terminal showed that, and its cursor is so many lines further down.
    virtual void went_down(std::size_t /*lines*/) {}
    /// Whether it may go on, when it waits for a word: a person pressed Enter at a terminal.
    virtual bool goes_on_by_itself() const { return false; }
};

/// Lines at the bottom of a terminal that are written anew.
class LiveLines {
public:
    explicit LiveLines(std::ostream& err) : err_{err} {}
    ~LiveLines() { clear(); }
    LiveLines(const LiveLines&) = delete;
    LiveLines& operator=(const LiveLines&) = delete;
    /// Of a terminal that is so wide: what is longer is cut off, for it would take two of its lines.
    void show(std::vector<std::string> lines, std::size_t width);
    /// The cursor left the last line by itself.
    void went_down(std::size_t lines) { below_ += shown_ > 0 ? lines : 0; }
    void clear() { show({}, 0); }

private:
    std::ostream& err_;
    std::size_t shown_ = 0, below_ = 0;    // the cursor is so many lines below the last
};

/// A bar on a terminal; else, where `tells_steps`, a line for each new message.
class ProgressView final : public JobView {
public:
    ProgressView(Streams& streams, bool tells_steps) : streams_{streams}, tells_steps_{tells_steps}, lines_{streams.err} {}
    void show(const ano::Json& job) override;
    void end() override { lines_.clear(); }
    void went_down(std::size_t lines) override { lines_.went_down(lines); }

private:
    Streams& streams_;
    const bool tells_steps_;
    LiveLines lines_;
    const ano::TimePoint began_ = ano::Clock::now();
    std::string told_;
};

}    // namespace anoctl
