// A device's loader, as simple as a test needs it: hook it in as FakeDevice::instead.
#pragma once
#include <ano/crc16.hpp>
#include <support/fake_device.hpp>

#include <optional>
#include <vector>

namespace support {

class FakeLoader {
public:
    bool refuses = false;
    bool cannot_erase = false;
    bool erases_silently = false;
    bool checks_silently = false;
    unsigned fails_frame_7 = 0;    // so many times
    bool fails_every_frame_once = false;
    std::optional<std::uint16_t> dies_at{};    // from this frame on it says nothing
    std::size_t flash_bytes = std::size_t{1} << 20;

    std::size_t infos = 0, erases = 0, checks = 0, frames = 0;
    Bytes info, flash;

    std::optional<std::vector<Bytes>> take(FakeDevice& device, ano::FrameView frame) {
        if (frame.id() != 0xF0) return std::nullopt;
        const auto data = frame.data();
        const auto said = [&](std::uint16_t code) {
            return std::vector<Bytes>{
                device.to_host(frame, 0xF0, {0, static_cast<std::uint8_t>(code), static_cast<std::uint8_t>(code >> 8)})};
        };
        if (data[0] == 0x01) {
            ++infos;
            info.assign(data.begin(), data.end());
            return said(refuses || ano::load<std::uint32_t>(data.data() + 1) > flash_bytes ? 0x0101 : 0x0102);
        }
        if (data[0] == 0x10) return written(device, frame);
        if (data[1] == 0x10 && data[2] == 0x01) {
            ++erases;
            flash.clear();
            if (erases_silently) return std::vector<Bytes>{};
            return said(cannot_erase ? 0x0111 : 0x0112);
        }
        ++checks;
        if (checks_silently) return std::vector<Bytes>{};
        const bool whole = flash.size() == ano::load<std::uint32_t>(info.data() + 1);
        const auto crc = ano::crc16_of(flash);
        return said(whole && crc == ano::load<std::uint16_t>(info.data() + 7) ? 0x1012 : 0x1011);
    }

private:
    std::optional<std::uint16_t> failed_;

    std::vector<Bytes> written(FakeDevice& device, ano::FrameView frame) {
        ++frames;
        const auto number = ano::load<std::uint16_t>(frame.data().data() + 1);
        if (dies_at && number >= *dies_at) return {};
        const auto answer = [&](std::uint8_t code) {
            return std::vector<Bytes>{device.to_host(
                frame, 0xF0, {0, code, 0x10, static_cast<std::uint8_t>(number), static_cast<std::uint8_t>(number >> 8)})};
        };
        if (fails_every_frame_once && failed_ != number) {
            failed_ = number;
            return answer(0x01);
        }
        if (number == 7 && fails_frame_7 > 0) {
            --fails_frame_7;
            return answer(0x01);
        }
        const std::size_t at = number * std::size_t{ano::load<std::uint16_t>(info.data() + 5)};
        const auto bytes = frame.data().subspan(3);
        if (flash.size() < at + bytes.size()) flash.resize(at + bytes.size());
        std::copy(bytes.begin(), bytes.end(), flash.begin() + static_cast<std::ptrdiff_t>(at));
        return answer(0x02);
    }
};

}    // namespace support
