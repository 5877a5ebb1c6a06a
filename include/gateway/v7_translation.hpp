// Translates between V8 and the frames of one link whose devices use the previous protocol version, V7
// (include/ano/protocol-v7.md, section 8). The rest of the gateway sees V8 only.
//
// Flow:    translation.up(frame of the device, now, output);      // each frame received on the link
//          translation.down(frame to the device, now, output);    // each frame to be sent on the link
//          set a timer for translation.deadline(); when it is due: translation.expire(now, output)
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <ano/v7.hpp>
#include <gateway/v7_echo_watch.hpp>
#include <gateway/v7_nested_frames.hpp>

#include <array>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// The unit of the accelerometer in V7's 0x01.
struct V7Acceleration {
    enum class Unit : std::uint8_t {
        keep,     // unknown: the numbers stay
        per_g,    // `per_g` is 1 g
        cmss,     // cm/s², with whole °/s for the gyroscope
    };
    Unit unit = Unit::keep;
    double per_g = 0;    // above 0
    friend bool operator==(const V7Acceleration&, const V7Acceleration&) = default;
};
inline constexpr V7Acceleration v7_acc_lx{V7Acceleration::Unit::per_g, 1365.33};
inline constexpr V7Acceleration v7_acc_flow{V7Acceleration::Unit::per_g, 2048};
inline constexpr V7Acceleration v7_acc_cmss{V7Acceleration::Unit::cmss};

/// The meaning of direction and angle in V7's 0x34.
enum class V7Range : std::uint8_t { lx, doc, flow };
/// `v8`: 0x02, 0x05, 0x08 and 0x34 become those of V8.10. `keep`: they keep their DATA, which are variants of V8 as well.
enum class V7Layout : std::uint8_t { v8, keep };
/// `device`: only acknowledgements of the device pass. `sent`: the gateway acknowledges a request when it is sent, for devices
/// that never acknowledge.
enum class V7Ack : std::uint8_t { device, sent };

/// A parameter that hosts see under its place in the table.
struct V7Parameter {
    std::uint16_t number = 0;
    std::string name;           // at most 20 bytes are sent
    std::uint32_t scale = 1;    // value × scale is the number in the device; above 0
    bool as_f32 = false;        // hosts see value as f32; otherwise the number as i32
    bool operator==(const V7Parameter&) const = default;
};
std::vector<V7Parameter> v7_lx_parameters();
std::vector<V7Parameter> v7_tkz_parameters();
/// Reads a table of the user: one parameter a line, "NUMBER, NAME, SCALE, TYPE". SCALE is 1 and TYPE i32 if they are left out; TYPE
/// f32: hosts see the value divided by SCALE. Empty lines and lines that begin with # are skipped. Returns the error with its line,
/// or "" and the table in `rows`.
std::string parse_v7_parameters(std::string_view text, std::vector<V7Parameter>& rows);

/// Frames with these V7 ids come from the device with this V8 id.
struct V7Source {
    std::uint8_t first = 0, last = 0;
    std::uint8_t address = 0;
    friend bool operator==(const V7Source&, const V7Source&) = default;
};

struct V7Settings {
    std::uint8_t address = 0;    // the V8 id of the device: the source of its frames
    std::uint8_t port_id = 0;    // the V8 id of the link, which stands for its device; 0: none
    std::vector<V7Source> sources{};
    std::optional<std::uint8_t> v7_address{};    // D_ADDR to the device; std::nullopt: 0xFF, for parameters after the device
    std::optional<V7Acceleration> acc{};         // std::nullopt: after `address`
    unsigned temp = 100;                         // tmp of 0x02 is °C × this: 100 or 10
    std::optional<V7Range> range{};              // std::nullopt: flow for 0xDE, otherwise lx
    V7Layout layout = V7Layout::v8;
    std::bitset<256> down = default_down();    // V8 ids that may be sent to the device, see is_of_own_sensor()
    V7Ack ack = V7Ack::device;
    unsigned repeats = 3;    // times that a request for data is sent; at least 1
    ano::Duration repeat_interval = std::chrono::milliseconds{200};
    std::vector<V7Parameter> parameters{};    // empty: hosts read and write parameters by number
    std::size_t max_data = 44;                // the largest DATA sent to the device; at most 255
    std::string name{};                       // in the device information; empty: after `address`
    std::uint32_t line = 0;                   // a random number, see V7EchoWatch; 0: no probes are sent
    V7Lines* lines = nullptr;                 // of this gateway; must outlive the translation. nullptr: there are no others

    static std::bitset<256> default_down();
};

