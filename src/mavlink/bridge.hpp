// What anogate-mavlink decides: which frame becomes which message for which ground station, and what a message of a station becomes for a
// device. No I/O but through BridgeOutput, no clock.
#pragma once
#include <ano/time.hpp>
#include <gateway/frame_record.hpp>
#include <http/answer.hpp>
#include <mavlink/packet_parser.hpp>
#include <mavlink/settings.hpp>
#include <mavlink/signature.hpp>
#include <mavlink/telemetry.hpp>
#include <mavlink/vehicle_requests.hpp>
#include <record/decoding.hpp>
#include <record/sender_encodings.hpp>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate::mavlink {

class BridgeOutput {
public:
    virtual ~BridgeOutput() = default;
    /// Sends a packet to a station. False: the link accepts no more at present.
    virtual bool transmit(std::size_t connection, std::span<const std::uint8_t> packet) = 0;
    /// Sends a frame to the gateway. False: it is not connected.
    virtual bool send(ano::Bytes frame) = 0;
    /// Sends a request to the gateway; `done` gets the response later. False: too many requests are waiting.
    virtual bool request(DeviceRequest request, std::function<void(const http::Outcome&)> done) = 0;
    virtual void log(std::string_view line) = 0;
    virtual std::uint64_t unix_us() = 0;
};

/// A link to one or several ground stations.
struct ConnectionKind {
    Transport transport = Transport::reliable;
    /// HEARTBEAT is sent before a station sent one: the address is configured, or connected. Otherwise nothing is sent before.
    bool speaks_first = false;
    bool is_datagram = false;
    std::string name{};    // for the log
};

struct BridgeCounters {
    std::uint64_t forged = 0;              // packets with the system id of one of our vehicles
    std::uint64_t unexpected = 0;          // before the first HEARTBEAT of a station
    std::uint64_t unsigned_packets = 0;    // without the signature that the configuration requires, or with a wrong one
    std::array<std::uint64_t, stick_faults> sticks{};    // by StickFault
};

class MavlinkBridge {
public:
    static constexpr std::uint8_t component = 1;       // MAV_COMP_ID_AUTOPILOT1
    static constexpr std::size_t max_waiting = 256;    // packets of a connection besides telemetry

    /// Both must outlive it.
    MavlinkBridge(const MavlinkSettings& settings, BridgeOutput& output, ano::TimePoint now,
                  const std::optional<SigningKey>& key = {});
    ~MavlinkBridge();

    /// Before the first frame, and whenever the layouts of the gateway change.
    void use(DecodingPtr decoding) { decoding_ = std::move(decoding); }
    /// A frame that the gateway received on `link`.
    void receive(std::string_view link, const FrameRecord& record, ano::TimePoint now);

    /// Its number is never used again.
    std::size_t open(ConnectionKind kind, ano::TimePoint now);
    void close(std::size_t connection);
    void on_bytes(std::size_t connection, std::span<const std::uint8_t> bytes, ano::TimePoint now);
    /// No byte was received for PacketParser::quiet.
    void on_quiet(std::size_t connection, ano::TimePoint now);
    /// At least every 20 ms, and after frames were received.
    void on_time(ano::TimePoint now);

    const BridgeCounters& counters() const noexcept { return counters_; }

private:
    struct Vehicle;
    struct Connection;
    struct PerVehicle;
    Vehicle* vehicle_of(std::string_view link, std::uint8_t address) noexcept;
    void read_packets(Connection& connection, ano::TimePoint now);
    void on_packet(Connection& connection, PacketView packet, ano::TimePoint now);
    void on_message(Connection& connection, Vehicle& vehicle, PacketView packet, ano::TimePoint now);
    void on_command(Connection& connection, Vehicle& vehicle, const StationCommand& command, ano::TimePoint now);
    std::optional<Result> own_command(Connection& connection, Vehicle& vehicle, const StationCommand& command,
                                      ano::TimePoint now);
    void carry_out(Vehicle& vehicle, const StationCommand& command, const std::function<void(Result)>& done);
    void on_sticks(Vehicle& vehicle, PacketView packet, ano::TimePoint now);
    bool send(const Vehicle& vehicle, const StickFrame& frame);
    void answer(Connection& connection, const Vehicle& vehicle, const Payload& payload);
    void answer(Origin station, const Vehicle& vehicle, const Payload& payload);
    void send_to_all(const Vehicle& vehicle, const Payload& payload);
    void report(Vehicle& vehicle, Severity severity, const std::string& text);
    void pump(Connection& connection, ano::TimePoint now);
    bool pump_telemetry(Connection& connection, Vehicle& vehicle, ano::TimePoint now);
    bool transmit(Connection& connection, const Vehicle& vehicle, const Payload& payload);
    void on_text(Vehicle& vehicle, std::string_view link, const FrameRecord& record);
    void request(DeviceRequest request, const std::function<void(const http::Outcome&)>& done);
    void set_up(Vehicle& vehicle);
    TelemetryContext context_of(const Connection& connection, const Vehicle& vehicle, ano::TimePoint now) const;
    std::uint64_t since_start_us(ano::TimePoint now) const noexcept;

    BridgeOutput& output_;
    Autopilot autopilot_;
    ano::TimePoint start_;
    ano::TimePoint now_, timed_at_;    // of the last call, and of the last on_time()
    DecodingPtr decoding_;
    SenderEncodings encodings_;
    std::vector<std::unique_ptr<Vehicle>> vehicles_;
    std::map<std::size_t, std::unique_ptr<Connection>> connections_;
    std::map<std::uint16_t, std::size_t> where_;    // the connection of each station
    std::size_t next_connection_ = 0;
    std::optional<SigningKey> key_;
    std::optional<SignatureCheck> signatures_;
    std::uint64_t signed_at_ = 0;    // the time of the last signature: each is later than those before
    BridgeCounters counters_;
};

}    // namespace anogate::mavlink
