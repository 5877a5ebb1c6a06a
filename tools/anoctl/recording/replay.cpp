// anoctl replay FILE LINK: sends the frames of a recording on a link, at their original intervals.
#include <anoctl/anoctl.hpp>
#include <anoctl/counted.hpp>
#include <anoctl/own_link.hpp>
#include <anoctl/say.hpp>
#include "recording_input.hpp"

#include <ano/time.hpp>
#include <ano_json/escapes.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/text.hpp>
#include <record/replay.hpp>
#include <sys/asio.hpp>

#include <nlohmann/json.hpp>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

namespace asio = anogate::asio;
using ano::Clock;
using anogate::RecordedFrame;

constexpr auto look_again = std::chrono::milliseconds{
    10};    // polling interval for changes without an event: the link is up, the queue is empty
constexpr auto look_soon = std::chrono::milliseconds{1};        // polling interval of the queue, so that the link stays busy
constexpr auto patience_with_link = std::chrono::seconds{5};    // for a link that sends nothing
constexpr auto time_to_leave = std::chrono::seconds{2};         // to send the last frames
constexpr int max_at_once = 64;                                 // frames per turn; then the loop serves the link

class Replayer final : public FrameReceiver {
public:
    Replayer(RecordingInput& input, const anogate::LinkSettings& settings, bool commands, double rate, Streams& streams)
        : input_{input},
          streams_{streams},
          commands_{commands},
          at_once_{rate == 0},
          clock_{rate},
          link_{io_, settings, *this, streams, "replay"} {}

    void run() {
        asio::signal_set signals{io_, SIGINT, SIGTERM};
        signals.async_wait([this](anogate::error_code ec, int) {
            if (ec) return;
            was_interrupted = true;
            end();
        });
        link_.start();
        await_link();
        io_.run();
    }

    // Frames received on the link are ignored.
    bool accept(ano::FrameView, const Passage&) override { return true; }
    bool flush() override { return true; }
    void miss(std::uint64_t, const std::string&, std::string_view) override {}

    std::uint64_t given = 0, kept_back = 0, not_sent = 0;
    bool was_interrupted = false, has_frames = false;

private:
    template <class Then>
    void at(ano::TimePoint time, Then then) {
        timer_.expires_at(time);
        timer_.async_wait([then](anogate::error_code ec) {
            if (!ec) then();
        });
    }

    void await_link() {
        if (!link_.is_up()) return at(Clock::now() + look_again, [this] { await_link(); });
        began_ = Clock::now();
        step();
    }

    // Reports the first fault of the link: for example that nothing listens there.
    void look_for_trouble() {
        if (has_reported_) return;
        const std::string trouble = link_.trouble();
        if (trouble.empty()) return;
        has_reported_ = true;
        print_note(streams_, link_.name() + ": " + trouble);
    }

    void step() {
        look_for_trouble();
        for (int i = 0; i < max_at_once; ++i) {
            if (!next_ && !(next_ = next_wanted()))
                return at(Clock::now() + look_again, [this] { end_when_empty(Clock::now() + time_to_leave); });
            if (!due_) due_ = began_ + clock_.due(*next_);
            if (*due_ > Clock::now()) return at(*due_, [this] { step(); });
            if (at_once_ && must_wait()) return at(Clock::now() + look_soon, [this] { step(); });
            ++given;
            link_.send(next_->frame);
            next_.reset();
            due_.reset();
        }
        asio::post(io_, [this] { step(); });
    }

    // Whether to wait for the link (only with rate 0), so that queued frames are neither stale nor superseded.
    bool must_wait() {
        const auto now = Clock::now();
        if (link_.waiting() == 0) waits_since_.reset();
        else if (!waits_since_) waits_since_ = now;
        return waits_since_ && now - *waits_since_ < patience_with_link;
    }

