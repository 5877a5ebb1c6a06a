// The commands of a device (protocol text, section 4, 0xC0 to 0xC2): functions of the user. Hosts can read their names and types.
//
// Flow:    commands.add({1, 0, 1}, "BLINK", "times, seconds", [](std::uint8_t times, float seconds) { ... });
//          commands.add({1, 0, 2}, "REBOOT", "", [] { return may_reboot(); });    // false: refused, and not acknowledged
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
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace ano::device {

using CommandId = std::array<std::uint8_t, 3>;    // cid0 to cid2
inline constexpr std::size_t max_command_values = 8;

struct Command {
    CommandId cid{};                                      // unique in the device
    std::string name{};                                   // 1 to 20 bytes
    std::string info{};                                   // for people; truncated to fit into a frame
    std::vector<Type> types{};                            // of its values, which are numbers; at most 8
    std::function<bool(std::span<const Value>)> run{};    // one value of each type; false: refused
};

class Commands {
public:
    explicit Commands(const Profile& profile) noexcept : profile_{profile} {}

    /// Returns the number by which hosts request its description. Throws std::invalid_argument for an invalid row: no name, a cid
    /// in use, no function, more than 8 values, a type without a number in 0xC2 (text; u64 if Profile::value_type_7 is f32).
    std::uint16_t add(Command command);
    /// Adds a function or a lambda; the types are those of its parameters. It returns void, or bool: false refuses the command.
    template <class F>
    requires(!std::is_same_v<std::remove_cvref_t<F>, std::function<bool(std::span<const Value>)>>) std::uint16_t
        add(CommandId cid, std::string name, std::string info, F function) {
        return add_function(Command{cid, std::move(name), std::move(info), {}, {}}, std::function{std::move(function)});
    }

    std::size_t count() const noexcept { return rows_.size(); }
    const Command& operator[](std::size_t n) const noexcept { return rows_[n]; }

    /// Runs the command selected by 0xC0. The acknowledgement is sent after the function has returned.
    Outcome process(const View<"command">& command, Reply& reply);
    Outcome process(const View<"command_query">& question, Reply& reply);

private:
    template <class R, class... A>
    std::uint16_t add_function(Command row, std::function<R(A...)> function);
    Outcome send_count(const View<"command_query">& question, Reply& reply) const;
    Outcome describe(std::uint16_t n, Reply& reply) const;
    bool values_of(const Command& row, Bytes bytes, FrameView frame);
    bool is_newest() const noexcept;    // the value types are those of the newest generation of devices

    const Profile& profile_;
    std::vector<Command> rows_;
    std::vector<Value> values_;    // of the command being run
};

template <class R, class... A>
std::uint16_t Commands::add_function(Command row, std::function<R(A...)> function) {
    static_assert(sizeof...(A) <= max_command_values, "a command has at most 8 values");
    static_assert((WireNumber<std::remove_cvref_t<A>> && ...), "the values of a command are integers, float and double");
    static_assert(std::is_void_v<R> || std::is_same_v<R, bool>, "a command returns nothing, or whether it was carried out");
    row.types = {type_of<std::remove_cvref_t<A>>...};
    row.run = [f = std::move(function)](std::span<const Value> values) {
        return [&]<std::size_t... I>(std::index_sequence<I...>) {
            if constexpr (std::is_void_v<R>) return f(from_value<std::remove_cvref_t<A>>(values[I])...), true;
            else return f(from_value<std::remove_cvref_t<A>>(values[I])...);
        }
        (std::index_sequence_for<A...>{});
    };
    return add(std::move(row));
}

}    // namespace ano::device
