#include <record/mcap/mcap_repair.hpp>
#include <record/pcapng_reader.hpp>
#include <record/pcapng_writer.hpp>
#include <record/recording_repair.hpp>

#include <variant>

namespace anogate {
namespace {

// The end mark contains the number of frames of each link, so a writer that gets the same frames produces it.
class PcapngReading final : public RecordingRepair::Reading {
public:
    void feed(std::string_view bytes) override {
        reader_.feed(bytes);
        while (const auto item = reader_.next()) {
            if (!writer_) writer_ = std::make_unique<PcapngWriter>(reader_.head(), written_);
            if (const auto* frame = std::get_if<RecordedFrame>(&*item)) {
                writer_->write(*frame, written_);
                ++frames_;
            } else {
                writer_->write(std::get<RecordedLoss>(*item));
            }
            written_.clear();
        }
    }
    RecordingRepair::Result finish() override {
        RecordingRepair::Result result;
        result.keep = reader_.good_end();
        result.frames = frames_;
        result.is_recording = reader_.good_end() > 0;
        result.is_whole = reader_.has_end() && reader_.unfinished() == 0 && !reader_.is_damaged();
        if (!result.is_recording || reader_.has_end()) return result;
        if (ending_of_ != result.keep) {
            ending_.clear();
            std::string head;
            PcapngWriter writer = writer_ ? *writer_ : PcapngWriter{reader_.head(), head};
            writer.end(ending_);
            ending_of_ = result.keep;
        }
        result.append = ending_;
        return result;
    }

private:
    PcapngReader reader_;
    std::unique_ptr<PcapngWriter> writer_;
    std::string written_;
    std::uint64_t frames_ = 0;
    std::string ending_;    // the end of a file of ending_of_ bytes
    std::uint64_t ending_of_ = 0;
};

}    // namespace

RecordingRepair::RecordingRepair(RecordingFormat format) {
    if (format == RecordingFormat::mcap) reading_ = std::make_unique<McapRepair>();
    else reading_ = std::make_unique<PcapngReading>();
}
RecordingRepair::~RecordingRepair() = default;
void RecordingRepair::feed(std::string_view bytes) { reading_->feed(bytes); }
RecordingRepair::Result RecordingRepair::finish() { return reading_->finish(); }

}    // namespace anogate
