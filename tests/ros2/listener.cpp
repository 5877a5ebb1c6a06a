// Prints what a CycloneDDS subscriber with types of idlc receives: listener DOMAIN TOPIC=TYPE[,best_effort]...
//     TOPIC RECEIVED_NS SENT_NS [value, ...]
// The values of all fields in order; one that is not finite is null. Prints "matched TOPIC HASH" when a publisher appears.
#include <dds/dds.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "types.h"

namespace {

class Values {
public:
    void add(double value) { append(std::isfinite(value) ? format("%.17g", value) : "null"); }
    void add(float value) { append(std::isfinite(value) ? format("%.9g", static_cast<double>(value)) : "null"); }
    void add(bool value) { append(value ? "true" : "false"); }
    void add(const char* text) {
        std::string quoted = "\"";
        for (const char* at = text; *at != 0; ++at) {
            if (*at == '"' || *at == '\\') quoted += '\\';
            quoted += *at;
        }
        append(quoted + '"');
    }
    void add(std::uint8_t value) { append(std::to_string(value)); }
    void add(std::int8_t value) { append(std::to_string(value)); }
    void add(std::uint16_t value) { append(std::to_string(value)); }
    void add(std::int32_t value) { append(std::to_string(value)); }
    void add(std::uint32_t value) { append(std::to_string(value)); }
    template <class T, std::size_t Size>
    void add(const T (&array)[Size]) {
        for (const T& value : array) add(value);
    }
    template <class Sequence>
    auto add(const Sequence& list) -> decltype(list._buffer, void()) {
        for (std::uint32_t i = 0; i < list._length; ++i) add(list._buffer[i]);
    }
    template <class... Parts>
    void all(const Parts&... parts) {
        (add(parts), ...);
    }

    void add(const builtin_interfaces_msg_dds__Time_& m) { all(m.sec, m.nanosec); }
    void add(const std_msgs_msg_dds__Header_& m) { all(m.stamp, m.frame_id); }
    void add(const std_msgs_msg_dds__String_& m) { all(m.data); }
    void add(const geometry_msgs_msg_dds__Vector3_& m) { all(m.x, m.y, m.z); }
    void add(const geometry_msgs_msg_dds__Point_& m) { all(m.x, m.y, m.z); }
    void add(const geometry_msgs_msg_dds__Quaternion_& m) { all(m.x, m.y, m.z, m.w); }
    void add(const geometry_msgs_msg_dds__Vector3Stamped_& m) { all(m.header, m.vector); }
    void add(const geometry_msgs_msg_dds__PointStamped_& m) { all(m.header, m.point); }
    void add(const geometry_msgs_msg_dds__QuaternionStamped_& m) { all(m.header, m.quaternion); }
    void add(const geometry_msgs_msg_dds__Pose_& m) { all(m.position, m.orientation); }
    void add(const geometry_msgs_msg_dds__Twist_& m) { all(m.linear, m.angular); }
    void add(const geometry_msgs_msg_dds__PoseWithCovariance_& m) { all(m.pose, m.covariance); }
    void add(const geometry_msgs_msg_dds__TwistWithCovariance_& m) { all(m.twist, m.covariance); }
    void add(const geometry_msgs_msg_dds__Transform_& m) { all(m.translation, m.rotation); }
    void add(const geometry_msgs_msg_dds__TransformStamped_& m) { all(m.header, m.child_frame_id, m.transform); }
    void add(const tf2_msgs_msg_dds__TFMessage_& m) { all(m.transforms); }
    void add(const nav_msgs_msg_dds__Odometry_& m) { all(m.header, m.child_frame_id, m.pose, m.twist); }
    void add(const sensor_msgs_msg_dds__Imu_& m) {
        all(m.header, m.orientation, m.orientation_covariance, m.angular_velocity, m.angular_velocity_covariance,
            m.linear_acceleration, m.linear_acceleration_covariance);
    }
    void add(const sensor_msgs_msg_dds__MagneticField_& m) { all(m.header, m.magnetic_field, m.magnetic_field_covariance); }
    void add(const sensor_msgs_msg_dds__Temperature_& m) { all(m.header, m.temperature, m.variance); }
    void add(const sensor_msgs_msg_dds__NavSatStatus_& m) { all(m.status, m.service); }
    void add(const sensor_msgs_msg_dds__NavSatFix_& m) {
        all(m.header, m.status, m.latitude, m.longitude, m.altitude, m.position_covariance, m.position_covariance_type);
    }
    void add(const sensor_msgs_msg_dds__Range_& m) {
        all(m.header, m.radiation_type, m.field_of_view, m.min_range, m.max_range, m.range, m.variance);
    }
    void add(const sensor_msgs_msg_dds__PointField_& m) { all(m.name, m.offset, m.datatype, m.count); }
    void add(const sensor_msgs_msg_dds__PointCloud2_& m) {
        all(m.header, m.height, m.width, m.fields, m.is_bigendian, m.point_step, m.row_step, m.data, m.is_dense);
    }
    void add(const sensor_msgs_msg_dds__Image_& m) {
        all(m.header, m.height, m.width, m.encoding, m.is_bigendian, m.step, m.data);
    }
    void add(const sensor_msgs_msg_dds__BatteryState_& m) {
        all(m.header, m.voltage, m.temperature, m.current, m.charge, m.capacity, m.design_capacity, m.percentage,
            m.power_supply_status, m.power_supply_health, m.power_supply_technology, m.present, m.cell_voltage,
            m.cell_temperature, m.location, m.serial_number);
    }
    void add(const sensor_msgs_msg_dds__Joy_& m) { all(m.header, m.axes, m.buttons); }
    void add(const rcl_interfaces_msg_dds__Log_& m) { all(m.stamp, m.level, m.name, m.msg, m.file, m.function, m.line); }
    void add(const diagnostic_msgs_msg_dds__KeyValue_& m) { all(m.key, m.value); }
    void add(const diagnostic_msgs_msg_dds__DiagnosticStatus_& m) { all(m.level, m.name, m.message, m.hardware_id, m.values); }
    void add(const diagnostic_msgs_msg_dds__DiagnosticArray_& m) { all(m.header, m.status); }

