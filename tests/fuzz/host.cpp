// Frames from outside, at any time, into every task of a host. The first byte selects the task (7: a calibration of the
// accelerometer, 15: of the compass; otherwise support::task_of()). Steps of two bytes follow: the time to the step (4 ms each),
// and the event: 0xFF, the device answers the last frame it received; otherwise a frame with this id follows, one byte for its
// length and then its DATA. After the end the device is silent. A task that does not end then has failed.
#include <host/calibration.hpp>
#include <support/fake_loader.hpp>
#include <support/host_tasks.hpp>

#include <algorithm>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <optional>
#include <span>

namespace {

struct Host {
    support::FakeDevice fake;
    support::FakeLoader loader;
    ano::host::Device device{0xDC};
    ano::TimePoint now = ano::TimePoint{} + std::chrono::hours{1};
    support::Bytes last;
    ano::host::Calibration* calibration = nullptr;    // set if it is the task

    Host() {
        fake.make_parameters(12);
        for (const auto sensor : {ano::host::Sensor::accelerometer, ano::host::Sensor::compass})
            for (const std::string& name : ano::host::calibration_names(sensor))
                fake.parameters.push_back({8, name, "", {0, 0, 0x80, 0x3F}});
        fake.commands.resize(3);
        fake.waypoints.resize(4, support::Bytes(22));
        fake.instead = [this](ano::FrameView frame) { return loader.take(fake, frame); };
    }
    void send() {
        while (const auto frame = device.next_frame(now)) {
            if (asks_beyond(*frame)) std::abort();
            last.assign(frame->bytes().begin(), frame->bytes().end());
        }
    }
    // Whether it accesses a parameter beyond the count that the device reported.
    bool asks_beyond(ano::FrameView frame) const {
        const std::size_t at = frame.id() == 0xE1 ? 0 : 1;
        if (frame.id() != 0xE1 && !(frame.id() == 0xE0 && (frame.data()[0] == 2 || frame.data()[0] == 3))) return false;
        return ano::load<std::uint16_t>(frame.data().data() + at) >= device.parameter_count().value_or(0);
    }
    void answer() {
        if (last.empty()) return;
        for (const support::Bytes& answer : fake.take(ano::FrameView{last})) receive(answer);
    }
    void receive(const support::Bytes& frame) {
        device.take(ano::FrameView{frame}, now);
        if (calibration != nullptr) calibration->receive(ano::FrameView{frame}, now);
    }
    std::unique_ptr<ano::host::Task> begin(std::uint8_t kind) {
        if (kind % 8 != 7) return support::task_of(kind, device, now);
        const auto sensor = kind % 16 == 7 ? ano::host::Sensor::accelerometer : ano::host::Sensor::compass;
        auto task = std::make_unique<ano::host::Calibration>(device, sensor);
        calibration = task.get();
        task->start(now);
        return task;
    }
    // The actions of a calibration's owner.
    void look() {
        if (calibration == nullptr) return;
        calibration->look(now);
        if (calibration->step() == ano::host::Calibration::Step::keep) calibration->kept(now);
    }
    std::optional<ano::TimePoint> due() const {
        const auto first = device.due(), second = calibration != nullptr ? calibration->due() : std::nullopt;
        return first && second ? std::min(first, second) : first ? first : second;
    }
    // Runs the first step; returns the rest of the steps.
    std::span<const std::uint8_t> step(std::span<const std::uint8_t> in) {
        now += std::chrono::milliseconds{4 * in[0]};
        look();
        send();
        if (in[1] == 0xFF) {
            answer();
            return in.subspan(2);
        }
        if (in.size() < 3) return {};
        const std::size_t size = std::min<std::size_t>(in[2], in.size() - 3);
        const support::Bytes frame = support::frame(0xDC, 0xFE, in[1],
                                                    {in.begin() + 3, in.begin() + 3 + static_cast<std::ptrdiff_t>(size)});
        receive(frame);
        return in.subspan(3 + size);
    }
};

}    // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
    if (size == 0) return 0;
    Host host;
    const auto task = host.begin(bytes[0]);
    std::span<const std::uint8_t> in{bytes + 1, size - 1};
    while (in.size() >= 2 && !task->end()) in = host.step(in);
    const ano::TimePoint silent_since = host.now;
    host.look();
    for (host.send(); !task->end(); host.send()) {
        const auto due = host.due();
        if (!due || *due - silent_since > std::chrono::hours{1}) std::abort();
        host.now = std::max(host.now, *due);
        host.look();
    }
    return 0;
}
