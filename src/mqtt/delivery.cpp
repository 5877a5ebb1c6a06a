#include <mqtt/delivery.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

std::size_t size_of(const Record& record) { return sizeof(record) + record.topic.size() + record.json.size(); }

}    // namespace

void Delivery::add(Record record) {
    bytes_ += size_of(record);
    entries_.push_back({std::move(record)});
}

const Record* Delivery::next(std::size_t window) {
    if (in_flight_ >= window) return nullptr;
    while (next_ < entries_.size() && entries_[next_].state != State::waiting) ++next_;
    if (next_ == entries_.size()) return nullptr;
    ++in_flight_;
    entries_[next_].state = State::in_flight;
    return &entries_[next_++].record;
}

void Delivery::on_answer(std::uint64_t seq, Fate fate) {
    if (entries_.empty() || seq < entries_.front().record.seq || seq - entries_.front().record.seq >= entries_.size()) return;
    const auto at = static_cast<std::size_t>(seq - entries_.front().record.seq);
    Entry& entry = entries_[at];
    if (entry.state != State::in_flight) return;
    --in_flight_;
    entry.state = fate == Fate::wait ? State::waiting : State::done;
    if (fate == Fate::wait) next_ = std::min(next_, at);
    pop_done();
}

void Delivery::on_disconnected() {
    for (Entry& entry : entries_)
        if (entry.state == State::in_flight) entry.state = State::waiting;
    in_flight_ = 0;
    next_ = 0;
}

std::vector<Record> Delivery::take_old(ano::TimePoint now) {
    std::size_t count = 0, left = bytes_;
    for (const Entry& entry : entries_) {
        if (now - entry.record.made < patience && left <= max_bytes) break;
        left -= size_of(entry.record);
        ++count;
    }
    return take(count);
}

std::vector<Record> Delivery::take(std::size_t count) {
    std::vector<Record> taken;
    for (std::size_t i = 0; i < count; ++i) {
        Entry& entry = entries_.front();
        bytes_ -= size_of(entry.record);
        if (entry.state == State::in_flight) --in_flight_;
        if (entry.state != State::done) taken.push_back(std::move(entry.record));
        entries_.pop_front();
    }
    next_ -= std::min(next_, count);
    return taken;
}

void Delivery::pop_done() {
    std::size_t count = 0;
    while (count < entries_.size() && entries_[count].state == State::done) ++count;
    take(count);
}

}    // namespace anogate
