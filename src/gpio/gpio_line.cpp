#include <gpio/gpio_line.hpp>
#include <sys/errors.hpp>

#include <gpiod.hpp>

#include <fcntl.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <vector>

namespace anogate {
namespace {

namespace fs = std::filesystem;

// The request for a line, the same for both versions of libgpiod.
struct LineRequest {
    std::string consumer;    // our name in `gpioinfo`
    bool output;
    bool active;
    bool active_low;
    GpioBias bias;
};

struct LineFacts {
    std::string name;
    std::string consumer;    // the program that holds it; empty: unknown
};

}    // namespace

// Versions of libgpiod: 1.6 has one header, 2.x several. All functions throw, mostly std::system_error.
#if __has_include(<gpiodcxx/chip.hpp>)

namespace {

struct Chip {
    explicit Chip(const fs::path& path) : chip{path}, info{chip.get_info()} {}
    std::string label() const { return info.label(); }
    std::size_t lines() const { return info.num_lines(); }
    std::optional<unsigned> find(const std::string& name) const {
        const int offset = chip.get_line_offset_from_name(name);
        return offset < 0 ? std::nullopt : std::optional{static_cast<unsigned>(offset)};
    }
    LineFacts facts(unsigned offset) const {
        const gpiod::line_info line = chip.get_line_info(offset);
        return {line.name(), line.used() ? line.consumer() : std::string{}};
    }

    gpiod::chip chip;
    gpiod::chip_info info;
};

gpiod::line::bias bias_of(GpioBias bias) {
    switch (bias) {
    case GpioBias::disabled: return gpiod::line::bias::DISABLED;
    case GpioBias::pull_up: return gpiod::line::bias::PULL_UP;
    case GpioBias::pull_down: return gpiod::line::bias::PULL_DOWN;
    default: return gpiod::line::bias::AS_IS;
    }
}

gpiod::line::value value_of(bool active) { return active ? gpiod::line::value::ACTIVE : gpiod::line::value::INACTIVE; }

gpiod::line_settings settings_of(const LineRequest& want) {
    gpiod::line_settings settings;
    settings.set_active_low(want.active_low);
    settings.set_bias(bias_of(want.bias));
    if (want.output) {
        settings.set_direction(gpiod::line::direction::OUTPUT);
        settings.set_output_value(value_of(want.active));
    } else {
        settings.set_direction(gpiod::line::direction::INPUT);
        settings.set_edge_detection(gpiod::line::edge::BOTH);
    }
    return settings;
}

}    // namespace

struct GpioLine::Request {
    Request(Chip& chip, unsigned line, const LineRequest& want)
        : offset{line},
          request{
              chip.chip.prepare_request().set_consumer(want.consumer).add_line_settings(line, settings_of(want)).do_request()} {}
    void set(bool active) { request.set_value(offset, value_of(active)); }
    bool value() { return request.get_value(offset) == gpiod::line::value::ACTIVE; }
    int descriptor() const { return request.fd(); }
    std::size_t read_edges() { return request.read_edge_events(buffer); }

    gpiod::line::offset offset;
    gpiod::line_request request;
    gpiod::edge_event_buffer buffer{16};
};

#else

namespace {

struct Chip {
    explicit Chip(const fs::path& path) : chip{path.string(), gpiod::chip::OPEN_BY_PATH} {}
    std::string label() const { return chip.label(); }
    std::size_t lines() const { return chip.num_lines(); }
    std::optional<unsigned> find(const std::string& name) const {
        const gpiod::line line = chip.find_line(name);
        return line ? std::optional{line.offset()} : std::nullopt;
    }
    LineFacts facts(unsigned offset) const {
        const gpiod::line line = chip.get_line(offset);
        return {line.name(), line.is_used() ? line.consumer() : std::string{}};
    }

