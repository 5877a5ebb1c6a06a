// The parameters of a device (protocol text, section 4, 0xE0 to 0xE2). The user owns their values, and passes a variable or two
// functions for each parameter.
//
// Flow:    float gain = 0.5f;
//          parameters.add("GAIN", gain, {.info = "how fast", .min = 0, .max = 10});    // its default is 0.5
//          parameters.on_save([&] { return write_file(); });
//          parameters.write("GAIN", read_from_file());                                 // like a host
#pragma once
#include <ano/typed.hpp>
#include <device/info.hpp>
#include <device/profile.hpp>
#include <device/reply.hpp>
#include <device/value.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace ano::device {

/// The actions of 0xE0 with cmd 0x10. The vendor's host program sends the four calibration actions automatically.
enum class Action : std::uint16_t {
    clear_accelerometer = 0x20,    // so that raw values are sent
    store_accelerometer = 0x21,    // all 15 values were written
    clear_compass = 0x30,
    store_compass = 0x31,
    restore_defaults = 0xAA,
    save = 0xAB,
};

/// One parameter, accessed by functions. Parameters::add() also makes one from a variable.
struct Parameter {
    std::string name{};                         // 1 to 20 bytes, unique in the device
    Type type = Type::f32;                      // a number, or Type::text
    std::function<Value()> get{};               // required; a value of another type is not sent
    std::function<bool(const Value&)> set{};    // called only with values within type and limits; false: refused. Empty:
                                                // read-only
    Value initial{};                            // the default, written when defaults are restored
    std::optional<Value> min{}, max{};          // of numbers; std::nullopt: the limits of the type
    std::size_t max_size = max_sent;            // bytes of a text
    std::string info{};                         // for people; truncated to fit into a frame
};

/// Optional properties of a parameter that is a variable.
template <class T>
struct Limits {
    std::string info{};
    std::optional<T> min{}, max{};
};
template <>
struct Limits<std::string> {
    std::string info{};
    std::size_t max_size = max_sent;
};

class Parameters {
public:
    explicit Parameters(const Profile& profile) noexcept : profile_{profile} {}

    /// Returns the id; ids count from 0. Throws std::invalid_argument for an invalid row: no name, a name in use, no get, limits
    /// that are not values of the type, a calibration parameter (CAL_) that is not f32.
    std::uint16_t add(Parameter parameter);
    /// `variable` is the value of the parameter; its present value is the default. It must outlive this object.
    template <Wire T>
    std::uint16_t add(std::string name, T& variable, const Limits<std::type_identity_t<T>>& limits = {});
    /// Adds CAL_AOFF_X to CAL_AEM3_Z: offset, sensitivity and error matrix by rows, in the order of the protocol text, with no
    /// other parameters between them. Sets `values` to 0, 1 and the unit matrix, which are the defaults. `values` must outlive
    /// this object.
    void add_accelerometer_calibration(std::array<float, 15>& values);
    /// The same for CAL_MOFF_X to CAL_MSEN_Z: offset and sensitivity, 0 and 1.
    void add_compass_calibration(std::array<float, 6>& values);

    /// Sets the function that stores all values and returns true on success. Without it, a request to save is not answered.
    void on_save(std::function<bool()> save) { actions_[static_cast<std::uint16_t>(Action::save)] = std::move(save); }
    /// Sets the function for 0xE0 with cmd 0x10 and this number; it returns true on success. It replaces the built-in behaviour:
    /// restoring writes the defaults, clearing a calibration writes the defaults of its parameters, storing one saves.
    void on(std::uint16_t action, std::function<bool()> function) { actions_[action] = std::move(function); }
    void on(Action action, std::function<bool()> function) { on(static_cast<std::uint16_t>(action), std::move(function)); }

    std::size_t count() const noexcept { return rows_.size(); }
    const Parameter& operator[](std::size_t id) const noexcept { return rows_[id]; }
    std::optional<std::uint16_t> find(std::string_view name) const noexcept;
    /// Writes like a host: the value is clamped to the limits. False: no parameter has this name, the value has another type, or
    /// the user's function refused it.
    bool write(std::string_view name, const Value& value);
    /// Writes the default of each parameter whose name begins with `beginning`; false: at least one of them was refused.
    bool restore_defaults(std::string_view beginning = "");

    /// Answers 0xE0 except cmd 0, which requests the device info.
    Outcome process(const View<"parameter_command">& question, Reply& reply);
    Outcome process(const View<"parameter_command", "action">& action, Reply& reply);
    /// Answers 0xE1, which to a device is always a write.
    Outcome process(const View<"parameter_value">& written, Reply& reply);

    /// Whether the crash that Profile::crashes_at_the_count simulates has happened: the device no longer answers.
    bool crashed() const noexcept { return crashed_; }

private:
    Outcome send_count(const View<"parameter_command">& question, Reply& reply);
    Outcome send_value(std::uint16_t id, Reply& reply);
    Outcome describe(std::uint16_t id, Reply& reply);
    Outcome send_old_description(std::uint16_t id, Reply& reply) const;
    Outcome send_scaled_description(std::uint16_t id, Reply& reply) const;
    std::int32_t factor_of(const Parameter& row) const noexcept;
    bool has(std::uint16_t id);
    bool has_calibration(std::string_view beginning) const noexcept;
    bool act(std::uint16_t action, bool& known);
    bool assign(const Parameter& row, const Value& value) const;
    std::optional<Value> value_written(const Parameter& row, const View<"parameter_value">& written, FrameView frame) const;

    const Profile& profile_;
    std::vector<Parameter> rows_;
    std::map<std::uint16_t, std::function<bool()>> actions_;
    std::vector<std::uint8_t> bytes_;    // of the value being sent
    bool crashed_ = false;
};

template <Wire T>
std::uint16_t Parameters::add(std::string name, T& variable, const Limits<std::type_identity_t<T>>& limits) {
    Parameter row;
    row.name = std::move(name);
    row.type = type_of<T>;
    row.initial = to_value(variable);
    row.info = limits.info;
    row.get = [&variable] { return to_value(variable); };
    row.set = [&variable](const Value& value) {
        variable = from_value<T>(value);
        return true;
    };
    if constexpr (WireNumber<T>) {
        if (limits.min) row.min = to_value(*limits.min);
        if (limits.max) row.max = to_value(*limits.max);
    } else {
        row.max_size = limits.max_size;
    }
    return add(std::move(row));
}

}    // namespace ano::device
