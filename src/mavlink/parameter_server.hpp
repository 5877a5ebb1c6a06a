// The parameter protocol for one vehicle: list, read, and set with the value that the device stored. No I/O, no clock.
#pragma once
#include <mavlink/packet.hpp>
#include <mavlink/parameter_table.hpp>
#include <mavlink/telemetry.hpp>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace anogate::mavlink {

class ParameterServer {
public:
    struct Output {
        /// Reads all parameters; `done` gets them, or the reason why not.
        std::function<void(std::function<void(std::vector<DeviceParameter> parameters, std::string error)> done)> read;
        /// Writes one; `done` gets the value that the device stored, or the reason why not.
        std::function<void(const std::string& name, const ano::Number& value,
                           std::function<void(std::optional<ano::Number> stored, std::string error)> done)>
            write;
        std::function<void(Severity severity, const std::string& text)> report;
        /// Of a value that was written: all stations show it.
        std::function<void(const Payload& payload)> send_to_all;
    };
    static constexpr std::size_t max_stations = 16, max_waiting_sets = 64;

    explicit ParameterServer(Output output) : output_{std::move(output)} {}

    /// PARAM_REQUEST_LIST, PARAM_REQUEST_READ, PARAM_SET; other messages are ignored.
    void receive(PacketView packet);
    /// The next PARAM_VALUE for this station, to be called when its link accepts a packet; std::nullopt: none waits.
    std::optional<Payload> next(Origin station);
    bool waits(Origin station) const noexcept { return waiting_.contains(key(station)); }
    /// The device restarted, or another program may have changed values: the next list is read again.
    void forget() noexcept { is_read_ = false; }

private:
    struct Station {
        bool wants_list = false;
        std::size_t next = 0;              // of the list
        std::deque<std::size_t> single;    // places that were asked for
    };
    static std::uint16_t key(Origin station) noexcept {
        return static_cast<std::uint16_t>(station.system << 8 | station.component);
    }
    Station* station_of(Origin origin);
    void on_list(Origin from);
    void on_read(Origin from, std::string_view id, std::int16_t index);
    void on_set(std::string_view id, std::uint8_t type_number, float value);
    void read();
    void was_read(std::vector<DeviceParameter> parameters, const std::string& error);
    void was_written(std::size_t place, std::optional<ano::Number> stored, const std::string& error);
    Payload payload_of(std::size_t place) const;

    Output output_;
    ParameterTable table_;
    bool is_read_ = false, is_reading_ = false, told_left_out_ = false;
    std::size_t sets_ = 0;
    std::map<std::uint16_t, Station> waiting_;
};

}    // namespace anogate::mavlink
