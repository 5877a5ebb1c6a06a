#include "job_view.hpp"

#include "job_text.hpp"

#include <anoctl/say.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>
#include <anoctl/text/terminal.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <ostream>

namespace anoctl {

void LiveLines::show(std::vector<std::string> lines, std::size_t width) {
    for (std::string& line : lines) line = in_cells(line, width - std::min<std::size_t>(width, 1));
    if (lines.empty() && shown_ == 0) return;
    err_ << '\r';
    if (const std::size_t up = shown_ + below_; up > 1) err_ << "\x1b[" << up - 1 << 'A';
    err_ << "\x1b[J";
    for (std::size_t i = 0; i < lines.size(); ++i) err_ << (i > 0 ? "\r\n" : "") << lines[i];
    shown_ = lines.size();
    below_ = 0;
    err_.flush();
}

void ProgressView::show(const ano::Json& job) {
    if (streams_.err_is_terminal) {
        const double seconds = std::chrono::duration<double>(ano::Clock::now() - began_).count();
        const std::size_t width = Screen::size().width;
        return lines_.show({progress_text(job, seconds, width)}, width);
    }
    if (const std::string stopped = text_at(job, "stopped"); stopped != printed_stop_) {
        printed_stop_ = stopped;
        if (!stopped.empty()) print_note(streams_, stopped);
    }
    const std::string message = step_text(job);
    if (!prints_steps_ || message.empty() || message == printed_) return;
    printed_ = message;
    print_note(streams_, message);
}

}    // namespace anoctl
