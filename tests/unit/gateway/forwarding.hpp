// A Forwarder with links, and a record of the events of its observers.
#pragma once
#include <gateway/forwarder.hpp>

#include <support/bytes.hpp>

#include <gtest/gtest.h>

#include <span>
#include <string>
#include <utility>
#include <vector>

namespace forwarding {

using namespace anogate;
using namespace std::chrono_literals;
using support::Bytes;
using support::frame;
using Frames = std::vector<Bytes>;

inline constexpr TimePoint start{1h};
inline constexpr std::uint8_t fc = 0xDC, host = 0xFE, all = 0xFF;

inline const Bytes telemetry = frame(fc, all, 0x03, {1, 2, 3});
inline const Bytes command = frame(host, fc, 0xC0, {1, 2, 3});

template <class Rows, class Counter>
std::string name_of(const Rows& rows, Counter counter) {
    for (const auto& row : rows)
        if (row.value == counter) return std::string{row.name};
    return "?";
}

// "received 0": a channel; "refused 1": a link.
class Diary final : public Forwarder::Observer {
public:
    void received(const Channel& from, ano::FrameView, TimePoint) override { write("received", index(from.id)); }
    void offered(const Channel& to, ano::FrameView frame, ChannelId from) override {
        write(from == ourselves ? "said" : "offered", index(to.id));
        last = {frame.bytes().begin(), frame.bytes().end()};
    }
    void dropped(const Channel& from, ano::FrameView, ReceiveCause cause) override {
        write("dropped", index(from.id), name_of(receive_counters, cause));
    }
    void refused(LinkId to, ano::FrameView, SendCause cause) override {
        write("refused", index(to), name_of(send_counters, cause));
    }
    std::vector<std::string> pop_all() { return std::exchange(lines, {}); }

    Bytes last;    // the last offered frame, as its receiver sees it

private:
    void write(const char* what, std::size_t where, const std::string& why = {}) {
        lines.push_back(what + (" " + std::to_string(where)) + (why.empty() ? "" : " " + why));
    }
    std::vector<std::string> lines;
};
using Lines = std::vector<std::string>;

class Forwarding : public testing::Test {
protected:
    Forwarding() { forwarder.add_observer(diary); }

    /// A link that is up, with one channel. The numbers are equal as long as every link has one channel.
    Channel& add(const ForwarderLink& link = {}) {
        const LinkId id = forwarder.add_link(link);
        Channel* const channel = forwarder.open_channel(id, "", now);
        forwarder.link_up(id, now);
        now += 1ms;
        return *channel;
    }
    template <class Change>
    Channel& add_with(Change change) {
        ForwarderLink link;
        change(link);
        return add(link);
    }
    void receive(Channel& from, const Bytes& bytes) {
        from.arrived_at = now;
        forwarder.receive(from, ano::FrameView{bytes}, now);
    }
    /// From now on it is known that frames sent on `out` return on `back`.
    void close_loop(Channel& out, Channel& back) {
        const Bytes by_both = frame(0x77, all, 0xF1, {1, 2, 3});
        receive(out, by_both);
        receive(back, by_both);
        taken(back);
        for (const Bytes& bytes : taken(out))
            if (is_probe(ano::FrameView{bytes})) receive(back, bytes);
        ASSERT_TRUE(forwarder.loops().loop(out.id, now) && forwarder.loops().loop(back.id, now));
    }
    Lines events(Channel& from, const Bytes& bytes) {
        diary.pop_all();
        receive(from, bytes);
        return diary.pop_all();
    }
    std::vector<Bytes> taken(Channel& channel) {
        std::vector<Bytes> frames;
        std::span<const std::uint8_t> piece[1];
        for (; channel.outbox.gather(piece, now) == 1; channel.outbox.sent_frame())
            frames.emplace_back(piece[0].begin(), piece[0].end());
        return frames;
    }

    Forwarder forwarder{GatewaySettings{}, 7};
    Diary diary;
    TimePoint now = start;
};

inline FilterSettings without(std::uint8_t id) {
    FilterSettings settings;
    settings.deny = {{id, id}};
    return settings;
}

}    // namespace forwarding