    gpiod::chip chip;
};

std::bitset<32> flags_of(const LineRequest& want) {
    std::bitset<32> flags;
    if (want.active_low) flags |= gpiod::line_request::FLAG_ACTIVE_LOW;
    if (want.bias == GpioBias::disabled) flags |= gpiod::line_request::FLAG_BIAS_DISABLE;
    if (want.bias == GpioBias::pull_up) flags |= gpiod::line_request::FLAG_BIAS_PULL_UP;
    if (want.bias == GpioBias::pull_down) flags |= gpiod::line_request::FLAG_BIAS_PULL_DOWN;
    return flags;
}

}    // namespace

struct GpioLine::Request {
    Request(Chip& chip, unsigned offset, const LineRequest& want) : line{chip.chip.get_line(offset)} {
        line.request({want.consumer, want.output ? gpiod::line_request::DIRECTION_OUTPUT : gpiod::line_request::EVENT_BOTH_EDGES,
                      flags_of(want)},
                     want.active);
    }
    void set(bool active) { line.set_value(active); }
    bool value() { return line.get_value() != 0; }
    int descriptor() const { return line.event_get_fd(); }
    std::size_t read_edges() { return line.event_read_multiple().size(); }

    gpiod::line line;    // keeps its chip open
};

#endif

namespace {

int error_of(const std::exception& exception) {
    const auto* error = dynamic_cast<const std::system_error*>(&exception);
    return error ? error->code().value() : EINVAL;    // 2.x has other exceptions for this error
}

/// The paths of all chips in numeric order: gpiochip9 before gpiochip10.
std::vector<fs::path> chip_paths() {
    std::vector<fs::path> paths;
    std::error_code ec;
    for (fs::directory_iterator devices{"/dev", ec}, end; !ec && devices != end; devices.increment(ec))
        if (devices->path().filename().native().starts_with("gpiochip")) paths.push_back(devices->path());
    std::sort(paths.begin(), paths.end(), [](const fs::path& a, const fs::path& b) {
        return std::pair{a.native().size(), a.native()} < std::pair{b.native().size(), b.native()};
    });
    return paths;
}

std::optional<std::uint64_t> number(const std::string& line) {
    std::uint64_t value = 0;
    const auto [end, bad] = std::from_chars(line.data(), line.data() + line.size(), value);
    if (bad != std::errc{} || end != line.data() + line.size()) return std::nullopt;
    return value;
}

std::string not_allowed(const fs::path& path) {
    return "permission denied for " + path.string() + " (the user must be in the group of the device, usually gpio)";
}

// The chip and line for the settings, or the reason why there is none.
struct Place {
    std::optional<Chip> chip;
    std::string chip_name;
    unsigned offset = 0;
    std::string error;
    std::string doubt;    // the reason why a chip could not be searched
};

// Searches one chip. True: the search is over, with success or an error.
bool is_at(const fs::path& path, const GpioSettings& settings, bool by_label, Place& place) {
    try {
        Chip chip{path};
        if (by_label && chip.label() != settings.chip) return false;
        if (const auto offset = number(settings.line)) {
            if (*offset >= chip.lines()) {
                place.error = path.filename().string() + " has lines 0 to " + std::to_string(chip.lines() - 1) + ", not " +
                              settings.line;
                return true;
            }
            place.offset = static_cast<unsigned>(*offset);
        } else if (const auto found = chip.find(settings.line)) {
            place.offset = *found;
        } else {
            return false;
        }
        place.chip.emplace(std::move(chip));
        place.chip_name = path.filename();
        return true;
    } catch (const std::exception& e) {
        const int error = error_of(e);
        if (error == EACCES || error == EPERM) place.doubt = not_allowed(path);
        else if (error != ENOENT && error != ENODEV && error != ENXIO) place.doubt = error_text(path.string(), error);
        return false;
    }
}

Place find(const GpioSettings& settings) {
    Place place;
    const auto try_each = [&](const std::vector<fs::path>& paths, bool by_label) {
        return std::any_of(paths.begin(), paths.end(), [&](const fs::path& p) { return is_at(p, settings, by_label, place); });
    };
    const bool any_chip = settings.chip.empty();
    const fs::path named = fs::path{"/dev"} / settings.chip;    // `chip` itself if it is an absolute path
    std::error_code ec;
    const bool by_label = !any_chip && !fs::exists(named, ec);
    if (try_each(any_chip || by_label ? chip_paths() : std::vector{named}, by_label)) return place;
    if (!place.doubt.empty()) place.error = (any_chip ? "" : settings.chip + " ") + "line " + settings.line + ": " + place.doubt;
    else if (any_chip) place.error = "no GPIO chip has a line " + settings.line;
    else if (by_label) place.error = settings.chip + " line " + settings.line + ": the chip was not found";
    else place.error = settings.chip + " has no line " + settings.line;
    return place;
}

std::string format_line(const std::string& chip, unsigned offset, const LineFacts& facts) {
    return chip + " line " + std::to_string(offset) + (facts.name.empty() ? "" : " (" + facts.name + ")");
}

std::string why_not(const Place& place, int error) {
    LineFacts facts;
    try {
        facts = place.chip->facts(place.offset);
    } catch (const std::exception&) {    // the facts are optional
    }
    const std::string line = format_line(place.chip_name, place.offset, facts);
    if (error == EBUSY)
        return line + " is in use by " + (facts.consumer.empty() ? "another program or the kernel" : facts.consumer);
    if (error == EACCES || error == EPERM) return line + ": no permission";
    return error_text(line, error);
}

std::string consumer(GpioUse use) {
    switch (use) {
    case GpioUse::link_up: return "anogate link_up";
    case GpioUse::activity: return "anogate activity";
    case GpioUse::power: return "anogate power";
    case GpioUse::reset: return "anogate reset";
    case GpioUse::inhibit: return "anogate inhibit";
    case GpioUse::rs485: return "anogate rs485";
    }
    return "anogate";
}

}    // namespace

GpioLine::GpioLine(std::unique_ptr<Request> request, std::string chip, unsigned offset, std::string name)
    : request_{std::move(request)}, chip_{std::move(chip)}, offset_{offset}, name_{std::move(name)} {}

GpioLine::~GpioLine() = default;

Expected<std::unique_ptr<GpioLine>> GpioLine::open(const GpioSettings& settings, bool output, bool active) {
    Place place = find(settings);
    if (!place.error.empty()) return Unexpected{std::move(place.error)};
    const LineRequest want{consumer(settings.use), output, active, settings.active_low, settings.bias};
    try {
        auto request = std::make_unique<Request>(*place.chip, place.offset, want);
        std::string name = place.chip->facts(place.offset).name;
        return std::unique_ptr<GpioLine>{new GpioLine{std::move(request), place.chip_name, place.offset, std::move(name)}};
    } catch (const std::exception& e) {
        return Unexpected{why_not(place, error_of(e))};
    }
}

Expected<std::unique_ptr<GpioLine>> GpioLine::open_input(const GpioSettings& settings) { return open(settings, false, false); }

Expected<std::unique_ptr<GpioLine>> GpioLine::open_output(const GpioSettings& settings, bool active) {
    return open(settings, true, active);
}

bool GpioLine::set(bool active) noexcept {
    try {
        request_->set(active);
        return true;
    } catch (const std::exception&) {
        return false;
    }
}

std::optional<bool> GpioLine::value() noexcept {
    try {
        return request_->value();
    } catch (const std::exception&) {
        return std::nullopt;
    }
}

UniqueFd GpioLine::edge_descriptor() const { return UniqueFd{::fcntl(request_->descriptor(), F_DUPFD_CLOEXEC, 0)}; }

std::optional<unsigned> GpioLine::read_edges() noexcept {
    try {
        return static_cast<unsigned>(request_->read_edges());
    } catch (const std::exception& e) {
        const int error = error_of(e);
        return error == EAGAIN || error == EINTR ? std::optional{0u} : std::nullopt;
    }
}

}    // namespace anogate
