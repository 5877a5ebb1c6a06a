// The settings that are parameters of the gateway as a device, and the values that hosts wrote. A written value takes precedence
// over the configuration file until the setting is changed there.
//
// Flow:    const auto rows = managed_parameters(of_file);
//          written.write(rows[3], 1, of_file);
//          gateway.change(written.applied(of_file), ...);
#pragma once
#include <ano/schema.hpp>
#include <gateway/settings.hpp>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

/// One row of 0xE2. A double represents every value exactly.
struct ManagedParameter {
    std::string key;     // its path in the configuration: "log/level", "links/fc/enabled"
    std::string name;    // sent to hosts: 1 to 20 bytes, unique
    std::string info;    // description with the unit
    ano::Type type{};
    double min = 0, max = 0;
    std::string link{};    // its link; empty: the gateway
    double (*get)(const Settings& settings, const LinkSettings& link) = nullptr;
    void (*put)(Settings& settings, LinkSettings& link, double value) = nullptr;
    /// The setting as text; if it differs, the file was changed.
    std::string (*words)(const Settings& settings, const LinkSettings& link) = nullptr;

    bool operator==(const ManagedParameter&) const = default;
};

/// Whether the gateway has an id that is valid for a device, not that of hosts.
bool is_device(const GatewaySettings& gateway) noexcept;

/// The beginning of `text`, at most `max_bytes`, without an incomplete character.
std::string cut_text(const std::string& text, std::size_t max_bytes);

/// The parameters of the gateway, then those of each link in order. The id of a parameter is its index.
std::vector<ManagedParameter> managed_parameters(const Settings& of_file);

/// The value in `settings`; 0 if there is no such link.
double value_in(const Settings& settings, const ManagedParameter& row);

/// The source of a value. A default value in the file counts as `defaults`.
enum class ValueFrom : std::uint8_t { defaults, file, parameter };
std::string_view text(ValueFrom from) noexcept;

/// Values that hosts wrote, each with the value in the file at that time.
class WrittenValues {
public:
    /// Stores the value; a value that equals the one in the file is removed instead.
    void write(const ManagedParameter& row, double value, const Settings& of_file);
    /// std::nullopt: the value of the file applies, because none was written or the file was changed afterwards.
    std::optional<double> value(const ManagedParameter& row, const Settings& of_file) const;
    /// The value that applies, and its source.
    std::pair<double, ValueFrom> effective(const ManagedParameter& row, const Settings& of_file) const;
    /// The configuration with the written values. Without an id the gateway is not a device, and no written values apply.
    Settings applied(Settings of_file) const;
    /// Drops the values whose setting in the file was changed afterwards, or whose link was removed. Returns their keys.
    std::vector<std::string> forget_stale(const Settings& of_file);
    bool empty() const noexcept { return values_.empty(); }

    /// As JSON, for a file.
    std::string text() const;
    /// std::nullopt: `text` was not made by text().
    static std::optional<WrittenValues> parse(std::string_view text);

    bool operator==(const WrittenValues&) const = default;

private:
    struct Written {
        double value = 0;
        std::string file;    // ManagedParameter::words() when it was written
        bool operator==(const Written&) const = default;
    };
    std::map<std::string, Written> values_;    // by key
};

}    // namespace anogate
