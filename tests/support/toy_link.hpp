// A kind of link that a test defines: toy:WORD[,times=N] sends one frame with WORD as its DATA, N times, as soon as it is up. All
// of it is in this file, as each kind of the program is in one; the table of kinds needs one more row.
#pragma once
#include <ano/frame.hpp>
#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/feed.hpp>
#include <link/make_link.hpp>

#include <array>

namespace support {

struct ToySettings {
    std::string word;
    std::uint8_t times = 1;
    bool operator==(const ToySettings&) const = default;
};

class ToyLink final : public anogate::Link {
public:
    static constexpr std::uint8_t frame_id = 0xF7, source = 30;

    ToyLink(anogate::LinkId id, anogate::LinkSettings settings, const anogate::LinkContext& context)
        : Link{id, std::move(settings)}, host_{context.host} {}

    void start() override {
        channel_ = host_.open_channel(*this, "toy");
        host_.link_up(*this);
        const auto& toy = settings().as<ToySettings>();
        std::array<std::uint8_t, 64> room;
        const std::size_t size = ano::encode(room, source, 0xFF, frame_id,
                                             {reinterpret_cast<const std::uint8_t*>(toy.word.data()), toy.word.size()});
        channel_->arrived_at = host_.now();
        for (unsigned i = 0; i < toy.times; ++i)
            anogate::feed_datagram(channel_->parser, std::span{room}.first(size), channel_->arrived_at,
                                   [this](ano::FrameView frame) { host_.receive(*channel_, frame); });
        host_.flush();
    }
    void stop_reading() override {}
    void stop() override {}
    void flush(anogate::Channel& channel) override { channel.outbox.close(); }
    anogate::LinkFacts facts() const override { return {{"word", settings().as<ToySettings>().word}}; }

private:
    anogate::LinkHost& host_;
    anogate::Channel* channel_ = nullptr;
};

namespace toy {
using namespace anogate::key_rows;

inline constexpr anogate::Key<anogate::LinkSettings> keys[] = {
    text<own<ToySettings>, &ToySettings::word>("word", 1, 20, "what the toy says") | needed,
    integer<own<ToySettings>, &ToySettings::times>("times", 1, 9, "how often the toy says it"),
};

inline void validate(const anogate::LinkSettings& link, anogate::LinkFaults& faults) {
    if (faults.is_whole() && link.as<ToySettings>().word == "no") faults.error("word", "'word' can't be 'no': toys are friendly");
}
}    // namespace toy

inline constexpr anogate::LinkKind toy_kind{
    .name = "toy",
    .address = "word",
    .example = "hello",
    .help = "a toy that says a word",
    .carries = anogate::Carries::pieces,
    .hints = {.nothing_yet = {"nothing_from_toy", "the toy is silent: is it asleep?"}},
    .keys = toy::keys,
    .settings = [] { return anogate::KindSettings{ToySettings{}}; },
    .make = anogate::make_link_of<ToyLink>,
    .usual_name = [](const anogate::LinkSettings& link) { return "toy-" + link.as<ToySettings>().word; },
    .validate = toy::validate,
};

}    // namespace support
