// Shows a running job to the user.
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
    /// The job has changed or progressed.
    virtual void show(const ano::Json& job) = 0;
    /// Ends the display, and restores the terminal.
    virtual void end() {}
    /// Enter was pressed `lines` times and echoed: the cursor moved down by as many lines.
    virtual void went_down(std::size_t /*lines*/) {}
    /// Whether a waiting job is continued without Enter being pressed.
    virtual bool continues_unattended() const { return false; }
};

/// Lines at the bottom of a terminal that are overwritten in place.
class LiveLines {
public:
    explicit LiveLines(std::ostream& err) : err_{err} {}
    ~LiveLines() { clear(); }
    LiveLines(const LiveLines&) = delete;
    LiveLines& operator=(const LiveLines&) = delete;
    /// `width`: columns of the terminal. Longer lines are truncated, because they would wrap.
    void show(std::vector<std::string> lines, std::size_t width);
    /// The cursor moved below the last line because Enter was echoed.
    void went_down(std::size_t lines) { below_ += shown_ > 0 ? lines : 0; }
    void clear() { show({}, 0); }

private:
    std::ostream& err_;
    std::size_t shown_ = 0, below_ = 0;    // below_: lines from the last line down to the cursor
};

/// A progress bar on a terminal; otherwise, if `prints_steps`, a line for each new message.
class ProgressView final : public JobView {
public:
    ProgressView(Streams& streams, bool prints_steps) : streams_{streams}, prints_steps_{prints_steps}, lines_{streams.err} {}
    void show(const ano::Json& job) override;
    void end() override { lines_.clear(); }
    void went_down(std::size_t lines) override { lines_.went_down(lines); }

private:
    Streams& streams_;
    const bool prints_steps_;
    LiveLines lines_;
    const ano::TimePoint began_ = ano::Clock::now();
    std::string printed_, printed_stop_;
};

}    // namespace anoctl
