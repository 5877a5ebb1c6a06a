// The mission protocol for one vehicle, in both directions. Nothing is written before all items are known to be expressible. No I/O, no
// clock.
#pragma once
#include <ano/time.hpp>
#include <mavlink/mission_items.hpp>
#include <mavlink/telemetry.hpp>

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace anogate::mavlink {

class MissionServer {
public:
    struct Output {
        using Read = std::function<void(std::vector<Waypoint> waypoints, std::string error)>;
        using Written = std::function<void(std::string error)>;
        /// Reads all waypoints of the device, with HOME.
        std::function<void(Read done)> read;
        /// Writes these waypoints; the device keeps its others.
        std::function<void(const std::vector<Waypoint>& waypoints, Written done)> write;
        /// Removes all waypoints; empty: the device has no command for it.
        std::function<void(Written done)> clear;
        /// Flies the waypoints from `first` on; only while a mission is flown.
        std::function<void(std::uint8_t first)> fly_from;
        std::function<void(Origin station, const Payload& payload)> send;
        std::function<void(const Payload& payload)> send_to_all;
        std::function<void(Severity severity, const std::string& text)> report;
    };
    static constexpr ano::Duration patience = std::chrono::seconds{1};    // until an item is requested again
    static constexpr int max_requests = 6;                                // of one item
    static constexpr std::size_t max_downloads = 16, max_items = 600;

    MissionServer(std::vector<FunRow> funs, Output output) : funs_{std::move(funs)}, output_{std::move(output)} {}

    /// A message of the mission protocol; others are ignored.
    void receive(PacketView packet, ano::TimePoint now);
    void on_time(ano::TimePoint now);
    void set_home_altitude(std::optional<double> metres) noexcept { home_altitude_ = metres; }
    /// Where the vehicle is while it flies a mission: for MISSION_ITEM_REACHED and MISSION_CURRENT.
    void on_place(double lat, double lng, double height);
    /// The waypoint that the next mission begins with.
    std::uint8_t first_waypoint() const noexcept { return waypoint_of_item(items_, current_); }
    Payload current() const;

private:
    struct Upload {
        Origin station{};
        std::uint16_t first = 0, end = 0;    // of the items that are requested
        std::uint16_t next = 0;
        std::vector<MissionItem> items;    // all, with those that stay
        bool is_partial = false, is_writing = false;
        int requests = 0;
        ano::TimePoint due{};
        std::uint64_t number = 0;
    };
    void on_count(Origin from, std::uint16_t count, std::uint8_t type, ano::TimePoint now);
    void on_partial_write(Origin from, int first, int last, std::uint8_t type, ano::TimePoint now);
    void on_item(Origin from, std::uint16_t number, const MissionItem& item, ano::TimePoint now);
    void on_request(Origin from, std::uint16_t number, bool wants_floats);
    void on_request_list(Origin from, std::uint8_t type);
    void on_partial_read(Origin from, int first, int last, std::uint8_t type);
    void on_clear(Origin from, std::uint8_t type);
    void on_set_current(Origin from, std::uint16_t number);
    bool begin(Origin from);
    void request(ano::TimePoint now);
    void complete();
    void write(const std::vector<Waypoint>& stored);
    void put(const std::vector<Waypoint>& waypoints);
    void end(MissionResult result, const std::string& text);
    void acknowledge(Origin to, MissionResult result, std::uint8_t type = 0);
    void send_item(Origin to, std::uint16_t number, bool in_floats);

    std::vector<FunRow> funs_;
    Output output_;
    std::optional<double> home_altitude_;
    std::optional<Upload> upload_;
    std::uint64_t uploads_ = 0;
    std::map<std::uint16_t, std::vector<MissionItem>> downloads_;    // by station
    std::vector<MissionItem> items_;                                 // as last read or written
    std::size_t current_ = 0;
    std::optional<std::size_t> reached_;
};

}    // namespace anogate::mavlink
