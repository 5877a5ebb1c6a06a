#include <link/clocks.hpp>
#include <runtime/gateway.hpp>
#include <watch/frame_watch.hpp>
#include <watch/record_json.hpp>

#include <algorithm>
#include <new>
#include <utility>

namespace anogate {
namespace {

std::uint64_t nanoseconds(ano::Duration time) noexcept {
    return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::nanoseconds>(time).count());
}

WatchQueue::Tables tables_of(const Gateway& gateway) {
    WatchTables tables;
    for (const LinkState& state : gateway.links()) {
        const std::size_t number = index(state.link->id());
        if (tables.links.size() <= number) tables.links.resize(number + 1);
        tables.links[number] = state.link->name();
    }
    for (const ChannelId id : gateway.forwarder().channels()) {
        tables.peers.resize(index(id) + 1);
        tables.peers[index(id)] = gateway.forwarder().channel(id).peer;
    }
    tables.decoding = gateway.decoding();
    tables.text = tables_json(tables);
    return std::make_shared<const WatchTables>(std::move(tables));
}

LinkSet links_called(const std::vector<std::string>& names, const WatchTables& tables) {
    if (names.empty()) return ~LinkSet{};
    LinkSet links;
    for (std::size_t i = 0; i < tables.links.size(); ++i)
        if (std::find(names.begin(), names.end(), tables.links[i]) != names.end()) links.insert(static_cast<LinkId>(i));
    return links;
}

std::uint8_t number_of(const Channel& channel) noexcept {
    return channel.id == ourselves ? FrameRecord::no_channel : static_cast<std::uint8_t>(channel.id);
}

}    // namespace

FrameWatch::FrameWatch(Gateway& gateway)
    : gateway_{gateway}, links_due_{gateway.alarms(), [this] {
                                        look_at_links();
                                        for (const auto& stream : streams_) stream->deliver();
                                    }} {}

FrameWatch::~FrameWatch() {
    if (!streams_.empty()) gateway_.forwarder().remove_observer(*this);
}

void FrameWatch::add(Watcher& watcher, const FrameFilterSettings& settings) {
    look_at_links();
    join(watcher, settings);
    observe();
    watcher.queue.push(tables_);
    watcher.more();
}

void FrameWatch::join(Watcher& watcher, const FrameFilterSettings& settings) {
    auto stream = std::find_if(streams_.begin(), streams_.end(), [&](const auto& s) { return s->settings == settings; });
    if (stream == streams_.end()) stream = streams_.insert(streams_.end(), std::make_unique<Stream>(gateway_.alarms(), settings));
    (*stream)->end_batch(gateway_.time());    // the new watcher must not get earlier frames
    (*stream)->filter.set_links(links_called(settings.links, *tables_));
    (*stream)->watchers.push_back(&watcher);
}

void FrameWatch::change(Watcher& watcher, const FrameFilterSettings& settings) {
    look_at_links();
    for (const auto& stream : streams_)
        if (std::find(stream->watchers.begin(), stream->watchers.end(), &watcher) != stream->watchers.end()) {
            stream->end_batch(gateway_.time());
            std::erase(stream->watchers, &watcher);
        }
    std::erase_if(streams_, [](const auto& stream) { return stream->watchers.empty(); });
    join(watcher, settings);
    observe();
}

void FrameWatch::remove(Watcher& watcher) {
    const std::size_t before = streams_.size();
    for (auto& stream : streams_) {
        const auto place = std::find(stream->watchers.begin(), stream->watchers.end(), &watcher);
        if (place == stream->watchers.end()) continue;
        stream->end_batch(gateway_.time());    // the watcher may still read its frames
        stream->watchers.erase(place);
    }
    std::erase_if(streams_, [](const auto& stream) { return stream->watchers.empty(); });
    if (!streams_.empty()) return observe();
    if (before == 0) return;
    gateway_.forwarder().remove_observer(*this);
    links_due_.cancel();
    tables_.reset();
    memory_.clear();
}

// Requests from the Forwarder only the directions that some filter accepts.
void FrameWatch::observe() {
    Forwarder::Observer::Wants wants{false, false, false};
    for (const auto& stream : streams_) {
        const auto& [in, out, dropped] = stream->settings.directions;
        wants.arrivals = wants.arrivals || in;
        wants.fates = wants.fates || dropped;
        wants.departures = wants.departures || out || dropped;
    }
    gateway_.forwarder().add_observer(*this, wants);
}

void FrameWatch::received(const Channel& from, ano::FrameView frame, TimePoint arrived_at) {
    const bool is_elsewhere = gateway_.forwarder().is_elsewhere(from, frame.source());
    note({Direction::in, from.link, number_of(from), 0, is_elsewhere, from.raw}, frame, arrived_at);
}

void FrameWatch::dropped(const Channel& from, ano::FrameView frame, ReceiveCause cause) {
    note({Direction::dropped, from.link, number_of(from), anogate::number_of(cause), false, from.raw}, frame, gateway_.time());
}

void FrameWatch::refused(LinkId to, ano::FrameView frame, SendCause cause) {
    note({Direction::dropped, to, FrameRecord::no_channel, anogate::number_of(cause)}, frame, gateway_.time());
}

void FrameWatch::left(const Channel& to, ano::FrameView frame) noexcept {
    note({Direction::out, to.link, number_of(to), 0, false, to.raw}, frame, gateway_.time());
}

