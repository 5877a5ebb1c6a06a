// Translates between V8 and a device that speaks the older protocol V7 (ano/v7.hpp), at the edge of a link: everything behind it
// sees V8 alone. Sources: note "protocol-v7", sections 4 to 6 and 8.
//
// Flow:    translation.receive(v7_frame, now)    // from the device; the V8 frames: to_hosts()
//          translation.send(v8_frame, now)       // to the device; the V7 frames: to_device(), answers of the gateway: to_hosts()
//          at deadline(): translation.repeat(now)
#pragma once
#include <ano/address.hpp>
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <ano/v7.hpp>

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace anogate {

/// A parameter of a V7 device: it states its number alone.
struct V7Parameter {
    std::uint16_t number = 0;
    std::string_view name;      // at most 20 bytes
    std::uint32_t scale = 1;    // the number on the wire is the value × scale
    bool is_real = false;       // hosts get f32 and the value itself: calibration, which V8 hosts compute with
};

/// What the acceleration of 0x01 is in.
struct V7Acceleration {
    enum class Unit : std::uint8_t {
        keep,     // unknown: the numbers pass as they are
        per_g,    // `per_g` is 1 g
        cmss,     // cm/s², with a gyroscope in whole °/s
    };
    Unit unit = Unit::keep;
    double per_g = 0;
    friend bool operator==(const V7Acceleration&, const V7Acceleration&) = default;
};
inline constexpr V7Acceleration v7_acceleration_of_lx{V7Acceleration::Unit::per_g, 32768.0 / 24};    // ±24 g
inline constexpr V7Acceleration v7_acceleration_of_flow{V7Acceleration::Unit::per_g, 2048};

/// What direction and angle of 0x34 mean (section 8).
enum class V7Range : std::uint8_t { lx, doc, flow };

struct V7Settings {
    std::uint8_t address = 0xDD;                  // V8 id of the device
    std::array<std::uint8_t, 256> sources{};      // V8 id for a V7 message id; 0: `address`
    std::optional<std::uint8_t> destination{};    // D of frames to the device; std::nullopt: by message and device
    std::uint8_t port = 0;                        // port id of the link: frames to it go to `address`; 0: none
    V7Acceleration acceleration{};
    std::uint8_t temperature = 100;    // of 0x02: 10 or 100 per °C
    V7Range range = V7Range::lx;
    bool keeps_layout = false;                    // 0x02, 0x05, 0x08 and 0x34 from the device keep the layout of V7
    std::bitset<256> down{};                      // V8 ids that may go to the device
    bool acknowledges_sent = false;               // the gateway acknowledges what it has sent; the device does not
    bool repeats = true;                          // questions without an answer are repeated
    std::size_t max_data = 44;                    // largest DATA to the device: 1 to 255
    std::span<const V7Parameter> parameters{};    // must stay valid; empty: parameters by number alone
};

/// The defaults for the device with this V8 id.
V7Settings v7_settings_for(std::uint8_t address) noexcept;
/// Parameters of the LX IMU, and of the 拓空者 flight controller (section 6).
std::span<const V7Parameter> v7_parameters_of_lx() noexcept;
std::span<const V7Parameter> v7_parameters_of_tkz() noexcept;

/// Messages that a V7 device would take for those of its own sensors, since it sees no source: they are never sent to it.
constexpr bool v7_is_own_sensor(std::uint8_t id) noexcept { return (id >= 0x01 && id <= 0x0F) || id == 0x20 || id == 0x21; }

/// Frames that were not passed on, by cause, and questions that were repeated.
struct V7Counters {
    std::uint64_t translated_up{}, translated_down{};
    std::uint64_t up_malformed{};            // DATA of a length that the message does not have
    std::uint64_t up_no_counterpart{};       // V8 has no such message, or means another by its id
    std::uint64_t up_no_address{};           // to an address without a counterpart
    std::uint64_t up_no_distance{};          // 0x34 without a distance, or in a direction that V8 can't state
    std::uint64_t up_unknown_parameter{};    // 0xE2 with a number that the table does not list
    std::uint64_t up_unmatched_check{};      // acknowledges nothing that was sent within v7_memory
    std::uint64_t down_not_ours{};           // to another device
    std::uint64_t down_not_allowed{};        // not in v7_down
    std::uint64_t down_no_counterpart{};     // V7 can't say it
    std::uint64_t down_malformed{};          // DATA of a length or value that the message does not have
    std::uint64_t down_too_long{};           // DATA above v7_max
    std::uint64_t down_refused{};            // would erase the firmware
    std::uint64_t down_busy{};               // too many questions wait
    std::uint64_t down_asked_already{};      // the same host waits for the same answer already
    std::uint64_t down_not_answered{};       // questions for the gateway about a device that was not heard
    std::uint64_t repeated{};                // questions sent again
    std::uint64_t unanswered{};              // questions given up
};

struct V7CounterRow {
    std::string_view name;
    std::uint64_t V7Counters::*value;
    std::string_view help;
};
inline constexpr V7CounterRow v7_counters[] = {
    {"v7_up_malformed", &V7Counters::up_malformed, "V7 frames with DATA of a wrong length"},
    {"v7_up_no_counterpart", &V7Counters::up_no_counterpart, "V7 frames that V8 has no message for"},
    {"v7_up_no_address", &V7Counters::up_no_address, "V7 frames to an address that V8 does not have"},
    {"v7_up_no_distance", &V7Counters::up_no_distance,
     "V7 distances that are not valid, or in a direction that V8 does not have"},
    {"v7_up_unknown_parameter", &V7Counters::up_unknown_parameter, "V7 parameters that the table does not list"},
    {"v7_up_unmatched_check", &V7Counters::up_unmatched_check, "V7 acknowledgements of nothing that was sent"},
    {"v7_down_not_ours", &V7Counters::down_not_ours, "not sent, addressed to another device"},
    {"v7_down_not_allowed", &V7Counters::down_not_allowed, "not sent, the message is not in v7_down"},
    {"v7_down_no_counterpart", &V7Counters::down_no_counterpart, "not sent, V7 has no such message"},
    {"v7_down_malformed", &V7Counters::down_malformed, "not sent, the DATA have a wrong length or value"},
    {"v7_down_too_long", &V7Counters::down_too_long, "not sent, more DATA than v7_max"},
    {"v7_down_refused", &V7Counters::down_refused, "not sent, the command would erase the firmware"},
    {"v7_down_busy", &V7Counters::down_busy, "not sent, too many questions wait"},
    {"v7_down_asked_already", &V7Counters::down_asked_already, "not sent, the same question waits already"},
    {"v7_down_not_answered", &V7Counters::down_not_answered,
     "questions that the gateway did not answer, the device was not heard"},
    {"v7_repeated", &V7Counters::repeated, "questions repeated"},
    {"v7_unanswered", &V7Counters::unanswered, "questions given up"},
};

/// The translation of one channel, with its state. Laws: nothing is sent that the device takes for its own sensor's
/// (v7_is_own_sensor()) or that erases its firmware; a command or write is sent exactly as often as the host sent it, and never
/// waits; of the questions for values, one is under way, and at most `max_waiting` wait. The gateway answers questions that V7
/// does not have (device info, descriptions) while the device was heard within `heard_within`.
///
/// Allocates at construction, and only if the output is not fetched (clear_...) later too.
class V7Translation {
public:
    static constexpr ano::Duration memory = std::chrono::milliseconds{1000};    // of frames that may be acknowledged
    static constexpr ano::Duration repeat_after = std::chrono::milliseconds{200};
    static constexpr int sends = 3;    // of a question, in all
    static constexpr std::size_t max_waiting = 16;
    static constexpr ano::Duration alt_bar_age = std::chrono::seconds{1};
    static constexpr ano::Duration heard_within = std::chrono::seconds{5};

    explicit V7Translation(const V7Settings& settings);

    /// A frame from the device.
    void receive(ano::v7::FrameView frame, ano::TimePoint now);
    /// A frame to the device.
    void send(ano::FrameView frame, ano::TimePoint now);
    /// Repeats the question that is under way, or gives it up and sends the next one.
    void repeat(ano::TimePoint now);
    /// When repeat() has something to do; std::nullopt while no question is under way.
    std::optional<ano::TimePoint> deadline() const noexcept;
    /// The connection is gone: nothing that was sent will be answered.
    void forget() noexcept;

    /// Whole V7 frames for the device, in order; valid until the next call of another member.
    std::span<const std::uint8_t> to_device() const noexcept { return to_device_; }
    void clear_to_device() noexcept { to_device_.clear(); }
    /// Whole V8 frames from the device, in order; valid until the next call of another member.
    std::span<const std::uint8_t> to_hosts() const noexcept { return to_hosts_; }
    void clear_to_hosts() noexcept { to_hosts_.clear(); }

    const V7Settings& settings() const noexcept { return settings_; }
    const V7Counters& counters() const noexcept { return counters_; }

private:
    using Data = std::span<const std::uint8_t>;
    using Cause = std::uint64_t V7Counters::*;

    /// A frame that was sent on in the other protocol, and may be acknowledged.
    struct Sent {
        ano::TimePoint at{};
        std::uint8_t id = 0;    // as it was sent on
        ano::Checks checks{};
        std::uint8_t original_id = 0;
        ano::Checks original_checks{};
        std::uint8_t requester = 0;
        std::uint8_t asked = 0;
    };
    /// The newest of them; equal ones are found in the order in which they were sent.
    class SentFrames {
    public:
        void put(const Sent& sent) noexcept;
        std::optional<Sent> take(std::uint8_t id, ano::Checks checks, ano::TimePoint now) noexcept;
        void clear() noexcept { all_ = {}; }

    private:
        std::array<Sent, 64> all_{};    // a free one has id 0, which nothing acknowledges
        std::size_t next_ = 0;
    };
    struct Question {
        std::uint8_t id = 0;         // of V7: 0xE1 or 0x60
        std::uint16_t number = 0;    // of the parameter; of 0x60 the waypoint
        std::uint16_t index = 0;     // of the parameter, as the host asked
        std::uint8_t requester = 0;
        std::uint8_t asked = 0;
        friend bool operator==(const Question&, const Question&) = default;
    };

    std::optional<ano::FrameView> up(ano::v7::FrameView frame, std::uint8_t id, Data data);
    void up_inertial(ano::v7::FrameView frame);
    void up_compass(ano::v7::FrameView frame, ano::TimePoint now);
    void up_altitude(ano::v7::FrameView frame, ano::TimePoint now);
    void up_position(ano::v7::FrameView frame);
    void up_place(ano::v7::FrameView frame);
    void up_ranging(ano::v7::FrameView frame);
    void up_log_value(ano::v7::FrameView frame);
    void up_command(ano::v7::FrameView frame, ano::TimePoint now);
    void up_parameter(ano::v7::FrameView frame, ano::TimePoint now);
    void up_waypoint(ano::v7::FrameView frame, ano::TimePoint now);
    void up_check(ano::v7::FrameView frame, ano::TimePoint now);

    bool is_ours(std::uint8_t destination) const noexcept;
    std::uint8_t asked_by(std::uint8_t destination) const noexcept;
    /// Sends a V7 frame; false: its DATA are too long. `acknowledged`: as the answer to `original`.
    bool down(ano::FrameView original, std::uint8_t id, Data data, ano::TimePoint now, bool acknowledged = false);
    void down_command(ano::FrameView original, Data command, ano::TimePoint now);
    void down_place(ano::FrameView frame, ano::TimePoint now);
    void down_ranging(ano::FrameView frame, ano::TimePoint now);
    void down_scan(ano::FrameView frame, ano::TimePoint now);
    void down_log_value(ano::FrameView frame, ano::TimePoint now);
    void down_check(ano::FrameView frame, ano::TimePoint now);
    void down_command_query(ano::FrameView frame, ano::TimePoint now);
    void down_parameter_command(ano::FrameView frame, ano::TimePoint now);
    void down_parameter_action(ano::FrameView frame, ano::TimePoint now);
    void down_parameter_write(ano::FrameView frame, ano::TimePoint now);
    void answer(ano::FrameView question, std::uint8_t id, Data data, ano::TimePoint now);
    void acknowledge(ano::FrameView frame);
    void answer_info(ano::FrameView question, ano::TimePoint now);
    void answer_description(ano::FrameView question, std::uint16_t index, ano::TimePoint now);

    void ask(const Question& question, ano::TimePoint now);
    void send_question(ano::TimePoint now);
    std::optional<Question> answered(std::uint8_t id, std::uint16_t number, ano::TimePoint now);
    void put_to_device(std::uint8_t destination, std::uint8_t id, Data data);
    ano::FrameView put_to_hosts(std::uint8_t source, std::uint8_t destination, std::uint8_t id, Data data);
    std::uint8_t destination_of(std::uint8_t id, std::uint8_t asked) const noexcept;
    const V7Parameter* parameter(std::uint16_t index) const noexcept;
    std::optional<std::uint16_t> index_of(std::uint16_t number) const noexcept;
    void count(Cause cause) noexcept { ++(counters_.*cause); }

    V7Settings settings_;
    std::bitset<256> ids_;    // V8 ids of the devices behind the link
    std::vector<std::uint8_t> to_device_, to_hosts_;
    SentFrames sent_down_, sent_up_;

    std::array<Question, max_waiting + 1> questions_{};    // the first one is under way
    std::size_t question_count_ = 0;
    int question_sends_ = 0;
    ano::TimePoint question_at_{};

    std::optional<ano::TimePoint> heard_at_;
    std::optional<std::int32_t> alt_bar_, alt_fu_;
    ano::TimePoint alt_bar_at_{};
    std::array<std::uint16_t, 3> versions_{};    // of hardware, software and boot loader, as far as heard
    V7Counters counters_;
};

}    // namespace anogate
