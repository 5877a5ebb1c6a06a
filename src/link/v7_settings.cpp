#include <config/values.hpp>
#include <link/v7_settings.hpp>
#include <sys/files/read_file.hpp>

#include <system_error>

namespace anogate {
namespace {

constexpr std::uint8_t last_device_number = 199;

bool is_device(std::uint8_t id) noexcept {
    return (id >= 1 && id <= last_device_number) || id == 0xDB || id == 0xDC || id == 0xDD || id == 0xDE || id == 0xE6;
}

}    // namespace

std::optional<V7Source> parse_v7_source(std::string_view text) {
    const std::size_t colon = text.find(':');
    if (colon == text.npos) return std::nullopt;
    const auto ids = parse_addresses(text.substr(0, colon));
    const auto device = parse_address(text.substr(colon + 1));
    if (!ids || !device || !is_device(*device)) return std::nullopt;
    return V7Source{ids->first, ids->last, *device};
}

std::optional<V7Acceleration> parse_v7_acceleration(std::string_view text) {
    if (text == "keep") return V7Acceleration{};
    if (text == "lx") return v7_acc_lx;
    if (text == "flow") return v7_acc_flow;
    if (text == "cmss") return v7_acc_cmss;
    const auto thousandths = parse_thousandths(text);
    if (!thousandths || *thousandths == 0) return std::nullopt;
    return V7Acceleration{V7Acceleration::Unit::per_g, static_cast<double>(*thousandths) / 1000};
}

std::string read_v7_parameters(const std::string& params, std::vector<V7Parameter>& rows) {
    constexpr std::size_t max_size = 256 * 1024;
    rows.clear();
    if (params == "lx") rows = v7_lx_parameters();
    if (params == "tkz") rows = v7_tkz_parameters();
    if (!params.starts_with('/')) return {};
    std::error_code error;
    const std::string text = read_file(params, max_size, error);
    const std::string wrong = error ? error.message() : parse_v7_parameters(text, rows);
    return wrong.empty() ? std::string{} : params + ": " + wrong;
}

V7Settings V7LinkSettings::translation() const {
    V7Settings made;
    made.address = device;
    for (const std::string& source : sources)
        if (const auto parsed = parse_v7_source(source)) made.sources.push_back(*parsed);
    made.v7_address = address;
    if (!acc.empty()) made.acc = parse_v7_acceleration(acc);
    made.temp = temp;
    made.range = range;
    made.layout = layout;
    if (!down.empty()) {
        made.down.reset();
        for (const ByteRange& ids : down)
            for (unsigned id = ids.first; id <= ids.last; ++id) made.down.set(id);
    }
    made.ack = ack;
    made.repeats = repeat;
    if (!read_v7_parameters(params, made.parameters).empty()) made.parameters.clear();    // check_v7() reports it
    made.max_data = max.value_or(role == V7Role::host ? ano::v7::max_len : made.max_data);
    return made;
}

}    // namespace anogate