    const std::string& text() const { return text_; }

private:
    static std::string format(const char* how, double value) {
        char buffer[40];
        std::snprintf(buffer, sizeof buffer, how, value);
        return buffer;
    }
    void append(const std::string& value) { text_ += (text_.empty() ? "" : ", ") + value; }

    std::string text_;
};

struct Type {
    const dds_topic_descriptor_t* descriptor;
    std::function<std::string(const void*)> text;
};

template <class Message>
Type type_of(const dds_topic_descriptor_t& descriptor) {
    return {&descriptor, [](const void* sample) {
                Values values;
                values.add(*static_cast<const Message*>(sample));
                return values.text();
            }};
}

const std::map<std::string, Type>& types() {
    static const std::map<std::string, Type> all{
        {"Imu", type_of<sensor_msgs_msg_dds__Imu_>(sensor_msgs_msg_dds__Imu__desc)},
        {"MagneticField", type_of<sensor_msgs_msg_dds__MagneticField_>(sensor_msgs_msg_dds__MagneticField__desc)},
        {"Temperature", type_of<sensor_msgs_msg_dds__Temperature_>(sensor_msgs_msg_dds__Temperature__desc)},
        {"QuaternionStamped", type_of<geometry_msgs_msg_dds__QuaternionStamped_>(geometry_msgs_msg_dds__QuaternionStamped__desc)},
        {"Vector3Stamped", type_of<geometry_msgs_msg_dds__Vector3Stamped_>(geometry_msgs_msg_dds__Vector3Stamped__desc)},
        {"PointStamped", type_of<geometry_msgs_msg_dds__PointStamped_>(geometry_msgs_msg_dds__PointStamped__desc)},
        {"Odometry", type_of<nav_msgs_msg_dds__Odometry_>(nav_msgs_msg_dds__Odometry__desc)},
        {"BatteryState", type_of<sensor_msgs_msg_dds__BatteryState_>(sensor_msgs_msg_dds__BatteryState__desc)},
        {"NavSatFix", type_of<sensor_msgs_msg_dds__NavSatFix_>(sensor_msgs_msg_dds__NavSatFix__desc)},
        {"Range", type_of<sensor_msgs_msg_dds__Range_>(sensor_msgs_msg_dds__Range__desc)},
        {"PointCloud2", type_of<sensor_msgs_msg_dds__PointCloud2_>(sensor_msgs_msg_dds__PointCloud2__desc)},
        {"Image", type_of<sensor_msgs_msg_dds__Image_>(sensor_msgs_msg_dds__Image__desc)},
        {"Joy", type_of<sensor_msgs_msg_dds__Joy_>(sensor_msgs_msg_dds__Joy__desc)},
        {"String", type_of<std_msgs_msg_dds__String_>(std_msgs_msg_dds__String__desc)},
        {"Log", type_of<rcl_interfaces_msg_dds__Log_>(rcl_interfaces_msg_dds__Log__desc)},
        {"DiagnosticArray", type_of<diagnostic_msgs_msg_dds__DiagnosticArray_>(diagnostic_msgs_msg_dds__DiagnosticArray__desc)},
        {"TFMessage", type_of<tf2_msgs_msg_dds__TFMessage_>(tf2_msgs_msg_dds__TFMessage__desc)},
    };
    return all;
}

struct Reader {
    std::string topic;
    const Type* type = nullptr;
    dds_entity_t entity = 0;
    bool is_matched = false;
};

void show_match(Reader& reader) {
    dds_instance_handle_t writer = 0;
    if (reader.is_matched || dds_get_matched_publications(reader.entity, &writer, 1) <= 0) return;
    dds_builtintopic_endpoint_t* const endpoint = dds_get_matched_publication_data(reader.entity, writer);
    if (endpoint == nullptr) return;
    void* data = nullptr;
    std::size_t size = 0;
    std::string hash;
    if (dds_qget_userdata(endpoint->qos, &data, &size) && data != nullptr) hash.assign(static_cast<const char*>(data), size);
    dds_free(data);
    dds_builtintopic_free_endpoint(endpoint);
    reader.is_matched = true;
    std::printf("matched %s %s\n", reader.topic.c_str(), hash.c_str());
}

void show_samples(Reader& reader) {
    constexpr std::size_t most = 16;
    void* samples[most] = {};
    dds_sample_info_t infos[most];
    const dds_return_t count = dds_take(reader.entity, samples, infos, most, most);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const long long now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
    for (dds_return_t i = 0; i < count; ++i)
        if (infos[i].valid_data)
            std::printf("%s %lld %lld [%s]\n", reader.topic.c_str(), now_ns, static_cast<long long>(infos[i].source_timestamp),
                        reader.type->text(samples[i]).c_str());
    if (count > 0) dds_return_loan(reader.entity, samples, count);
}

Reader reader_of(dds_entity_t participant, std::string argument) {
    Reader reader;
    const std::string best_effort = ",best_effort";
    const bool is_best_effort = argument.ends_with(best_effort);
    if (is_best_effort) argument.resize(argument.size() - best_effort.size());
    const std::size_t equals = argument.find('=');
    reader.topic = argument.substr(0, equals);
    const auto type = types().find(argument.substr(equals + 1));
    if (type == types().end()) std::abort();
    reader.type = &type->second;
    dds_qos_t* const qos = dds_create_qos();
    dds_qset_reliability(qos, is_best_effort ? DDS_RELIABILITY_BEST_EFFORT : DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 100);
    const dds_entity_t topic = dds_create_topic(participant, reader.type->descriptor, ("rt" + reader.topic).c_str(), qos,
                                                nullptr);
    reader.entity = dds_create_reader(participant, topic, qos, nullptr);
    dds_delete_qos(qos);
    if (reader.entity < 0) std::abort();
    return reader;
}

}    // namespace

int main(int argc, char** argv) {
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    const dds_entity_t participant = dds_create_participant(static_cast<dds_domainid_t>(std::atoi(argv[1])), nullptr, nullptr);
    if (participant < 0) return 1;
    std::vector<Reader> readers;
    const dds_entity_t waits = dds_create_waitset(participant);
    for (int i = 2; i < argc; ++i) {
        readers.push_back(reader_of(participant, argv[i]));
        dds_set_status_mask(readers.back().entity, DDS_DATA_AVAILABLE_STATUS | DDS_SUBSCRIPTION_MATCHED_STATUS);
        dds_waitset_attach(waits, readers.back().entity, 0);
    }
    std::printf("listening\n");
    while (true) {
        dds_waitset_wait(waits, nullptr, 0, DDS_MSECS(100));
        for (Reader& reader : readers) {
            std::uint32_t status = 0;
            dds_take_status(reader.entity, &status, DDS_SUBSCRIPTION_MATCHED_STATUS);
            show_match(reader);
            show_samples(reader);
        }
    }
}