void FrameWatch::discarded(const Channel& to, ano::FrameView frame, SendCause cause) noexcept {
    note({Direction::dropped, to.link, number_of(to), anogate::number_of(cause)}, frame, gateway_.time());
}

// Watchers get new tables after the removal of a link, even without further frames.
void FrameWatch::removed(LinkId) { links_due_.set(Clock::now()); }

void FrameWatch::catch_up(const Watcher& watcher) {
    for (const auto& stream : streams_)
        if (std::find(stream->watchers.begin(), stream->watchers.end(), &watcher) != stream->watchers.end())
            stream->end_batch(gateway_.time());
}

// If memory is missing, the frame counts as lost for all watchers whose filter accepts it.
void FrameWatch::note(const Event& event, ano::FrameView frame, TimePoint at) noexcept {
    if (has_other_links()) [[unlikely]]
        try {
            look_at_links();
        } catch (const std::bad_alloc&) {    // the old names remain until the next frame
        }
    for (const auto& stream : streams_) {
        if (stream->is_nearly_due(gateway_.time())) [[unlikely]]
            stream->leave_soon();
        if (!stream->filter.takes(event.direction, static_cast<std::uint8_t>(event.link), frame, at, event.is_elsewhere))
            continue;
        try {
            record(*stream, event, frame, at);
        } catch (const std::bad_alloc&) {
            for (Watcher* watcher : stream->watchers) watcher->queue.lose(frame.id(), at);
        }
    }
}

// A finished batch is passed to the watchers whose queue is open. While no queue is open, frames are counted and not copied.
void FrameWatch::record(Stream& stream, const Event& event, ano::FrameView frame, TimePoint at) {
    const auto is_ready = [](const Watcher* watcher) { return watcher->queue.is_open(); };
    if (std::none_of(stream.watchers.begin(), stream.watchers.end(), is_ready)) {
        for (Watcher* watcher : stream.watchers) watcher->queue.lose(frame.id(), at);
        return;
    }
    if (!stream.due.is_set()) stream.due.set(Clock::now() + stream.settings.batch);
    if (!stream.batch) begin_batch(stream);
    const std::uint64_t time = nanoseconds(at.time_since_epoch());
    const FrameRecord record{
        time + real_ns_, time + boot_ns_,    static_cast<std::uint8_t>(event.link),
        event.direction, event.cause,        event.channel,
        frame,           event.is_elsewhere, stream.settings.raw ? event.raw : std::span<const std::uint8_t>{}};
    std::string& batch = *stream.batch;
    if (const std::size_t end = stream.filled + record.size(); end > batch.size()) batch.resize(std::max(end, 2 * batch.size()));
    write(batch.data() + stream.filled, record);
    stream.filled += record.size();
    if (stream.filled < batch_size) return;
    stream.end_batch(gateway_.time());
    stream.leave_soon();
}

// Allocates the size of the last batch, so that a batch seldom has to grow and small waiting batches use little memory.
void FrameWatch::begin_batch(Stream& stream) {
    read_clocks();
    stream.batch = memory_.acquire(stream.usual + stream.usual / 8);
    stream.filled = 0;
}

void FrameWatch::read_clocks() {
    const ClockReading clocks = anogate::read_clocks();
    const std::uint64_t now = nanoseconds(clocks.now.time_since_epoch());
    real_ns_ = nanoseconds(clocks.real) - now;
    boot_ns_ = nanoseconds(clocks.boot) - now;
}

bool FrameWatch::has_other_links() const noexcept {
    return !tables_ || version_ != gateway_.forwarder().version() || tables_->decoding != gateway_.decoding();
}

// Ends all batches before the new tables, because earlier records use the old numbers.
void FrameWatch::look_at_links() {
    if (!has_other_links()) return;
    tables_ = tables_of(gateway_);
    version_ = gateway_.forwarder().version();
    for (const auto& stream : streams_) {
        stream->end_batch(gateway_.time());
        stream->filter.set_links(links_called(stream->settings.links, *tables_));
        for (Watcher* watcher : stream->watchers) watcher->queue.push(tables_);
    }
}

// False: the queue is full, or memory is missing.
bool FrameWatch::Stream::takes(Watcher& watcher, const WatchQueue::Batch& ended) {
    try {
        return watcher.queue.push(ended);
    } catch (const std::bad_alloc&) {
        return false;
    }
}

void FrameWatch::Stream::end_batch(TimePoint now) {
    if (!batch) return;
    batch->resize(filled);
    usual = filled;
    const WatchQueue::Batch ended = std::exchange(batch, nullptr);
    for (Watcher* watcher : watchers) {
        if (takes(*watcher, ended)) continue;
        std::string_view rest = *ended;
        while (const auto record = next_record(rest)) watcher->queue.lose(record->frame.id(), now);
    }
}

void FrameWatch::Stream::deliver() {
    const TimePoint now = Clock::now();
    const bool is_to_go_on = std::exchange(goes_on, false) && batch;
    end_batch(now);
    if (is_to_go_on) due.set(now + settings.batch);
    for (Watcher* watcher : watchers) watcher->more();
}

// Delivers after the frames of the current read, without an extra wake-up. The timer is not set again while frames keep arriving.
void FrameWatch::Stream::leave_soon() noexcept {
    if (std::exchange(goes_on, true)) return;
    try {
        due.hurry();
    } catch (const std::bad_alloc&) {    // delivered at the set time
    }
}

}    // namespace anogate
