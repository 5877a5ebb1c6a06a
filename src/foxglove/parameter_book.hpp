// The latest known values of device parameters, from the results of jobs. No I/O.
#pragma once
#include <devices/job.hpp>
#include <foxglove/foxglove_messages.hpp>

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class ParameterBook {
public:
    static constexpr std::size_t max_values = 4096;
    static constexpr std::size_t max_result = 128 * 1024;    // bytes: a longer one is ignored, since it would keep the loop busy

    /// Takes the parameters of its device from the result of a job that has ended. Their names here begin with `prefix`: "fc/220/". Returns
    /// those that the result contains, with their present values.
    std::vector<foxglove::Parameter> learn(const Job& job, const std::string& prefix);
    std::vector<foxglove::Parameter> all() const;
    /// Those of these names that are known.
    std::vector<foxglove::Parameter> of(const std::vector<std::string>& names) const;
    void forget() { values_.clear(); }

private:
    std::map<std::string, std::string> values_;
};

/// Whether learn() has a use for it: it has ended, and has a result about parameters.
bool tells_parameters(const Job& job) noexcept;

/// "fc/220/" for the device with this address on this link.
std::string parameter_prefix(std::string_view link, std::uint8_t address);

}    // namespace anogate
