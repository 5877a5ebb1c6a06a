#include <ano/address.hpp>
#include <device/commands.hpp>

#include <algorithm>
#include <optional>
#include <stdexcept>

namespace ano::device {
namespace {

// cmd of 0xC1
constexpr std::uint8_t query_count = 0;
constexpr std::uint8_t query_describe = 1;

/// The number of `type` in 0xC2; std::nullopt: there is none. f32 has two numbers: 9 in the newest generation, the only one with
/// numbers above 7, and 7 in the older ones.
std::optional<std::uint8_t> val_type_of(Type type, const Profile& profile, bool is_newest) noexcept {
    if (type == Type::f32) return is_newest ? 9 : 7;
    for (std::uint8_t number = 1; number <= 10; ++number)
        if (command_value_type(number, profile.value_type_7) == type) return number;
    return std::nullopt;
}

}    // namespace

std::uint16_t Commands::add(Command row) {
    const auto refuse_unless = [&](bool sensible, const char* why) {
        if (!sensible) throw std::invalid_argument{"command \"" + row.name + "\": " + why};
    };
    const auto same = [&](const Command& other) { return other.cid == row.cid; };
    refuse_unless(!row.name.empty() && row.name.size() <= max_name, "a name has 1 to 20 bytes");
    refuse_unless(std::none_of(rows_.begin(), rows_.end(), same), "there is one with these three numbers");
    refuse_unless(rows_.size() < UINT16_MAX, "there are 65535 already");
    refuse_unless(row.types.size() <= max_command_values, "it has more than 8 values");
    refuse_unless(static_cast<bool>(row.run), "it has no function");
    for (const Type type : row.types)
        refuse_unless(val_type_of(type, profile_, true).has_value(), "a value is of a type that 0xC2 has no number for");
    rows_.push_back(std::move(row));
    return static_cast<std::uint16_t>(rows_.size() - 1);
}

bool Commands::is_newest() const noexcept {
    const auto is_wide = [](Type type) { return type == Type::u64 || type == Type::i64 || type == Type::f64; };
    return !profile_.sends_i32() || std::any_of(rows_.begin(), rows_.end(), [&](const Command& row) {
        return std::any_of(row.types.begin(), row.types.end(), is_wide);
    });
}

Outcome Commands::process(const View<"command">& command, Reply& reply) {
    const CommandId cid{command.get<"cid0">(), command.get<"cid1">(), command.get<"cid2">()};
    const auto row = std::find_if(rows_.begin(), rows_.end(), [&](const Command& r) { return r.cid == cid; });
    if (row == rows_.end()) return Outcome::unknown;
    if (!values_of(*row, command.get<"values">(), reply.request())) return Outcome::malformed;
    return row->run(values_) ? reply.acknowledge() : Outcome::refused;
}

// More bytes than the types need are accepted: some hosts always send the maximum.
bool Commands::values_of(const Command& row, Bytes bytes, FrameView frame) {
    std::size_t needed = 0;
    for (const Type type : row.types) needed += width(type);
    std::array<std::uint8_t, max_command_values * sizeof(std::uint64_t)> filled{};
    if (bytes.size() < needed) {
        if (!profile_.reads_behind_the_end) return false;
        const Bytes to_the_end = frame.bytes().last(bytes.size() + 2);    // including SC and AC after it
        std::copy_n(to_the_end.begin(), std::min(to_the_end.size(), filled.size()), filled.begin());
        bytes = filled;
    }
    values_.clear();
    for (const Type type : row.types) {
        values_.push_back(read_value(type, bytes));
        bytes = bytes.subspan(width(type));
    }
    return true;
}

Outcome Commands::process(const View<"command_query">& question, Reply& reply) {
    const std::uint16_t val = question.get<"val">();
    switch (question.get<"cmd">()) {
    case query_count: return send_count(question, reply);
    case query_describe: return val < rows_.size() ? describe(val, reply) : Outcome::unknown;
    default: return Outcome::unknown;
    }
}

// As with parameters: the answer has the form of the question, and another device must not answer it as a question.
Outcome Commands::send_count(const View<"command_query">& question, Reply& reply) const {
    const bool asked_by_host = reply.asker().address == address::host;
    if (!asked_by_host && (question.get<"val">() != 0 || rows_.empty())) return Outcome::unanswered;
    Draft<"command_query"> answer;
    if (!answer.set<"cmd">(query_count) || !answer.set<"val">(rows_.size())) return Outcome::unknown;
    return reply.send(answer, profile_.old_layouts ? 2 : 0);
}

Outcome Commands::describe(std::uint16_t n, Reply& reply) const {
    const Command& row = rows_[n];
    std::array<std::uint8_t, max_command_values> types{};    // 0: none
    for (std::size_t i = 0; i < row.types.size(); ++i) types[i] = val_type_of(row.types[i], profile_, is_newest()).value_or(0);
    Draft<"command_info"> answer;
    const bool all = answer.set<"cmd_id">(n) && answer.set<"cid0">(row.cid[0]) && answer.set<"cid1">(row.cid[1]) &&
                     answer.set<"cid2">(row.cid[2]) && answer.set<"val_type">(Bytes{types}) &&
                     answer.set<"name">(std::string_view{row.name}) &&
                     answer.set<"info">(what_fits(row.info, answer.data_size()));
    return all ? reply.send(answer) : Outcome::unknown;
}

}    // namespace ano::device
