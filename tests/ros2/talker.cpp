// A CycloneDDS publisher with types of idlc: talker DOMAIN. Reads commands from its input:
//     twist TOPIC X Y Z YAW        joy TOPIC AXES VALUE        string TOPIC TEXT        crowd COUNT (further participants)
// The first command for a topic waits for a subscriber. Prints "sent" for each.
#include <dds/dds.h>

#include <cstdio>
#include <cstdlib>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "types.h"

namespace {

class Talker {
public:
    explicit Talker(int domain)
        : domain_{static_cast<dds_domainid_t>(domain)}, participant_{dds_create_participant(domain_, nullptr, nullptr)} {
        if (participant_ < 0) std::abort();
    }

    void run(const std::string& line) {
        std::istringstream words{line};
        std::string what, topic;
        words >> what >> topic;
        if (what == "crowd") {
            for (int i = std::atoi(topic.c_str()); i > 0; --i) dds_create_participant(domain_, nullptr, nullptr);
        } else if (what == "twist") {
            geometry_msgs_msg_dds__Twist_ m{};
            for (double* const value : {&m.linear.x, &m.linear.y, &m.linear.z, &m.angular.z}) {
                std::string word;    // a stream does not read "nan"
                words >> word;
                *value = std::atof(word.c_str());
            }
            write(topic, geometry_msgs_msg_dds__Twist__desc, &m);
        } else if (what == "joy") {
            std::size_t axes = 0;
            float value = 0;
            words >> axes >> value;
            std::vector<float> values(axes, value);
            char frame[] = "stick";
            sensor_msgs_msg_dds__Joy_ m{};
            m.header.frame_id = frame;
            m.axes = {static_cast<std::uint32_t>(axes), static_cast<std::uint32_t>(axes), values.data(), false};
            write(topic, sensor_msgs_msg_dds__Joy__desc, &m);
        } else if (what == "string") {
            std::string text;
            std::getline(words >> std::ws, text);
            std_msgs_msg_dds__String_ m{text.data()};
            write(topic, std_msgs_msg_dds__String__desc, &m);
        }
    }

private:
    void write(const std::string& name, const dds_topic_descriptor_t& type, const void* message) {
        dds_entity_t& writer = writers_[name];
        if (writer == 0) {
            dds_qos_t* const qos = dds_create_qos();
            dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
            const dds_entity_t topic = dds_create_topic(participant_, &type, ("rt" + name).c_str(), qos, nullptr);
            writer = dds_create_writer(participant_, topic, qos, nullptr);
            dds_delete_qos(qos);
            dds_instance_handle_t reader = 0;
            for (int tries = 0; tries < 3000 && dds_get_matched_subscriptions(writer, &reader, 1) <= 0; ++tries)
                dds_sleepfor(DDS_MSECS(10));
        }
        dds_write(writer, message);
        std::printf("sent\n");
        std::fflush(stdout);
    }

    dds_domainid_t domain_;
    dds_entity_t participant_;
    std::map<std::string, dds_entity_t> writers_;
};

}    // namespace

int main(int, char** argv) {
    Talker talker{std::atoi(argv[1])};
    for (std::string line; std::getline(std::cin, line);) talker.run(line);
}
