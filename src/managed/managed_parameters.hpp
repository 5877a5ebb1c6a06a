// What of the configuration is a parameter of the gateway as a device, and the values that were written: they hold behind the
// configuration, until the file says something else.
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

/// One row of 0xE2. Every value is a number that a double has exactly.
struct ManagedParameter {
    std::string key;     // where it stands in the configuration: "log/level", "links/fc/enabled"
    std::string name;    // as hosts read it: 1 to 20 bytes, unlike all others
    std::string info;    // what it is, with its unit
    ano::Type type{};
    double min = 0, max = 0;
    std::string link{};    // whose it is; empty: the gateway's
    double (*get)(const Settings& settings, const LinkSettings& link) = nullptr;
    void (*put)(Settings& settings, LinkSettings& link, double value) = nullptr;
    /// What a change in the file is noticed by.
    std::string (*words)(const Settings& settings, const LinkSettings& link) = nullptr;

    bool operator==(const ManagedParameter&) const = default;
};

/// Whether it has an id that a device may have: not that of hosts.
bool is_device(const GatewaySettings& gateway) noexcept;

/// The beginning of `text` in at most so many bytes, without half a letter.
std::string cut_text(const std::string& text, std::size_t max_bytes);

/// Those of the gateway, then those of each link in its order. An id of a parameter is its place here.
std::vector<ManagedParameter> managed_parameters(const Settings& of_file);

/// What the file says; 0 where there is no such link.
double value_in(const Settings& settings, const ManagedParameter& row);

/// Where a value comes from. A file that says the default is not told from one that says nothing.
enum class ValueFrom : std::uint8_t { defaults, file, parameter };
std::string_view text(ValueFrom from) noexcept;

/// Values that hosts wrote, each with what the file said then.
class WrittenValues {
public:
    /// What the file says anyway is not kept.
    void write(const ManagedParameter& row, double value, const Settings& of_file);
    /// Nothing: the file's holds, since none was written or the file was changed since.
    std::optional<double> value(const ManagedParameter& row, const Settings& of_file) const;
    /// The one that holds, and whose it is.
    std::pair<double, ValueFrom> effective(const ManagedParameter& row, const Settings& of_file) const;
    /// The configuration with what was written. Without an id the gateway is no device, and nothing was.
    Settings applied(Settings of_file) const;
    /// Those whose value in the file was changed since, or whose link is gone, count no more. Their keys.
    std::vector<std::string> forget_stale(const Settings& of_file);
    bool empty() const noexcept { return values_.empty(); }

    /// As JSON, for a file.
    std::string text() const;
    /// Nothing: it is no such text.
    static std::optional<WrittenValues> parse(std::string_view text);

    bool operator==(const WrittenValues&) const = default;

private:
    struct Written {
        double value = 0;
        std::string file;    // ManagedParameter::words() then
        bool operator==(const Written&) const = default;
    };
    std::map<std::string, Written> values_;    // by key
};

}    // namespace anogate