    std::optional<RecordedFrame> next_wanted() {
        while (const auto item = input_.next()) {
            const auto* frame = std::get_if<RecordedFrame>(&*item);
            has_frames = has_frames || frame != nullptr;
            if (frame == nullptr || frame->direction != anogate::Direction::in) continue;
            if (commands_ || !anogate::may_command(frame->frame)) return *frame;
            ++kept_back;
        }
        return std::nullopt;
    }

    void end_when_empty(ano::TimePoint latest) {
        if (link_.waiting() == 0 || Clock::now() >= latest) return end();
        at(Clock::now() + look_again, [this, latest] { end_when_empty(latest); });
    }

    void end() {
        look_for_trouble();
        not_sent = link_.waiting() + link_.dropped_frames();
        link_.stop();
        io_.stop();
    }

    RecordingInput& input_;
    Streams& streams_;
    const bool commands_;
    const bool at_once_;
    anogate::ReplayClock clock_;
    asio::io_context io_{1};
    asio::steady_timer timer_{io_};
    OwnLink link_;
    ano::TimePoint began_{};
    std::optional<RecordedFrame> next_;    // valid until the next one is read
    std::optional<ano::TimePoint> due_;
    std::optional<ano::TimePoint> waits_since_;    // since when the queue of the link is not empty
    bool has_reported_ = false;                    // the fault of the link was reported
};

struct Replay {
    std::string file, link;
    bool commands = false, json = false;
    double rate = 1;

    int run(Streams& streams) const {
        const anogate::LinkSettings settings = link_settings_of(link);
        RecordingInput input{file, streams};
        Replayer replayer{input, settings, commands, rate, streams};
        replayer.run();
        const RecordingFacts facts = input.facts();
        if (!replayer.was_interrupted)
            for (const std::string& note : facts.notes()) print_note(streams, file + ": " + note);
        if (json) {
            streams.out << ano::json_text(ano::Json{
                               {"frames", replayer.given}, {"not_sent", replayer.not_sent}, {"kept_back", replayer.kept_back}})
                        << '\n';
        } else {
            std::string text = counted(replayer.given, "frame") + " replayed";
            if (replayer.given + replayer.kept_back == 0 && !replayer.was_interrupted)
                text += replayer.has_frames ? ": the recording has no received frames" : ": the recording has no frames";
            if (replayer.not_sent > 0)
                text += ", of which " + std::to_string(replayer.not_sent) + " were not sent: the link was down or too slow";
            if (replayer.kept_back > 0)
                text += "; " + std::to_string(replayer.kept_back) +
                        " from hosts or commanding a vehicle omitted; use --commands to include them";
            print_note(streams, text);
        }
        if (replayer.was_interrupted) return interrupted;
        return !facts.is_damaged() && replayer.not_sent == 0 ? fine : failed;
    }
};

}    // namespace

Run add_replay(Options& options) {
    const auto self = std::make_shared<Replay>();
    const auto read_rate = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        self->rate = number ? std::visit([](auto n) { return static_cast<double>(n); }, *number) : -1;
        const bool is_rate = self->rate == 0 || (self->rate >= 0.001 && self->rate <= 1000);
        return is_rate ? "" : ano::in_quotes(word) + " is neither 0 nor a number from 0.001 to 1000";
    };
    options.push_back({"file", &self->file, "FILE", "Recording; only its received frames are replayed", true});
    options.push_back({"link", &self->link, "LINK",
                       "Link to send on, as for anogated: serial:/dev/ttyUSB0,baud=500000 udp:127.0.0.1:12333 pty:PATH", true});
    options.push_back(
        {"--commands", &self->commands, "",
         "Include frames sent by hosts and frames that command or change a vehicle; the vehicle on this link will execute them"});
    options.push_back({"--rate", Option::Read{read_rate}, "R", "Speed factor; 0: as fast as the link allows (default: 1)"});
    options.push_back({"--json", &self->json, "", "Print the summary as one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
