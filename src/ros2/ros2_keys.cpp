// The keys of ros2.json.
#include <ano_json/nearest.hpp>
#include <config/key_rows.hpp>
#include <config/values.hpp>
#include <ros/ros_names.hpp>
#include <ros2/ros2_config.hpp>

#include <algorithm>

namespace anogate {
namespace {

using namespace key_rows;
using S = Ros2Settings;
using D = Ros2Device;

constexpr std::uint64_t max_domain = 232;    // above, the port numbers of DDS exceed 65535
constexpr std::uint64_t max_socket = 107, percent = 1000;

constexpr Key<S> setting_rows[] = {
    text<&S::control>("control", 0, max_socket, "the control socket of the gateway (default: the one that anoctl finds)") |
        as("PATH") | by("--control"),
    integer<&S::domain>("domain", 0, max_domain, "the DDS domain, as in ROS_DOMAIN_ID") | by("--domain"),
    words<&S::interfaces>("interfaces", 1, max_interface,
                          "use only these network interfaces, such as lo or eth0 (default: all)") |
        as("NAME"),
    choice<&S::prefix>("prefix", "link|device", "the prefix of topics: the name of the device's link, or of the device"),
    boolean<&S::raw>("raw", "publish every message of the protocol under PREFIX/raw/"),
    boolean<&S::tf>("tf", "publish the transform from PREFIX/odom to PREFIX on /tf"),
};

std::string set_prefix(const KeyFacts& key, Value value, D& device) {
    auto& given = std::get<std::string>(value);
    for (std::size_t begin = 0; begin <= given.size();) {
        const std::size_t end = std::min(given.find('/', begin), given.size());
        const std::string part = given.substr(begin, end - begin);
        if (part != ros_name(part, "x"))
            return must_be(key, in_quotes(given)) +
                   ": letters, digits and single '_', beginning with a letter; '/' separates parts";
        begin = end + 1;
    }
    device.prefix = std::move(given);
    return {};
}

std::string set_accept(const KeyFacts& key, Value value, D& device) {
    auto& names = std::get<std::vector<std::string>>(value);
    for (const std::string& name : names)
        if (std::find(std::begin(input_names), std::end(input_names), name) == std::end(input_names))
            return in_quotes(key.name) + " has " + in_quotes(name) + ", which is not cmd_vel, joy or command" +
                   ano::did_you_mean(name, input_names);
    device.accept = std::move(names);
    return {};
}

constexpr Key<D> device_rows[] = {
    address<&D::address>("address", first_id, last_id, "the hardware id of the device") | needed,
    text<&D::link>("link", 1, max_name, "only while the device is on this link (default: any)") | as("LINK"),
    Key<D>{{.name = "prefix",
            .form = Form::text,
            .help = "the prefix of its topics, such as drone1 or fleet/drone1",
            .min = 1,
            .max = max_name,
            .stands_for = "PREFIX"},
           [](const KeyFacts&, const D& device) { return device.prefix.empty() ? Value{} : Value{device.prefix}; },
           set_prefix},
    Key<D>{{.name = "accept",
            .form = Form::words,
            .help = "the topics by which ROS 2 nodes may control it: cmd_vel, joy, command (default: none)",
            .min = 1,
            .max = max_name,
            .stands_for = "TOPIC"},
           [](const KeyFacts&, const D& device) { return Value{device.accept}; },
           set_accept},
    decimal<&D::hover_throttle>("hover_throttle", percent, 100 * percent,
                                "for cmd_vel: the throttle at which it hovers, in percent; it counts if the mode changes to one "
                                "without height hold"),
};

constexpr VarianceKey variance_rows[] = {
    {"orientation", "rad², of each axis", &Variances::orientation},
    {"angular_velocity", "(rad/s)²", &Variances::angular_velocity},
    {"linear_acceleration", "(m/s²)²", &Variances::linear_acceleration},
    {"position", "m², in odom", &Variances::position},
    {"velocity", "(m/s)², in odom", &Variances::velocity},
    {"magnetic_field", "T²", &Variances::magnetic_field},
    {"temperature", "°C²", &Variances::temperature},
    {"range", "m²", &Variances::range},
    {"fix", "m², east and north", &Variances::fix},
    {"fix_altitude", "m²", &Variances::fix_altitude},
};

}    // namespace

Keys<Ros2Settings> ros2_keys() noexcept { return setting_rows; }
Keys<Ros2Device> ros2_device_keys() noexcept { return device_rows; }
std::span<const VarianceKey> variance_keys() noexcept { return variance_rows; }

}    // namespace anogate