/// Frames that were translated or dropped, by cause.
struct V7Counters {
    std::uint64_t up{};                     // V8 frames made from frames of the device
    std::uint64_t down{};                   // V7 frames sent to the device
    std::uint64_t answered{};               // V8 frames made by the gateway: descriptions and, with V7Ack::sent, acknowledgements
    std::uint64_t merged{};                 // requests that their host repeated while the first waited
    std::uint64_t unanswered{};             // requests without an answer, after all repetitions
    std::uint64_t forgotten{};              // acknowledgements that can't be assigned any more: too many were expected
    std::uint64_t up_no_counterpart{};      // the message does not exist in V8
    std::uint64_t up_no_address{};          // D_ADDR has no id in V8
    std::uint64_t up_malformed{};           // not the length of its message
    std::uint64_t up_unrepresentable{};     // a value that V8 can't represent, or no valid distance
    std::uint64_t up_unmatched{};           // an acknowledgement of no request
    std::uint64_t up_echo{};                // a frame that was sent on this link
    std::uint64_t up_loop{};                // a frame that was sent on another link of a gateway
    std::uint64_t up_command{};             // a command or request, which no device sends
    std::uint64_t up_own_sensor{};          // of a host program: only devices send this message
    std::uint64_t up_erase{};               // of a host program: the command that erases the firmware of an LX IMU
    std::uint64_t up_queue_full{};          // of a host program: too many requests wait
    std::uint64_t down_no_counterpart{};    // the message does not exist in V7
    std::uint64_t down_own_sensor{};        // the device would take it for a measurement of its own
    std::uint64_t down_erase{};             // the command that erases the firmware of an LX IMU
    std::uint64_t down_not_allowed{};       // its id is not in V7Settings::down
    std::uint64_t down_malformed{};         // not the length of its message
    std::uint64_t down_too_big{};           // more DATA than V7Settings::max_data
    std::uint64_t down_unrepresentable{};    // a value that V7 can't represent
    std::uint64_t down_unmatched{};          // an acknowledgement or answer, and nothing was requested
    std::uint64_t down_queue_full{};         // too many requests wait
    std::uint64_t down_other_device{};       // to a device: for another one; to a host program: not of the device that it sees
};

struct V7CounterRow {
    std::string_view name;
    std::uint64_t V7Counters::*value;
    std::string_view help;
    bool is_drop = true;
};
inline constexpr V7CounterRow v7_counters[] = {
    {"v7_up", &V7Counters::up, "frames of the device translated to V8", false},
    {"v7_down", &V7Counters::down, "V7 frames sent to the device", false},
    {"v7_answered", &V7Counters::answered, "requests answered by the gateway instead of the device", false},
    {"v7_merged", &V7Counters::merged, "requests that their host repeated while the first waited", false},
    {"v7_unanswered", &V7Counters::unanswered, "requests that the device did not answer", false},
    {"v7_forgotten", &V7Counters::forgotten, "acknowledgements not assigned: more than 32 commands within a second", false},
    {"v7_up_no_counterpart", &V7Counters::up_no_counterpart, "from the device: V8 has no such message"},
    {"v7_up_no_address", &V7Counters::up_no_address, "from the device: its destination has no id in V8"},
    {"v7_up_malformed", &V7Counters::up_malformed, "from the device: not the length of its message"},
    {"v7_up_unrepresentable", &V7Counters::up_unrepresentable, "from the device: a value that V8 cannot represent"},
    {"v7_up_unmatched", &V7Counters::up_unmatched, "from the device: an acknowledgement of no request"},
    {"v7_up_echo", &V7Counters::up_echo, "sent on this link, and received again: the line echoes"},
    {"v7_up_loop", &V7Counters::up_loop, "sent on another V7 link of a gateway, in a loop"},
    {"v7_up_command", &V7Counters::up_command, "from the device: commands and requests, which no device sends"},
    {"v7_up_own_sensor", &V7Counters::up_own_sensor, "from a host program: messages that only devices send"},
    {"v7_up_erase", &V7Counters::up_erase, "from a host program: the command that erases the firmware"},
    {"v7_up_queue_full", &V7Counters::up_queue_full, "from a host program: too many requests wait for an answer"},
    {"v7_down_no_counterpart", &V7Counters::down_no_counterpart, "to the device: V7 has no such message"},
    {"v7_down_own_sensor", &V7Counters::down_own_sensor, "to the device: it would take them for its own measurements"},
    {"v7_down_erase", &V7Counters::down_erase, "to the device: the command that erases its firmware"},
    {"v7_down_not_allowed", &V7Counters::down_not_allowed, "to the device: not in v7_down"},
    {"v7_down_malformed", &V7Counters::down_malformed, "to the device: not the length of its message"},
    {"v7_down_too_big", &V7Counters::down_too_big, "to the device: more DATA than v7_max, or in a command more than 11 bytes"},
    {"v7_down_unrepresentable", &V7Counters::down_unrepresentable, "to the device: a value that V7 cannot represent"},
    {"v7_down_unmatched", &V7Counters::down_unmatched, "to the device: acknowledgements and answers that it did not request"},
    {"v7_down_queue_full", &V7Counters::down_queue_full, "to the device: too many requests wait for an answer"},
    {"v7_down_other_device", &V7Counters::down_other_device, "frames for or of devices other than v7_device"},
};

