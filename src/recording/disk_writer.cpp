#include <recording/disk_writer.hpp>
#include <sys/error_fault.hpp>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <new>
#include <string_view>
#include <utility>

namespace anogate {
namespace {

std::string room_text(std::uint64_t bytes) {
    char text[32];
    std::snprintf(text, sizeof text, "%.1f MB", static_cast<double>(bytes) / 1e6);
    return text;
}

// With these errors, another file may work.
bool is_of_the_file(int error) noexcept {
    return error == EIO || error == EFBIG || error == ESTALE || error == ENODEV || error == ENXIO || error == EBADF;
}

}    // namespace

std::uint64_t RecorderItem::frames() const noexcept { return batch ? count_of_records(*batch) : 0; }

// The item is stored first: its bytes can be encoded again.
void DiskWriter::add(RecorderItem item) {
    try {
        unsafe_.push_back(std::move(item));
    } catch (const std::bad_alloc&) {
        progress_.in_flight -= item.bytes();
        progress_.not_written += item.frames();
        throw;
    }
    encode(unsafe_.back());
}

void DiskWriter::encode(const RecorderItem& item) {
    if (item.names) {
        const DecodingPtr before = std::exchange(names_, item.names)->decoding;
        if (!decode_alike(names_->decoding, before)) writer_->use(names_->decoding, waiting_);
    }
    if (item.lost) writer_->write(RecordedLoss{item.lost->count, loss_names(*item.lost)});
    if (!item.batch) return;
    std::string_view rest = *item.batch;
    while (const auto record = next_record(rest)) {
        writer_->write(as_recorded(*record, *names_), waiting_);
        ++waiting_frames_;
    }
}

void DiskWriter::turn(ano::TimePoint now) {
    if (!fault_.empty() && now < try_again_at_) return;
    fault_ = work(now);
    if (!fault_.empty() && !file_) fault_ = work(now);    // the file was given up: the next one may work
    if (!fault_.empty()) try_again_at_ = now + try_again_after;
    report();
}

void DiskWriter::finish(ano::TimePoint now) {
    is_finishing_ = true;
    hurry();
    turn(now);
    if (!fault_.empty()) abandon();
}

// The RecordingWriter may have stopped in the middle of a record: its file is cut to the synced part, and the rest goes into the next one.
void DiskWriter::lacks_memory(ano::TimePoint now) noexcept {
    if (file_) leave_file();
    fault_ = {"out_of_memory"};    // without arguments, so that it needs no allocation
    try_again_at_ = now + try_again_after;
    if (is_finishing_) abandon();
    report();
}

void DiskWriter::abandon() noexcept {
    std::uint64_t abandoned = waiting_frames_;
    if (!file_)
        for (const RecorderItem& item : unsafe_) abandoned += item.frames();
    progress_.not_written += abandoned;
}

// Returns empty, or a clause with the reason of the failure.
ano::Fault DiskWriter::work(ano::TimePoint now) {
    if (file_ && now >= look_for_file_at_) {
        look_for_file_at_ = now + look_time;
        if (!file_->is_there()) leave_file();
    }
    if (ano::Fault fault = file_ ? ano::Fault{} : begin(now); !fault.empty()) return fault;
    const FileSoFar so_far{file_->size() + waiting_.size(), safe_frames_ + written_frames_ + waiting_frames_ - frames_before_,
                           now - began_};
    if (!is_ending_) {
        writer_->flush(waiting_);
        if (is_finishing_ || is_time_for_the_next({settings_.rotate_bytes, settings_.rotate_time}, so_far)) {
            writer_->end(waiting_);
            is_ending_ = true;
        } else if (ano::Fault fault = look_for_room(now); !fault.empty()) {
            return fault;
        }
    }
    if (ano::Fault fault = write(now); !fault.empty() || !is_ending_) return fault;
    bytes_before_ += file_->size();
    writer_.reset();
    file_.reset();
    is_ending_ = false;
    return is_finishing_ ? ano::Fault{} : begin(now);
}

ano::Fault DiskWriter::begin(ano::TimePoint now) {
    look_for_room_at_ = now;
    if (ano::Fault fault = look_for_room(now); !fault.empty()) return fault;
    auto made = RecordingFile::create(settings_.folder, settings_.name, settings_.format, number_);
    progress_.is_busy();
    if (const auto* fault = std::get_if<DiskFault>(&made)) return fault->fault;
    file_.emplace(std::get<RecordingFile>(std::move(made)));
    its_number_ = number_++;
    ++files_;
    path_ = file_->path();
    began_ = safe_at_ = now;
    look_for_file_at_ = now + look_time;
    look_for_room_behind_ = room_between_looks;
    safe_size_ = 0;
    frames_before_ = safe_frames_;
    names_ = safe_names_;
    writer_ = make_recording_writer(settings_.format, recording_head(names_->decoding), waiting_, settings_.options);
    for (const RecorderItem& item : unsafe_) encode(item);
    writer_->flush(waiting_);
    return write(now);
}

static_assert(room_needed(1) > DiskWriter::room_between_looks + 4 * DiskWriter::much);

// The free space is checked every few MiB.
ano::Fault DiskWriter::look_for_room(ano::TimePoint now) {
    const std::uint64_t size = file_ ? file_->size() + waiting_.size() : 0;
    if (now < look_for_room_at_ && size < look_for_room_behind_) return {};
    look_for_room_at_ = now + look_time;
    look_for_room_behind_ = size + room_between_looks;
    if (settings_.keep_free == 0) return {};
    const std::uint64_t free = free_bytes(settings_.folder).value_or(UINT64_MAX);
    progress_.is_busy();
    const std::uint64_t needed = room_needed(settings_.keep_free);
    if (free >= needed) return {};
    look_for_room_at_ = now;
    return {"too_little_room", settings_.folder, room_text(free), room_text(needed), room_text(settings_.keep_free)};
}

ano::Fault DiskWriter::write(ano::TimePoint now) {
    progress_.is_busy();
    if (!waiting_.empty()) {
        if (const int error = file_->append(waiting_); error != 0) return failed(error);
        waiting_.clear();
        written_frames_ += std::exchange(waiting_frames_, 0);
        progress_.is_busy();
    }
    if (file_->size() == safe_size_ || (!is_ending_ && now - safe_at_ < sync_time && safe_size_ > 0)) return {};
    if (const int error = file_->sync(); error != 0) {
        ano::Fault fault = failed(error);
        if (file_) leave_file();    // the kernel marks pages as clean that it failed to write
        return fault;
    }
    progress_.is_busy();
    is_safe(now);
    return {};
}

ano::Fault DiskWriter::failed(int error) {
    ano::Fault fault = error_fault(path_, error);
    if (is_of_the_file(error)) leave_file();
    return fault;
}

void DiskWriter::is_safe(ano::TimePoint now) {
    safe_at_ = now;
    safe_size_ = file_->size();
    safe_frames_ += std::exchange(written_frames_, 0);
    safe_names_ = names_;
    std::size_t bytes = 0;
    for (const RecorderItem& item : unsafe_) bytes += item.bytes();
    unsafe_.clear();
    progress_.in_flight -= bytes;
}

void DiskWriter::leave_file() noexcept {
    if (safe_size_ > 0) {
        file_->cut(safe_size_);
        bytes_before_ += safe_size_;
    } else if (file_->is_there()) {
        file_->remove();
        number_ = its_number_;
        --files_;
    }
    writer_.reset();
    file_.reset();
    is_ending_ = false;
    waiting_.clear();
    waiting_frames_ = written_frames_ = 0;
}

// After a file was given up, its unsynced items are written again but are counted already, so progress_.frames does not decrease.
// At the end it may decrease, because these items may be given up.
void DiskWriter::report() {
    const std::uint64_t frames = safe_frames_ + written_frames_;
    if (is_finishing_ || frames > progress_.frames) progress_.frames = frames;
    progress_.bytes = bytes_before_ + (file_ ? file_->size() : 0);
    progress_.file_frames = file_ ? safe_frames_ + written_frames_ - frames_before_ : 0;
    progress_.file_bytes = file_ ? file_->size() : 0;
    progress_.files = files_;
}

}    // namespace anogate
