// sim:lx. An LX IMU, which flies an aircraft, in the previous protocol version (include/ano/protocol-v7.md): its messages at the
// rates measured behind a data radio, acknowledgements, parameters by number, commands and waypoints.
#pragma once
#include "flight.hpp"
#include "satellites.hpp"
#include "sensors.hpp"
#include "simulated_device.hpp"

#include <ano/v7.hpp>

#include <array>
#include <map>
#include <span>
#include <string_view>
#include <vector>

namespace ano::world {

class LxUnit final : public SimulatedDevice {
public:
    static constexpr std::uint8_t usual_id = 0xDD;

    LxUnit(const Settings& settings, TimePoint start);

    bool uses_v7() const noexcept override { return true; }
    void receive(Bytes bytes, TimePoint now, const Send& send) override;
    void restart() override;

    const Flight& flight() const noexcept { return flight_; }
    std::int32_t parameter(std::uint16_t number) const;
    std::size_t waypoints() const noexcept { return waypoints_.size(); }
    /// Frames that it took for measurements of its own sensors. No gateway may send any.
    std::uint64_t false_measurements() const noexcept { return false_measurements_; }
    /// Its firmware was erased: it no longer sends or receives. No gateway may cause that.
    bool is_erased() const noexcept { return is_erased_; }
    /// The DATA of the commands it received, without repetitions being removed.
    const std::vector<std::array<std::uint8_t, 11>>& commands() const noexcept { return commands_; }

private:
    struct Message {
        std::uint8_t id;
        std::uint16_t period;    // number of the parameter with its period in ms
        Duration usual_period;
        void (LxUnit::*emit)();
        Duration next{};
    };
    enum class Class : std::uint8_t { always, not_in_mode_0, only_in_mode_3 };
    struct Command {
        std::uint32_t id;    // CID, CMD0, CMD1
        void (LxUnit::*run)(const std::uint8_t* values);
        Class when = Class::always;
    };
    using Waypoint = std::array<std::uint8_t, 22>;

    void advance() override;
    void emit_due();
    void emit_v7(std::uint8_t id, Bytes data);
    template <class Draft>
    void emit_same(const Draft& draft);
    void say(std::string_view text, bool is_bad);
    static const std::array<Message, 15>& messages();
    static std::span<const Command> known_commands();

    // messages
    void inertial();
    void compass();
    void euler();
    void quaternion();
    void altitude();
    void mode();
    void velocity();
    void position();
    void wind();
    void power();
    void modules();
    void outputs();
    void satellites();
    void sticks();
    void steering();
    void private_message();

    // requests
    void take(v7::FrameView frame);
    void acknowledge(v7::FrameView frame);
    void command(Bytes data);
    void read_parameter(std::uint16_t number);
    void write_parameter(std::uint16_t number, std::int32_t value);
    void read_waypoint(std::uint8_t number);
    bool write_calibration(std::uint16_t number, std::int32_t value);
    std::int32_t calibration(std::uint16_t number) const;
    void restore_defaults();
    void store();

    // commands
    void done(const std::uint8_t*) { say("done", false); }
    void restore(const std::uint8_t*) { restore_defaults(); }
    void store_waypoints(const std::uint8_t*) { stored_waypoints_ = waypoints_; }
    void clear_waypoints(const std::uint8_t*) { waypoints_.clear(); }
    void set_mode(const std::uint8_t* values);
    void begin_accelerometer(const std::uint8_t*);
    void begin_compass(const std::uint8_t*);
    void erase(const std::uint8_t*) { is_erased_ = true; }
    void unlock(const std::uint8_t*) { flight_.unlock(); }
    void stop(const std::uint8_t*) { flight_.stop(); }
    void hover(const std::uint8_t*) { flight_.hover(); }
    void take_off(const std::uint8_t* values);
    void land(const std::uint8_t*) { flight_.land(); }
    void return_home(const std::uint8_t*) { flight_.return_home(); }
    void fly_waypoints(const std::uint8_t*);
    void target_position(const std::uint8_t* values);
    void target_height(const std::uint8_t* values);
    void up(const std::uint8_t* values);
    void down(const std::uint8_t* values);
    void move(const std::uint8_t* values);
    void turn_left(const std::uint8_t* values);
    void turn_right(const std::uint8_t* values);
    void target_place(const std::uint8_t* values);
    void go_to(Vector there) { flight_.go_to(there); }

    FlightSettings settings_;
    Flight flight_;
    Accelerometer accelerometer_;
    Compass compass_;
    Gyroscope gyroscope_;
    Satellites satellites_;
    Place home_{116.3, 39.9};
    std::array<Message, 15> messages_ = messages();
    double private_ones_ = 0;    // part of the next private message that is due
    std::array<std::uint8_t, 20> sticks_{};
    std::array<std::uint8_t, 14> steering_{};
    std::array<std::uint8_t, 3> running_{};    // the last command to the flight

    std::map<std::uint16_t, std::int32_t> parameters_, stored_;
    Duration store_at_ = Duration::max();    // simulated time
    std::map<std::uint8_t, Waypoint> waypoints_, stored_waypoints_;
    std::array<float, 15> stored_accelerometer_{};
    std::array<float, 6> stored_compass_{};
    std::vector<std::array<std::uint8_t, 11>> commands_;
    std::uint64_t false_measurements_ = 0;
    bool is_erased_ = false;
};

}    // namespace ano::world