inline void add(V7Counters& sum, const V7Counters& more) noexcept {
    for (const V7CounterRow& row : v7_counters) sum.*row.value += more.*row.value;
}

/// Where translated frames go; each is valid during the call. No call may call the translation.
class V7Output {
public:
    /// To the V7 end of the link: the device, or the host program.
    virtual void to_device(ano::v7::FrameView frame) = 0;
    /// From there, as the gateway sees it.
    virtual void from_device(ano::FrameView frame) = 0;

protected:
    ~V7Output() = default;
};

/// The translation of one link. What is at its other end is up to the class: V7Translation, a device; V7HostTranslation, a host program.
/// Neither allocates nor throws after construction.
class V7LinkTranslation {
public:
    static constexpr std::size_t max_waiting = 16;
    /// An acknowledgement is accepted for this time after its request.
    static constexpr ano::Duration memory = std::chrono::milliseconds{1000};
    /// Values of 0x02 and 0x05 that complete other frames are this young.
    static constexpr ano::Duration fresh = std::chrono::milliseconds{1000};

    virtual ~V7LinkTranslation() = default;
    V7LinkTranslation(const V7LinkTranslation&) = delete;
    V7LinkTranslation& operator=(const V7LinkTranslation&) = delete;

    /// A frame that was received on the link.
    virtual void up(ano::v7::FrameView frame, ano::TimePoint now, V7Output& output) = 0;
    /// A frame to be sent on the link.
    virtual void down(ano::FrameView frame, ano::TimePoint now, V7Output& output) = 0;
    /// Repeats or gives up a request whose answer is overdue.
    virtual void expire(ano::TimePoint now, V7Output& output) = 0;
    /// When to call expire(); std::nullopt: no request waits for its answer.
    virtual std::optional<ano::TimePoint> deadline() const noexcept = 0;
    /// The connection was lost: forgets all requests and measurements.
    virtual void reset() noexcept = 0;

    const V7Settings& settings() const noexcept { return settings_; }
    const V7Counters& counters() const noexcept { return counters_; }
    /// All frames that were dropped.
    std::uint64_t dropped() const noexcept { return dropped_; }
    /// The counter of the last one; nullptr: none was dropped yet.
    std::uint64_t V7Counters::*last_drop() const noexcept { return last_drop_; }

    static constexpr bool is_of_own_sensor(std::uint8_t id) noexcept { return V7NestedFrames::is_of_own_sensor(id); }

protected:
    using Data = std::span<const std::uint8_t>;
    using Count = std::uint64_t V7Counters::*;

    /// The frame that an answer belongs to: in V8, or with a host program in V7.
    struct Origin {
        std::uint8_t host = 0;
        std::uint8_t asked = 0;    // the V8 id from which the answer comes
        std::uint8_t id = 0;
        ano::Checks checks{};
        friend bool operator==(const Origin&, const Origin&) = default;
    };
    /// A sent frame whose acknowledgement is expected.
    struct Expected {
        std::uint8_t id = 0;
        ano::Checks checks{};
        Origin origin;
        ano::TimePoint at{};
        bool waits = false;
    };
    /// The last frames of one direction whose acknowledgement is expected; equal ones are answered in their order.
    struct ExpectedAcks {
        std::array<Expected, 32> all{};
        std::size_t next = 0;

        /// False: it replaces one that is still expected.
        bool add(const Expected& expected) noexcept;
        std::optional<Expected> take(std::uint8_t id, ano::Checks checks, ano::TimePoint now) noexcept;
    };
    struct Altitude {
        std::int32_t value = 0;
        std::optional<ano::TimePoint> at{};
        bool is_fresh(ano::TimePoint now) const noexcept { return at && now - *at < fresh; }
    };

    explicit V7LinkTranslation(V7Settings settings);

