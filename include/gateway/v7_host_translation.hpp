// Translates between V8 and a link with a V7 host program at its other end: a ground station, a ROS bridge or an MCU, which sees
// one V8 device (include/ano/protocol-v7.md, section 8, "Reverse"). The flow is that of V7Translation.
#pragma once
#include <gateway/v7_translation.hpp>

#include <ano/address.hpp>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

namespace anogate {

/// V7Settings::address is the device that the host program sees. The host program has the V8 id of hosts, 0xFE, or that of
/// V7Settings::sources.
///
/// A command is sent to the device exactly as often as the host program sends it, and so is a write, except one that the host
/// program repeats while the first still waits. Requests for data are repeated. They and writes are sent one at a time. Because V7
/// has no types, the device is asked for the type of a parameter before its value.
class V7HostTranslation final : public V7LinkTranslation {
public:
    explicit V7HostTranslation(V7Settings settings) : V7LinkTranslation{std::move(settings)} {
        if (settings_.lines) ++settings_.lines->of_programs;
    }
    ~V7HostTranslation() override {
        if (settings_.lines) --settings_.lines->of_programs;
    }

    void up(ano::v7::FrameView frame, ano::TimePoint now, V7Output& output) override;
    void down(ano::FrameView frame, ano::TimePoint now, V7Output& output) override;
    void expire(ano::TimePoint now, V7Output& output) override;
    std::optional<ano::TimePoint> deadline() const noexcept override;
    void reset() noexcept override;

    /// The value of an unused parameter.
    static constexpr std::int32_t no_parameter = INT32_MIN;

private:
    struct KnownType {
        std::uint16_t index = 0;
        std::optional<ano::Type> type{};
    };
    struct Request {
        Origin origin;                // the V7 frame of the host program
        std::uint16_t number = 0;     // of the parameter or waypoint
        std::uint16_t index = 0;      // of the parameter in the device
        std::int32_t value = 0;       // to be written
        bool is_of_device = false;    // a number that the device information answers
    };

    // from the host program
    void probe_up(std::uint32_t line) noexcept;
    /// Whether what arrives was sent to a device by this gateway: the wires of both links are connected.
    bool is_connected() const noexcept { return connected_at_ && now_ - *connected_at_ < V7EchoWatch::holds; }
    std::uint8_t host_of(std::uint8_t v7_id) const noexcept { return source_of(v7_id, ano::address::host); }
    void send_to_device(std::uint8_t v7_id, std::uint8_t id, Data data, V7Output& output) {
        send_up(host_of(v7_id), settings_.address, id, data, output);
    }
    /// Its acknowledgement is passed on to the host program.
    void send_acknowledged(const Origin& origin, std::uint8_t id, Data data, ano::TimePoint now, V7Output& output);
    void rebuild_up(ano::v7::FrameView frame, V7Output& output);
    void command_up(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    void read_up(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    void write_up(const Origin& origin, Data data, ano::TimePoint now, V7Output& output);
    std::optional<std::uint16_t> index_of(std::uint16_t number) const noexcept;

    // to the host program
    std::uint8_t receiver(std::uint8_t v8_destination) const noexcept;
    void send_down(std::uint8_t v8_destination, std::uint8_t id, Data data, V7Output& output) override;
    void rebuild_down(ano::FrameView frame, ano::TimePoint now, V7Output& output);
    void inertial_down(std::uint8_t to, Data data, V7Output& output);
    void compass_down(std::uint8_t to, Data data, ano::TimePoint now, V7Output& output);
    void altitude_down(std::uint8_t to, Data data, ano::TimePoint now, V7Output& output);
    void check_down(Data data, ano::TimePoint now, V7Output& output);
    void description_down(Data data, ano::TimePoint now, V7Output& output);
    void value_down(Data data, ano::TimePoint now, V7Output& output);
    void device_info_down(Data data, ano::TimePoint now, V7Output& output);
    void waypoint_down(ano::FrameView frame, ano::TimePoint now, V7Output& output);
    void send_parameter(const Origin& to, std::uint16_t number, std::int32_t value, V7Output& output);

    // requests
    const Request* in_flight(std::uint8_t v7_id) const noexcept {
        return in_flight_ && queue_[first_].origin.id == v7_id ? &queue_[first_] : nullptr;
    }
    KnownType& known_type(std::uint16_t index) noexcept { return types_[index % types_.size()]; }
    std::optional<ano::Type> type_of(const Request& request) noexcept;
    bool is_write(const Request& request) const noexcept { return request.origin.id == 0xE2; }
    void ask(const Request& request, ano::TimePoint now, V7Output& output);
    void begin_next(ano::TimePoint now, V7Output& output);
    /// False: nothing was sent, because the type of the parameter can't have the value.
    bool send_request(ano::TimePoint now, V7Output& output);
    bool send_write(const Request& request, ano::Type type, ano::TimePoint now, V7Output& output);
    void remove_first() noexcept;
    void end_request(ano::TimePoint now, V7Output& output);
    double scale_of(std::uint16_t index, ano::Type type) const noexcept;

    Altitude alt_bar_;
    std::optional<ano::TimePoint> connected_at_{};    // when a probe of a device link of this gateway arrived last
    ExpectedAcks to_host_;                            // acknowledgements of the device, of frames of the host program
    std::array<KnownType, 256> types_{};              // by index, the last ones that were asked for
    std::array<Request, max_waiting + 1> queue_{};    // a ring
    std::size_t first_ = 0, size_ = 0;
    bool in_flight_ = false;     // the first one was sent
    bool is_written_ = false;    // it is a write, and was sent as such
    unsigned times_sent_ = 0;
    ano::TimePoint due_{};
};

}    // namespace anogate
