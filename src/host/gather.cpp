#include <host/gather.hpp>

#include <string>

namespace ano::host {

void Gather::gather(std::size_t n, TimePoint now) {
    total_ = n;
    done_ = 0;
    asked_ = 0;
    next_ = 0;
    items_.assign(n, {});
    again_.clear();
    missing_.clear();
    ask_more(now);
}

void Gather::ask_more(TimePoint now) {
    if (is_overdue(now)) return;
    while (!end() && asked_ < max_asked && (!again_.empty() || next_ < total_)) {
        std::uint32_t i = next_;
        if (again_.empty()) {
            ++next_;
        } else {
            i = again_.back();
            again_.pop_back();
        }
        Request request = question(i);
        request.tag = i;
        if (!device().ask(request, *this)) {
            stop_at(i);
            break;
        }
        ++items_[i].tried;
        items_[i].is_asked = true;
        ++asked_;
    }
    if (!end() && asked_ == 0) gathered(now);
}

void Gather::ended(const Ended& ended, TimePoint now) {
    if (ended.tag < probing) return question_ended(ended, now);
    if (ended.tag >= first_step) return step_ended(ended, now);
    if (ended.outcome != Outcome::answered) return finish_silent(subject(), ended.evidence, now);
    ask_more(now);
}

void Gather::question_ended(const Ended& ended, TimePoint now) {
    items_[ended.tag].is_asked = false;
    --asked_;
    if (ended.outcome == Outcome::answered && took(ended.tag, *ended.answer)) ++done_;
    else without_answer(ended.tag, ended, now);
    if (end()) return;
    if (ended.outcome != Outcome::timeout || ended.device_answers) return ask_more(now);
    requeue_in_flight();
    Request request = probe();
    request.tag = probing;
    ask(request, now);
}

// Ends the questions in flight because another one got no answer; this does not count as one of their rounds.
void Gather::requeue_in_flight() {
    device().forget(*this);
    for (std::uint32_t i = 0; i < next_; ++i) {
        if (!items_[i].is_asked) continue;
        items_[i].is_asked = false;
        --items_[i].tried;
        again_.push_back(i);
    }
    asked_ = 0;
}

// The device now has fewer items than are being read: no more questions are sent.
void Gather::stop_at(std::uint32_t i) {
    missing_.push_back(i);
    again_.clear();
    next_ = static_cast<std::uint32_t>(total_);
}

void Gather::without_answer(std::uint32_t i, const Ended& ended, TimePoint now) {
    if (ended.outcome == Outcome::not_there) return stop_at(i);
    if (items_[i].tried < rounds) return again_.push_back(i);
    missing_.push_back(i);
    if (missing_.size() > max_missing)
        finish({Ending::incomplete, {"leaves_out", hex_of(device().address()), subject(), missing_.front()}, ended.evidence},
               now);
}

}    // namespace ano::host
