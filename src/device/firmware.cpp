#include <device/firmware.hpp>

#include <algorithm>
#include <utility>

namespace ano::device {
namespace {

using namespace firmware_code;

constexpr std::size_t max_frames = std::size_t{UINT16_MAX} + 1;    // frame_num is u16

ImageInfo info_of(const View<"firmware", "info">& view) noexcept {
    return {.size = view.get<"bin_len">(),
            .frame_size = view.get<"frame_len">(),
            .crc = view.get<"bin_crc">(),
            .version = view.get<"bin_ver">(),
            .hw_type = view.get<"hw_type">(),
            .hw_ver_min = view.get<"hw_ver_min">(),
            .hw_ver_max = view.get<"hw_ver_max">(),
            .cmd = view.get<"cmd">()};
}

}    // namespace

bool Firmware::is_ours(const ImageInfo& info) const {
    if (info.size == 0 || info.size > flash_.max_size || info.frame_size == 0) return false;
    if (info.frame_size > profile_.max_data - View<"firmware", "image">::message().fixed_size) return false;
    if ((info.size - 1u) / info.frame_size >= max_frames) return false;
    const std::uint8_t type = flash_.hw_type == 0 ? device_.id : flash_.hw_type;
    if (info.hw_type != 0 && info.hw_type != type) return false;
    const bool for_any = info.hw_ver_min == 0 && info.hw_ver_max == 0;
    if (!for_any && (device_.hw_ver < info.hw_ver_min || device_.hw_ver > info.hw_ver_max)) return false;
    return !flash_.accept || flash_.accept(info);
}

// A host that starts again replaces one that stopped. A refused image does not change the upgrade in progress.
Outcome Firmware::process(const View<"firmware", "info">& view, Reply& reply) {
    if (flash_.max_size == 0) return Outcome::unknown;
    if (due_) return Outcome::refused;
    const ImageInfo info = info_of(view);
    if (!is_ours(info)) return send_code(reply, info_refused);
    image_ = info;
    order_ = profile_.firmware_order;
    state_ = State::accepted;
    asker_ = reply.asker();
    return send_code(reply, info_accepted);
}

Outcome Firmware::process(const FirmwareCode& code, TimePoint now, Reply& reply) {
    if (flash_.max_size == 0) return Outcome::unknown;
    switch (code.code) {
    case firmware_code::erase: order_ = code.order; return erase(now, reply);
    case all_sent: return check(now, reply);
    default: return Outcome::unanswered;
    }
}

Outcome Firmware::erase(TimePoint now, Reply& reply) {
    if (due_) return Outcome::refused;
    const bool in_turn = state_ != State::idle && asker_ == reply.asker();
    if (!in_turn) return send_code(reply, erase_failed);
    state_ = State::erasing;
    if (flash_.erase_time <= Duration::zero()) return send_code(reply, end_erasing());
    due_ = now + flash_.erase_time;
    return Outcome::later;
}

std::uint16_t Firmware::end_erasing() {
    const bool done = !flash_.erase || flash_.erase();
    state_ = done ? State::receiving : State::accepted;
    bytes_.assign(done ? image_.size : 0, 0xFF);
    has_.assign(done ? frames() : 0, false);
    written_ = 0;
    return done ? erased : erase_failed;
}

Outcome Firmware::process(const View<"firmware", "image">& frame, Reply& reply) {
    if (flash_.max_size == 0) return Outcome::unknown;
    const std::uint16_t number = frame.get<"frame_num">();
    const bool in_turn = state_ == State::receiving && asker_ == reply.asker();
    const bool done = in_turn && store(number, frame.get<"data">());
    const auto send_frame_code = [&](auto answer) {
        const bool fits = answer.template set<"code">(done ? frame_written : frame_failed) &&
                          answer.template set<"frame_num">(number);
        return fits ? reply.send(answer) : Outcome::unknown;
    };
    if (order_ == ByteOrder::big) return send_frame_code(Draft<"firmware", "reading_written">{});
    return send_frame_code(Draft<"firmware", "written">{});
}

// A repeated frame is no error: the answer "written" was lost. A different frame with the same number is one, since flash is
// written once. The last frame has the length of the rest of the image, or is padded.
bool Firmware::store(std::size_t number, Bytes bytes) {
    if (number >= has_.size()) return false;
    if (profile_.frames_in_order && number > written_) return false;
    const std::size_t begin = number * image_.frame_size;
    const std::size_t size = std::min<std::size_t>(image_.frame_size, bytes_.size() - begin);
    if (bytes.size() < size || bytes.size() > image_.frame_size) return false;
    const Bytes part = bytes.first(size);
    const auto at = bytes_.begin() + static_cast<std::ptrdiff_t>(begin);
    if (has_[number]) return std::equal(part.begin(), part.end(), at);
    std::copy(part.begin(), part.end(), at);
    has_[number] = true;
    ++written_;
    return true;
}

Outcome Firmware::check(TimePoint now, Reply& reply) {
    if (due_) return Outcome::refused;
    if (asker_ != reply.asker()) return send_code(reply, check_failed);
    if (state_ == State::passed)
        return send_code(reply, check_passed);    // the answer was lost: the image is not installed twice
    if (state_ != State::receiving) return send_code(reply, check_failed);
    state_ = State::checking;
    if (flash_.check_time <= Duration::zero()) return send_code(reply, end_checking());
    due_ = now + flash_.check_time;
    return Outcome::later;
}

std::uint16_t Firmware::end_checking() {
    const bool whole = written_ == has_.size() && (!flash_.crc || crc16_of(bytes_, *flash_.crc) == image_.crc);
    const bool passed = whole && (!flash_.install || flash_.install({image_, bytes_}));
    state_ = passed ? State::passed : State::failed;
    bytes_ = {};
    has_ = {};
    return passed ? check_passed : check_failed;
}

std::optional<Firmware::Late> Firmware::run(TimePoint now) {
    if (!due_ || now < *due_) return std::nullopt;
    due_.reset();
    const std::uint16_t code = state_ == State::erasing ? end_erasing() : end_checking();
    return Late{*asker_, firmware_step(code, order_)};
}

}    // namespace ano::device
