// The laws of the translation for any traffic. Byte 0 chooses the settings; then each step is a byte modulo 4 and its arguments:
//
//   0   a length N, D_ADDR, ID, and N bytes: a V7 frame of the device
//   1   a length N, S_ADDR, D_ADDR, ID, and N bytes: a V8 frame to the device
//   2   hundredths of a second that pass
//   3   an acknowledgement of the last frame that was sent to the device
#include <gateway/v7_translation.hpp>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

using Rest = std::span<const std::uint8_t>;
namespace v7 = ano::v7;

void require(bool holds, const char* law) {
    if (holds) return;
    std::fprintf(stderr, "%s\n", law);
    std::abort();
}

std::uint8_t take_byte(Rest& rest) {
    if (rest.empty()) return 0;
    const std::uint8_t byte = rest.front();
    rest = rest.subspan(1);
    return byte;
}

Rest take(Rest& rest, std::size_t n) {
    n = std::min(n, rest.size());
    const Rest taken = rest.first(n);
    rest = rest.subspan(n);
    return taken;
}

anogate::V7Settings settings_of(std::uint8_t choice) {
    anogate::V7Settings settings{.address = (choice & 1) != 0 ? std::uint8_t{0xDD} : std::uint8_t{0xDE}};
    if ((choice & 2) != 0) settings.down.set();
    if ((choice & 4) != 0) settings.ack = anogate::V7Ack::sent;
    if ((choice & 8) != 0) settings.layout = anogate::V7Layout::keep;
    if ((choice & 16) != 0) settings.parameters = anogate::v7_lx_parameters();
    if ((choice & 32) != 0) settings.sources = {{0x34, 0x51, 0xDE}, {0xF1, 0xFA, 0xDB}};
    if ((choice & 64) != 0) settings.max_data = 255;
    return settings;
}

class Link final : public anogate::V7Output {
public:
    explicit Link(std::uint8_t choice) : translation_{settings_of(choice)} {}

    void step(Rest& rest) {
        commands_ = 0;
        std::array<std::uint8_t, 300> frame{};
        switch (take_byte(rest) % 4) {
        case 0: {
            const std::size_t n = take_byte(rest);
            const std::uint8_t to = take_byte(rest), id = take_byte(rest);
            const std::size_t size = v7::encode(frame, to, id, take(rest, n));
            translation_.up(v7::FrameView{Rest{frame}.first(size)}, now_, *this);
            return require(commands_ == 0, "a frame of the device caused a command");
        }
        case 1: {
            const std::size_t n = take_byte(rest);
            const std::uint8_t from = take_byte(rest), to = take_byte(rest), id = take_byte(rest);
            const std::size_t size = ano::encode(frame, from, to, id, take(rest, n));
            translation_.down(ano::FrameView{Rest{frame}.first(size)}, now_, *this);
            return require(commands_ <= 1, "a command was sent twice");
        }
        case 2:
            now_ += std::chrono::milliseconds{10 * take_byte(rest)};
            translation_.expire(now_, *this);
            if (const auto due = translation_.deadline()) require(*due > now_, "the deadline is past");
            return require(commands_ == 0, "a command was repeated");
        default:
            if (last_.empty()) return;
            const std::array<std::uint8_t, 3> check{last_[2], last_[last_.size() - 2], last_[last_.size() - 1]};
            translation_.up(v7::FrameView{Rest{frame}.first(v7::encode(frame, 0xAF, 0x00, check))}, now_, *this);
        }
    }

    void to_device(v7::FrameView frame) override {
        require(v7::frame_at(frame.bytes()).has_value(), "not a V7 frame");
        require(!anogate::V7Translation::is_of_own_sensor(frame.id()), "the device would take it for its own measurement");
        require(!frame.data().empty() && frame.data().size() <= translation_.settings().max_data, "a length that devices refuse");
        const Rest data = frame.data();
        require(frame.id() != 0xE0 || !(data[0] == 0x01 && data[1] == 0x20 && data[2] == 0xAA), "it erases the firmware");
        commands_ += frame.id() == 0xE0;
        last_.assign(frame.bytes().begin(), frame.bytes().end());
    }
    void from_device(ano::FrameView frame) override {
        require(ano::frame_at(frame.bytes()).has_value() && !frame.data().empty(), "not a V8 frame with data");
    }

private:
    anogate::V7Translation translation_;
    ano::TimePoint now_{std::chrono::hours{1}};
    std::vector<std::uint8_t> last_;
    unsigned commands_ = 0;
};

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Rest rest{data, size};
    Link link{take_byte(rest)};
    while (!rest.empty()) link.step(rest);
    return 0;
}