    void expect(ExpectedAcks& acks, const Expected& expected) noexcept {
        if (!acks.add(expected)) ++counters_.forgotten;
    }
    void drop(Count count) noexcept {
        ++(counters_.*count);
        ++dropped_;
        last_drop_ = count;
    }
    /// The source in V8 of frames with this id: after V7Settings::sources, otherwise `usual`.
    std::uint8_t source_of(std::uint8_t v7_id, std::uint8_t usual) const noexcept;
    /// `data` may be at its place in v8_ already, where the frame is then.
    ano::FrameView send_up(std::uint8_t source, std::uint8_t destination, std::uint8_t id, Data data, V7Output& output);
    /// Sends a frame on the link; its receiver in V7 depends on that in V8.
    virtual void send_down(std::uint8_t v8_destination, std::uint8_t id, Data data, V7Output& output) = 0;
    // DATA of V8 in the layout of V7, or in several frames
    void position_down(std::uint8_t v8_destination, Data data, V7Output& output);
    void ranging_down(std::uint8_t v8_destination, Data data, V7Output& output);
    void log_value_down(std::uint8_t v8_destination, Data data, V7Output& output);

    V7Settings settings_;
    V7Acceleration acc_;
    V7Range range_;
    V7Counters counters_;
    std::uint64_t dropped_ = 0;
    Count last_drop_ = nullptr;
    V7EchoWatch echoes_;
    ano::TimePoint now_{};    // of the current call
    std::array<std::uint8_t, ano::overhead + 256> v8_{};
    std::array<std::uint8_t, ano::v7::max_frame_size> v7_{};
};

/// With a device at the other end of the link. A device neither commands nor asks: frames of it that would are dropped, for they are
/// echoes, or from the other end of a tapped line. Its remote control (0x40, 0x41) is passed to hosts only.
///
/// Requests for data (parameters, waypoints) and writes are sent one at a time: the next is sent when the device answered or did
/// not answer in time. Requests for data are repeated, and all are sent again when their host repeats them. A command (0xC0) is sent
/// at once, exactly as often as its host sent it, so that nothing delays an emergency stop.
class V7Translation final : public V7LinkTranslation {
public:
    /// A request that its host repeats is sent again if the last one was sent this long ago, as often as an LX MCU repeats its own;
    /// at most so often in all, because other requests wait.
    static constexpr ano::Duration host_interval = std::chrono::milliseconds{50};
    static constexpr unsigned max_sends = 8;
    /// The gateway describes a device only if it sent a frame within this time.
    static constexpr ano::Duration presence = std::chrono::seconds{3};

    explicit V7Translation(V7Settings settings);
    ~V7Translation() override;

    void up(ano::v7::FrameView frame, ano::TimePoint now, V7Output& output) override;
    void down(ano::FrameView frame, ano::TimePoint now, V7Output& output) override;
    void expire(ano::TimePoint now, V7Output& output) override;
    std::optional<ano::TimePoint> deadline() const noexcept override;
    void reset() noexcept override;

private:
    struct Request {
        Origin origin;
        bool is_own = false;          // for the device information
        std::uint16_t subject = 0;    // number of the parameter or waypoint
        std::uint16_t index = 0;      // of the parameter, as the host knows it
        std::uint8_t size = 0;
        std::array<std::uint8_t, 28> bytes{};    // the V7 frame; a waypoint is the longest
        Data frame() const noexcept { return Data{bytes}.first(size); }
        std::uint8_t id() const noexcept { return bytes[2]; }
    };
    struct Version {
        std::uint16_t value = 0;
        bool known = false;
    };

    /// The table is that of `address`; devices at other ids of the line have none.
    std::span<const V7Parameter> parameters_of(std::uint8_t device) const noexcept {
        return device == settings_.address ? std::span<const V7Parameter>{settings_.parameters} : std::span<const V7Parameter>{};
    }
    std::uint8_t source_of(std::uint8_t v7_id) const noexcept { return V7LinkTranslation::source_of(v7_id, settings_.address); }
    bool is_own_id(std::uint8_t id) const noexcept;
    bool is_for_device(std::uint8_t destination) const noexcept;
    /// Whether a V7 frame with this id for the device `asked` reaches no other device of the line.
    bool reaches_only(std::uint8_t asked, std::uint8_t v7_id) const noexcept;
    /// Counts a frame that was sent by a gateway.
    bool has_returned(ano::v7::FrameView frame) noexcept;
    std::uint8_t receiver(std::uint8_t asked, std::uint8_t v7_id) const noexcept;
    Origin origin_of(ano::FrameView frame) const noexcept;

