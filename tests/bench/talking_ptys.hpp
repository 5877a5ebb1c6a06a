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
    /// Each of `count` devices sends whole frames to `destination`, `rate` bytes/s, in writes of a millisecond's bytes, which may
    /// cut a frame anywhere; rate 0: as much as is taken. The devices' addresses count up from 0x43.
    TalkingPtys(std::size_t count, std::uint8_t destination, std::size_t rate);
    ~TalkingPtys();
    TalkingPtys(const TalkingPtys&) = delete;
    TalkingPtys& operator=(const TalkingPtys&) = delete;

    /// What to open to hear device `i`.
    const std::string& path(std::size_t i) const { return devices_[i].path; }
    void start();
    /// Stops each behind a whole frame.
    void stop();
    /// Sent by all of them since the beginning. Valid when stopped.
    std::uint64_t frames() const noexcept;

private:
    struct Device {
        int fd;
        int other_end;    // held open, or ours would report an end while nobody has opened it
        std::string path;
        std::uint8_t address;
        std::uint64_t bytes = 0;    // sent
    };
    void talk();
    void talk_at_a_rate();
    void send(Device& device, std::uint64_t until);

    std::vector<Device> devices_;
    std::vector<std::vector<std::uint8_t>> streams_;    // of each device: frames enough for a write, again and again
    std::size_t rate_;
    std::atomic<bool> stop_{false};
    std::thread thread_;
};

}    // namespace bench
