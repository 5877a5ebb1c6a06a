// The values of parameters that devices told lately, as the jobs of clients brought them. No I/O.
#pragma once
#include <daemon/foxglove_messages.hpp>
#include <devices/job.hpp>

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
    static constexpr std::size_t max_result = 128 * 1024;    // bytes: a longer one is passed over, for it would keep the loop

    /// What a job that has ended says of the parameters of its device, whose names begin with `prefix`: "fc/220/". Those that it
    /// names, as they are now.
    std::vector<foxglove::Parameter> learn(const Job& job, const std::string& prefix);
    std::vector<foxglove::Parameter> all() const;
    /// Of these names, those that are known.
    std::vector<foxglove::Parameter> of(const std::vector<std::string>& names) const;
    void forget() { values_.clear(); }

private:
    std::map<std::string, std::string> values_;
};

/// Whether learn() would look at it: it has ended, has a result, and that is about parameters.
bool tells_parameters(const Job& job) noexcept;

/// "fc/220/", of the device at this address, by the link that it is heard by.
std::string parameter_prefix(std::string_view link, std::uint8_t address);

}    // namespace anogate
