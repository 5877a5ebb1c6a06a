// Hosts a link without a gateway: provides its context, and stores its channels and the frames received on them.
#pragma once
#include "bytes.hpp"
#include "wait.hpp"

#include <gateway/v7_echo_watch.hpp>
#include <link/clocks.hpp>
#include <link/link_context.hpp>
#include <link/resolver.hpp>
#include <link/udp/datagram_batch.hpp>
#include <link/udp/datagram_sender.hpp>
#include <sys/alarm.hpp>
#include <sys/asio.hpp>

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace support {

class BareLinkHost final : public anogate::LinkHost {
public:
    explicit BareLinkHost(anogate::Duration names_kept_for = std::chrono::seconds{60}) : names_{io, names_kept_for} {}

    anogate::Channel* open_channel(anogate::Link& link, std::string peer) override {
        const anogate::ChannelId id{static_cast<std::uint8_t>(opened_++)};
        channels_.push_back(std::make_unique<anogate::Channel>(id, link.id(), std::move(peer), ano::FrameParser::Options{},
                                                               anogate::Outbox::Options{}, now()));
        return channels_.back().get();
    }
    void close_channel(anogate::Channel& channel, std::string_view) override {
        std::erase_if(channels_, [&](const auto& c) { return c.get() == &channel; });
    }
    void receive(anogate::Channel& channel, ano::FrameView frame) override {
        Bytes& heard = heard_[channel.peer];
        heard.insert(heard.end(), frame.bytes().begin(), frame.bytes().end());
    }
    void flush() override {}
    void changed(anogate::Link&, LinkEvent event, anogate::LinkError reason) override {
        if (event == LinkEvent::up) {
            ++ups;
            why.clear();
            for (const auto& channel : channels_) channel->outbox.open();
        } else if (event == LinkEvent::down) {
            why = std::move(reason.text);
            for (const auto& channel : channels_) channel->outbox.close();
        }
    }
    std::optional<anogate::StoredLink> claim_stored(const anogate::Link&) override { return std::exchange(stored, std::nullopt); }
    anogate::TimePoint now() override { return turn().now(); }
    const anogate::StallDetector& turn() override {
        loop_.turn(clocks());
        return loop_;
    }

    anogate::LinkContext context() { return {io, alarms_, *this, batch_, sender_, names_, v7_lines_}; }
    const std::vector<std::unique_ptr<anogate::Channel>>& channels() const { return channels_; }
    /// All frames received on channels of this peer.
    const Bytes& heard(const std::string& peer) { return heard_[peer]; }

    /// Runs the loop until `holds` returns true.
    bool until(const std::function<bool()>& holds) {
        return wait_until(holds, patience, [this] {
            io.restart();
            io.run_for(std::chrono::milliseconds{1});
        });
    }

    boost::asio::io_context io{1};
    std::function<anogate::ClockReading()> clocks = anogate::read_clocks;
    std::optional<anogate::StoredLink> stored;    // for the link that opens next
    int ups = 0;
    std::string why = "nobody said anything";    // the reason why the link is down; empty: it is up

private:
    anogate::AlarmClock alarms_{io};
    anogate::DatagramBatch batch_;
    anogate::DatagramSender sender_;
    anogate::Resolver names_;
    anogate::V7Lines v7_lines_;
    anogate::StallDetector loop_;
    std::vector<std::unique_ptr<anogate::Channel>> channels_;
    std::size_t opened_ = 0;    // in total, at most 64: no number is used twice
    std::map<std::string, Bytes> heard_;
};

}    // namespace support
