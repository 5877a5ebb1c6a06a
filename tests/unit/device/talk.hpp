// A host that sends requests to a device, frame by frame.
#pragma once
#include <device/device.hpp>

#include <support/bytes.hpp>

#include <optional>
#include <string_view>
#include <vector>

namespace talk {

using support::Bytes;

inline constexpr std::uint8_t host = 0xFE, self = 0x21, everybody = 0xFF;
inline constexpr ano::TimePoint start{std::chrono::seconds{1000}};

/// All frames that the device has to send now.
inline std::vector<Bytes> heard(ano::device::Device& device) {
    std::vector<Bytes> frames;
    while (const auto out = device.next()) frames.emplace_back(out->frame.bytes().begin(), out->frame.bytes().end());
    return frames;
}

/// All frames that the device sends after `question`.
inline std::vector<Bytes> all_answers(ano::device::Device& device, const Bytes& question, ano::TimePoint now = start) {
    device.take(ano::FrameView{question}, now);
    return heard(device);
}

/// Its single answer; empty: it does not answer, or answers twice.
inline Bytes answer(ano::device::Device& device, const Bytes& question, ano::TimePoint now = start) {
    const auto frames = all_answers(device, question, now);
    return frames.size() == 1 ? frames.front() : Bytes{};
}

/// A frame from the host to the device.
inline Bytes ask(std::uint8_t id, const Bytes& data) { return support::frame(host, self, id, data); }
/// A frame from the device to the host.
inline Bytes expected_reply(std::uint8_t id, const Bytes& data) { return support::frame(self, host, id, data); }
/// The acknowledgement of `question` by the device, sent to the source of the question.
inline Bytes acknowledges(const Bytes& question) {
    return support::frame(self, question[1], 0x00, {question[3], question[question.size() - 2], question.back()});
}

inline Bytes bytes(std::string_view text, std::size_t size = 0) {
    Bytes result(text.begin(), text.end());
    if (size > result.size()) result.resize(size);
    return result;
}
inline const Bytes silence;

}    // namespace talk
