#include <devices/firmware_work.hpp>
#include <host/firmware.hpp>
#include <host/firmware_image.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::Firmware;
using ano::host::Task;

constexpr std::size_t usual_frame = 195;    // bytes of the image; DATA has three more

// "12.3 KB/s, 40 s left"
std::string speed_in_words(double bytes_a_second, std::optional<ano::Duration> left) {
    char text[64];
    std::snprintf(text, sizeof text, "%.1f KB/s", bytes_a_second / 1000);
    if (!left) return text;
    return text + std::string{", "} + std::to_string(std::chrono::ceil<std::chrono::seconds>(*left).count()) + " s left";
}

class Upgrade final : public TaskWork {
public:
    Upgrade(const WorkPlace& place, UpgradeOrder order) : TaskWork{place}, order_{std::move(order)} {}

    // The file may be large: its check is not to keep the loop.
    void start(TimePoint) override {
        const auto read = read_;
        place().net.aside(
            [read, file = std::move(order_.file), crc = order_.crc] {
                const auto* bytes = reinterpret_cast<const std::uint8_t*>(file->data());
                read->file = ano::host::read_firmware({bytes, file->size()}, crc);
            },
            [read, &net = place().net](std::string fault) {
                read->fault = std::move(fault);
                read->is_done = true;
                net.wake(net.now());
            });
    }
    std::string message() const override { return words_; }

private:
    struct Read {
        bool is_done = false;
        std::string fault;
        ano::host::FirmwareFile file;
    };

    void look(TimePoint now) override {
        if (firmware_ != nullptr) return say(now);
        if (end() || !read_->is_done) return;
        if (!read_->fault.empty()) return finish(work_fault(503, "the file could not be checked: " + read_->fault));
        if (!read_->file.image) return finish(work_fault(422, read_->file.wrong));
        size_ = read_->file.image->bytes.size();
        const std::size_t room = place().net.manners(place().device.address()).max_data;
        frame_len_ = std::min(usual_frame, room > 3 ? room - 3 : usual_frame);
        began_ = now;
        auto task = std::make_unique<Firmware>(place().device, std::move(*read_->file.image),
                                               ano::host::FirmwareOptions{order_.force, frame_len_, order_.known_as});
        firmware_ = task.get();
        next(std::move(task)).start(now);
    }
    // The speed once a second.
    void say(TimePoint now) {
        if (end() || (firmware_->step() == step_ && now - said_at_ < std::chrono::seconds{1})) return;
        said_at_ = now;
        step_ = words_ = firmware_->step();
        const double speed = firmware_->bytes_a_second(now);
        if (speed > 0) words_ += ", " + speed_in_words(speed, firmware_->time_left(now));
    }
    void done(const Task& task, TimePoint now) override {
        WorkEnd end = end_of(*task.end());
        const double seconds = std::chrono::duration<double>(now - began_).count();
        end.result = Json{{"bytes", size_},
                          {"frames", (size_ + frame_len_ - 1) / frame_len_},
                          {"repeats", firmware_->repeats()},
                          {"seconds", std::round(seconds * 10) / 10}}
                         .dump();
        finish(std::move(end));
    }

    UpgradeOrder order_;
    std::shared_ptr<Read> read_ = std::make_shared<Read>();
    Firmware* firmware_ = nullptr;
    std::size_t size_ = 0, frame_len_ = usual_frame;
    TimePoint began_{}, said_at_{};
    std::string step_, words_ = "checking the file";
};

}    // namespace

std::unique_ptr<Work> upgrade(const WorkPlace& place, UpgradeOrder order) {
    return std::make_unique<Upgrade>(place, std::move(order));
}

}    // namespace anogate
