#include <devices/device_json.hpp>
#include <devices/works/firmware_work.hpp>
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

constexpr std::chrono::seconds reported_silence{3};    // silence that is reported

constexpr std::size_t usual_frame = 195;    // bytes of the image in a frame; DATA has three more

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

    // Checks the file outside the loop, because it may be large; and only if the frames fit the link.
    void start(TimePoint) override {
        const std::size_t room = place().net.device_limits(place().device.address()).max_data;
        frame_len_ = std::min(usual_frame, room > 3 ? room - 3 : usual_frame);
        if (order_.file.size() > Firmware::max_frames * frame_len_ + ano::host::FirmwareImage::header_bytes)
            return finish(work_fault({"image_too_long", frame_len_}));
        const auto read = read_;
        place().net.aside(
            [read, file = std::move(order_.file), crc = order_.crc] {
                read->file = ano::host::read_firmware(file, crc);
                if (read->file.image) read->doubt = ano::host::looks_unlike_firmware(file);
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
        std::string doubt;    // why it is probably not firmware
        ano::host::FirmwareFile file;
    };

    void look(TimePoint now) override {
        if (firmware_ != nullptr) {
            if (firmware_->is_left_in_loader() && !std::exchange(is_noted_, true)) note();
            return report(now);
        }
        if (end() || !read_->is_done) return;
        if (!read_->fault.empty()) return finish(work_fault({"file_unchecked", read_->fault}));
        if (!read_->file.image) return finish(work_fault(read_->file.wrong));
        if (!read_->doubt.empty() && !order_.force) return finish(work_fault({"not_firmware", read_->doubt}));
        size_ = read_->file.image->bytes.size();
        began_ = now;
        recall();
        auto task = std::make_unique<Firmware>(place().device, std::move(*read_->file.image),
                                               ano::host::FirmwareOptions{order_.force, frame_len_, order_.known_as});
        firmware_ = task.get();
        next(std::move(task)).start(now);
    }
    // A device in its loader may not report its identity: it is then read from the note.
    void recall() {
        if (!order_.known_as) order_.known_as = kept_identity(place());
    }
    // Stores the identity while the device still answers.
    void note() { keep_loader_note(place(), place().device.info() ? place().device.info() : order_.known_as); }
    // Updates the message once a second, and at once after an odd reply.
    void report(TimePoint now) {
        const bool is_news = firmware_->step() != step_ || firmware_->odd_reply() != odd_reply_;
        if (end() || (!is_news && now - reported_at_ < std::chrono::seconds{1})) return;
        reported_at_ = now;
        step_ = words_ = firmware_->step();
        const double speed = firmware_->bytes_a_second(now);
        const auto silent = std::chrono::floor<std::chrono::seconds>(firmware_->silent_for(now));
        if (silent >= reported_silence) words_ += ", no answer for " + std::to_string(silent.count()) + " s";
        else if (speed > 0) words_ += ", " + speed_in_words(speed, firmware_->time_left(now));
        odd_reply_ = firmware_->odd_reply();
        if (!odd_reply_.empty()) words_ += "; " + odd_reply_;
        if (!firmware_->remark().empty()) words_ += "; " + firmware_->remark().text();
    }
    void done(const Task& task, TimePoint now) override {
        const std::uint8_t address = place().device.address();
        forget_loader_notes(place().journal, address, place().net.unit_place(address, now));
        WorkEnd end = end_of(*task.end(), texts());
        const double seconds = std::chrono::duration<double>(now - began_).count();
        Json result{{"bytes", size_},
                    {"frames", (size_ + firmware_->frame_len() - 1) / firmware_->frame_len()},
                    {"repeats", firmware_->repeats()},
                    {"seconds", std::round(seconds * 10) / 10}};
        if (!end.fault.empty()) result["note"] = end.fault.text();
        end.result = result.dump();
        finish(std::move(end));
    }

    UpgradeOrder order_;
    std::shared_ptr<Read> read_ = std::make_shared<Read>();
    Firmware* firmware_ = nullptr;
    std::size_t size_ = 0, frame_len_ = usual_frame;
    bool is_noted_ = false;
    TimePoint began_{}, reported_at_{};
    std::string step_, odd_reply_, words_ = "checking the file";
};

}    // namespace

std::unique_ptr<Work> upgrade(const WorkPlace& place, UpgradeOrder order) {
    return std::make_unique<Upgrade>(place, std::move(order));
}

}    // namespace anogate
