#include <ano/address.hpp>
#include <ano/typed.hpp>
#include <devices/works/scan_work.hpp>
#include <host/parameter_info.hpp>

#include <bitset>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using ano::Duration;
using ano::TimePoint;

constexpr unsigned sends = 3;
constexpr Duration between_sends = std::chrono::milliseconds{300};
// After the last send. In total less than 1.5 s, plus the time of zero bytes.
constexpr Duration for_answers = std::chrono::milliseconds{800};

class Scan final : public Work {
public:
    explicit Scan(const WorkPlace& place) : place_{place} {}
    void start(TimePoint now) override { next_ = now; }
    void run(TimePoint now) override {
        if (end() || now < next_) return;
        if (sent_ == sends) return finish({});
        const ano::host::Request request = ano::host::question::device_info(0);
        std::vector<std::uint8_t> frame(ano::overhead + request.data.size());
        ano::encode(frame, place_.device.own(), ano::address::broadcast, request.id, request.data);
        const ano::FrameView question{frame};
        // A device whose parser is not ready for the first question does not answer it.
        const Duration busy = sent_ > 0 ? place_.net.flush_parser(question).busy : Duration{};
        ++sent_;
        next_ = now + busy + (sent_ < sends ? between_sends : for_answers);
        if (const Unsent unsent = place_.net.send(question); !unsent.why.empty() && !unsent.is_down)
            finish({403, {}, unsent.why, "refused"});
    }
    void cancel(TimePoint) override { finish({409, {}, {"cancelled"}, "refused", {}, true}); }
    void receive(ano::FrameView frame, TimePoint) override {
        if (frame.id() == ano::id_of<"device_info">) answered_.set(frame.source());
    }
    ano::host::Progress progress() const override { return {answered_.count(), 0}; }
    std::string message() const override { return "scanning, " + std::to_string(answered_.count()) + " answered"; }
    std::optional<TimePoint> due() const override { return next_; }

private:
    WorkPlace place_;
    unsigned sent_ = 0;
    TimePoint next_{};
    std::bitset<256> answered_;
};

}    // namespace

std::unique_ptr<Work> scan(const WorkPlace& place) { return std::make_unique<Scan>(place); }

}    // namespace anogate
