// Pseudo-terminals whose other ends are devices that send without a pause.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace bench {

class TalkingPtys {
public:
    /// Each of `count` devices sends whole frames to `destination`, `rate` bytes/s, in writes of one millisecond's bytes, which
    /// may split a frame anywhere; rate 0: as much as is accepted. The devices' addresses count up from 0x43.
    TalkingPtys(std::size_t count, std::uint8_t destination, std::size_t rate);
    ~TalkingPtys();
    TalkingPtys(const TalkingPtys&) = delete;
    TalkingPtys& operator=(const TalkingPtys&) = delete;

    /// The path to open for the frames of device `i`.
    const std::string& path(std::size_t i) const { return devices_[i].path; }
    void start();
    /// Stops each device after a whole frame.
    void stop();
    /// The total sent by all devices. Valid when stopped.
    std::uint64_t frames() const noexcept;

private:
    struct Device {
        int fd;
        int other_end;    // kept open, otherwise ours would report an end until a program opens it
        std::string path;
        std::uint8_t address;
        std::uint64_t bytes = 0;    // sent
    };
    void talk();
    void talk_at_a_rate();
    void send(Device& device, std::uint64_t until);

    std::vector<Device> devices_;
    std::vector<std::vector<std::uint8_t>> streams_;    // of each device: frames enough for one write, sent repeatedly
    std::size_t rate_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}    // namespace bench
