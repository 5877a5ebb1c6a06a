#include <mqtt/uplink.hpp>

#include <chrono>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;
using ano::Clock;

constexpr std::uint64_t backlog_id = std::uint64_t{1} << 63;    // of the batch in flight; others are the seq of a record
constexpr ano::Duration full_pause = 1s;                        // after the broker could not accept more
constexpr ano::Duration store_interval = Delivery::patience;    // without a connection: a record is stored within a second
constexpr std::size_t kept_for_backlog = 1;                     // of the window

}    // namespace

void Uplink::add(Record record) {
    delivery_.add(std::move(record));
    publish();
    if (delivery_.bytes() > Delivery::max_bytes) spool_.store(delivery_.take_old(Clock::now()));
}

void Uplink::on_connected(std::size_t window) {
    is_connected_ = true;
    window_ = window;
    publish();
    if (!batch_ && !std::exchange(is_asked_, true)) spool_.ask_next(0);
}

void Uplink::on_disconnected() {
    is_connected_ = is_in_flight_ = false;
    delivery_.on_disconnected();
}

void Uplink::publish() {
    if (!is_connected_ || Clock::now() < paused_until_) return;
    const std::size_t window = window_ > kept_for_backlog ? window_ - kept_for_backlog : window_;
    while (broker_.has_room()) {
        const Record* const record = delivery_.next(window);
        if (record == nullptr) return publish_backlog();
        broker_.publish({.id = record->seq, .topic = record->topic, .payload = record->json});
    }
}

// Live records are published first: this is called when none waits.
void Uplink::publish_backlog() {
    if (!batch_ || is_in_flight_) return;
    const auto now = Clock::now();
    if (!pace_.may_publish(now)) {
        backlog_timer_.expires_at(pace_.next());
        return backlog_timer_.async_wait([this](error_code ec) {
            if (!ec) publish();
        });
    }
    is_in_flight_ = true;
    pace_.on_published(batch_->batch.body.size(), now);
    broker_.publish({.id = backlog_id,
                     .topic = topics_.backlog(batch_->batch.keep),
                     .payload = batch_->batch.body,
                     .content_type = "application/zstd"});
}

void Uplink::on_answered(std::uint64_t id, std::uint8_t reason) {
    const Fate fate = fate_of(reason);
    if (fate == Fate::wait) paused_until_ = Clock::now() + full_pause;
    count(fate);
    if (id == backlog_id) on_backlog_answered(fate);
    else delivery_.on_answer(id, fate);
    publish();
}

void Uplink::on_backlog_answered(Fate fate) {
    if (!std::exchange(is_in_flight_, false) || !batch_) return;
    pace_.on_acknowledged(Clock::now());
    if (fate == Fate::wait) return;
    const std::int64_t done = std::exchange(batch_, std::nullopt)->id;
    is_asked_ = true;
    spool_.ask_next(done);
}

void Uplink::count(Fate fate) {
    if (fate != Fate::wait) ++counts_.published;
    if (fate == Fate::unread) ++counts_.unread;
    if (fate == Fate::denied) ++counts_.denied;
    if (fate == Fate::refused) ++counts_.refused;
}

void Uplink::on_spooled(SpooledBatch batch) {
    is_asked_ = false;
    if (batch.id == 0) return;
    batch_ = std::move(batch);
    publish();
}

void Uplink::on_spool_state(const SpoolState& state) {
    counts_.waiting = state.waiting;
    counts_.spooled = state.stored;
    counts_.dropped = state.dropped;
    if (is_connected_ && state.waiting > 0 && !batch_ && !std::exchange(is_asked_, true)) spool_.ask_next(0);
}

void Uplink::on_time() {
    const auto now = Clock::now();
    publish();
    // Without a connection nothing else can happen to a record; with one, it is stored before it is one second old.
    if (!is_connected_ && now - stored_at_ < store_interval) return;
    auto records = is_connected_ ? delivery_.take_old(now) : delivery_.take_all();
    const bool must_remove = now - stored_at_ >= store_interval && counts_.waiting > 0;
    if (records.empty() && !must_remove) return;
    stored_at_ = now;
    spool_.store(std::move(records));
}

}    // namespace anogate
