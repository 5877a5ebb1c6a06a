// The firmware loader of a device, only as complete as tests need it. To be used as FakeDevice::instead.
#pragma once
#include <ano/crc16.hpp>
#include <support/fake_device.hpp>

#include <optional>
#include <vector>

namespace support {

class FakeLoader {
public:
    /// Its reaction to an info while it receives frames.
    enum class SecondInfo { accepts, refuses, ignores };

    bool refuses = false;
    bool cannot_erase = false;
    bool erases_silently = false;
    bool checks_silently = false;
    unsigned fails_frame_7 = 0;    // number of failures of frame 7
    bool fails_every_frame_once = false;
    std::optional<std::uint16_t> dies_at{};    // it does not answer this frame and later ones
    std::size_t flash_bytes = std::size_t{1} << 20;
    bool reads_codes = false;    // codes are high byte first in both directions; it ignores others
    SecondInfo second_info = SecondInfo::accepts;
    bool fails_when_lost = true;                    // false: it does not answer frames that it does not expect
    std::optional<std::uint16_t> sent_instead{};    // sent instead of every code

    std::size_t infos = 0, erases = 0, checks = 0, frames = 0;
    Bytes info, flash;

    /// Discards everything received; it waits for an info.
    void lose_power() {
        receives_ = false;
        info.clear();
        flash.clear();
    }

    std::optional<std::vector<Bytes>> take(FakeDevice& device, ano::FrameView frame) {
        if (frame.id() != 0xF0) return std::nullopt;
        const auto data = frame.data();
        const auto said = [&](std::uint16_t code) {
            return std::vector<Bytes>{device.to_host(frame, 0xF0, Bytes{0} + code_bytes(sent_instead.value_or(code)))};
        };
        if (data[0] == 0x01) {
            ++infos;
            if (receives_ && second_info == SecondInfo::ignores) return std::vector<Bytes>{};
            if (refuses || (receives_ && second_info == SecondInfo::refuses)) return said(0x0101);
            if (ano::load<std::uint32_t>(data.data() + 1) > flash_bytes) return said(0x0101);
            receives_ = false;
            info.assign(data.begin(), data.end());
            return said(0x0102);
        }
        if (data[0] == 0x10) return written(device, frame);
        const Bytes code(data.begin() + 1, data.end());
        if (code == code_bytes(0x0110)) {
            if (info.empty()) return std::vector<Bytes>{};
            ++erases;
            flash.clear();
            receives_ = !cannot_erase;
            if (erases_silently) return std::vector<Bytes>{};
            return said(cannot_erase ? 0x0111 : 0x0112);
        }
        if (code != code_bytes(0x1010)) return std::vector<Bytes>{};
        ++checks;
        if (checks_silently || info.empty()) return std::vector<Bytes>{};
        const bool whole = flash.size() == ano::load<std::uint32_t>(info.data() + 1);
        const auto crc = ano::crc16_of(flash);
        return said(whole && crc == ano::load<std::uint16_t>(info.data() + 7) ? 0x1012 : 0x1011);
    }

private:
    std::optional<std::uint16_t> failed_;
    bool receives_ = false;

    Bytes code_bytes(std::uint16_t code) const {
        const auto low = static_cast<std::uint8_t>(code), high = static_cast<std::uint8_t>(code >> 8);
        return reads_codes ? Bytes{high, low} : Bytes{low, high};
    }

    std::vector<Bytes> written(FakeDevice& device, ano::FrameView frame) {
        ++frames;
        const auto number = ano::load<std::uint16_t>(frame.data().data() + 1);
        if (dies_at && number >= *dies_at) return {};
        const auto answer = [&](std::uint16_t code) {
            return std::vector<Bytes>{device.to_host(
                frame, 0xF0,
                Bytes{0} + code_bytes(code) + Bytes{static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8)})};
        };
        if (!receives_) return fails_when_lost ? answer(0x1001) : std::vector<Bytes>{};
        if (fails_every_frame_once && failed_ != number) {
            failed_ = number;
            return answer(0x1001);
        }
        if (number == 7 && fails_frame_7 > 0) {
            --fails_frame_7;
            return answer(0x1001);
        }
        const std::size_t at = number * std::size_t{ano::load<std::uint16_t>(info.data() + 5)};
        const auto bytes = frame.data().subspan(3);
        if (flash.size() < at + bytes.size()) flash.resize(at + bytes.size());
        std::copy(bytes.begin(), bytes.end(), flash.begin() + static_cast<std::ptrdiff_t>(at));
        return answer(0x1002);
    }
};

}    // namespace support
