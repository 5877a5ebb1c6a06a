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
    static constexpr std::size_t max_result = 128 * 1024;    // bytes; longer results are ignored: parsing would block the loop

    /// Reads the parameters of a device from the result of a finished job. `prefix`, such as "fc/220/", is put before their
    /// names. Returns the parameters in the result, with their present values.
    std::vector<foxglove::Parameter> learn(const Job& job, const std::string& prefix);
    std::vector<foxglove::Parameter> all() const;
    /// The known parameters among `names`.
    std::vector<foxglove::Parameter> of(const std::vector<std::string>& names) const;
    void forget() { values_.clear(); }

private:
    std::map<std::string, std::string> values_;
};

/// Whether learn() can use the job: it has ended, and has a result with parameters.
bool has_parameters(const Job& job) noexcept;

/// "fc/220/" for the device with this address on this link.
std::string parameter_prefix(std::string_view link, std::uint8_t address);

}    // namespace anogate