    // up
    std::size_t rebuild_up(ano::v7::FrameView frame, ano::TimePoint now, std::uint8_t* data) noexcept;
    std::size_t inertial_up(Data v7, std::uint8_t* data) const noexcept;
    std::size_t compass_up(Data v7, ano::TimePoint now, std::uint8_t* data) noexcept;
    std::size_t altitude_up(Data v7, ano::TimePoint now, std::uint8_t* data) noexcept;
    std::size_t position_up(Data v7, ano::TimePoint now, std::uint8_t* data) const noexcept;
    std::size_t ranging_up(Data v7, std::uint8_t* data) noexcept;
    void check_up(ano::v7::FrameView frame, ano::TimePoint now, V7Output& output);
    void parameter_up(ano::v7::FrameView frame, ano::TimePoint now, V7Output& output);
    bool waypoint_up(ano::v7::FrameView frame, ano::TimePoint now, V7Output& output);
    std::optional<std::uint16_t> index_of(std::uint16_t number, std::uint8_t device) const noexcept;
    void send_parameter(const Origin& to, std::uint16_t index, std::int32_t value, V7Output& output);

    // down: each function that sends to the device ends in send_down(); false: the frame was dropped
    bool send_down(Data frame, V7Output& output);
    void send_down(std::uint8_t v8_destination, std::uint8_t id, Data data, V7Output& output) override;
    bool needs_probe(std::uint8_t v7_id) const noexcept;
    void send_probe(V7Output& output);
    void command_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    void waypoint_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    void parameter_command_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    void parameter_action_down(const Origin& origin, std::uint16_t action, ano::TimePoint now, V7Output& output);
    void parameter_value_down(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    std::optional<std::uint16_t> number_of(const Origin& origin, std::uint16_t index) noexcept;
    bool is_present(ano::TimePoint now) const noexcept { return last_frame_ && now - *last_frame_ < presence; }

    // answers of the gateway
    void answer(const Origin& origin, std::uint8_t id, Data data, V7Output& output);
    void acknowledge(const Origin& origin, V7Output& output);
    void describe_commands(const Origin& origin, Data data, V7Output& output);
    void describe_parameter(const Origin& origin, std::uint16_t index, V7Output& output);
    void describe_device(const Origin& origin, ano::TimePoint now, V7Output& output);
    void end_own_request(const Request& ended, std::optional<std::int32_t> value, ano::TimePoint now, V7Output& output);
    bool are_versions_known() const noexcept { return versions_[0].known && versions_[1].known && versions_[2].known; }
    void send_device_info(const Origin& origin, V7Output& output);

    // requests
    void ask(const Origin& origin, std::uint8_t v7_id, Data data, std::uint16_t subject, std::uint16_t index, ano::TimePoint now,
             V7Output& output);
    bool has_waiting(const Origin& origin) const noexcept;
    /// The place of an equal request in the queue.
    std::optional<std::size_t> find_equal(const Origin& origin, const Request& request) const noexcept;
    bool may_be_sent_again(ano::TimePoint now) const noexcept;
    Request& queued(std::size_t i) noexcept { return queue_[(first_ + i) % queue_.size()]; }
    Request request_of(const Origin& origin, std::uint8_t v7_id, Data data, std::uint16_t subject) const noexcept;
    void remove_first() noexcept;
    void begin_next(ano::TimePoint now, V7Output& output);
    bool send_request(ano::TimePoint now, V7Output& output);
    void end_request(ano::TimePoint now, V7Output& output, std::optional<std::int32_t> value = {});
    bool is_in_flight(std::uint8_t v7_id, std::uint16_t subject) const noexcept {
        return in_flight_ && queue_[first_].id() == v7_id && queue_[first_].subject == subject;
    }
    bool asks_for_data(const Request& request) const noexcept { return request.id() == 0xE1 || request.id() == 0x60; }
    static bool is_of_waypoints(const Request& request) noexcept { return request.id() == 0x60 || request.id() == 0x61; }

    Altitude alt_bar_, alt_fu_;
    std::optional<ano::TimePoint> last_frame_{};
    V7NestedFrames nested_;
    std::uint32_t times_passed_on_ = 0;    // V7Lines::times_passed_on when the last one was sent
    std::array<Version, 3> versions_{};    // parameters 2, 3 and 4 of versions_of_
    std::uint8_t versions_of_ = 0;

    ExpectedAcks to_host_;                            // acknowledgements of the device, of requests of hosts
    std::array<Request, max_waiting + 1> queue_{};    // a ring
    std::size_t first_ = 0, size_ = 0;
    bool in_flight_ = false;    // the first one was sent
    unsigned times_sent_ = 0;
    ano::TimePoint due_{};
};

}    // namespace anogate
