// Prints what a Fast DDS subscriber with types of fastddsgen receives, like listener.cpp: fast_listener DOMAIN INTERFACE-ADDRESS
// TOPIC=TYPE...
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <map>
#include <memory>
#include <mutex>

#include "typesPubSubTypes.h"

#define MESSAGE(package, name) package::msg::dds_::name##_
#define FIELD(name) m.name()
#include "values.hpp"

namespace {

namespace fast = eprosima::fastdds::dds;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;

struct Type {
    std::function<fast::TypeSupport()> support;
    std::function<std::string(fast::DataReader&, fast::SampleInfo&)> take;    // empty: no more samples
};

template <class Message, class Support>
Type type_of() {
    return {[] { return fast::TypeSupport{new Support}; },
            [](fast::DataReader& reader, fast::SampleInfo& info) {
                Message message;
                while (reader.take_next_sample(&message, &info) == ReturnCode::RETCODE_OK) {
                    if (!info.valid_data) continue;
                    Values values;
                    values.add(message);
                    return values.text();
                }
                return std::string{};
            }};
}

const std::map<std::string, Type>& types() {
#define TYPE(package, name) {#name, type_of<MESSAGE(package, name), package::msg::dds_::name##_PubSubType>()},
    static const std::map<std::string, Type> all{EACH_MESSAGE(TYPE)};
    return all;
}

std::mutex output;

class Listener final : public fast::DataReaderListener {
public:
    Listener(std::string topic, const Type& type) : topic_{std::move(topic)}, type_{type} {}

    void on_data_available(fast::DataReader* reader) override {
        fast::SampleInfo info;
        for (std::string text = type_.take(*reader, info); !text.empty(); text = type_.take(*reader, info)) {
            const auto now = std::chrono::system_clock::now().time_since_epoch();
            const long long now_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
            const std::lock_guard lock{output};
            std::printf("%s %lld %lld [%s]\n", topic_.c_str(), now_ns, static_cast<long long>(info.source_timestamp.to_ns()),
                        text.c_str());
        }
    }

private:
    std::string topic_;
    const Type& type_;
};

}    // namespace

int main(int argc, char** argv) {
    std::setvbuf(stdout, nullptr, _IOLBF, 0);
    auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    udp->interfaceWhiteList = {argv[2]};
    fast::DomainParticipantQos participant_qos;
    participant_qos.transport().use_builtin_transports = false;
    participant_qos.transport().user_transports.push_back(udp);
    auto* const participant = fast::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<fast::DomainId_t>(std::atoi(argv[1])), participant_qos);
    if (participant == nullptr) return 1;
    auto* const subscriber = participant->create_subscriber(fast::SUBSCRIBER_QOS_DEFAULT);
    fast::DataReaderQos qos = fast::DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = fast::RELIABLE_RELIABILITY_QOS;
    qos.history().depth = 100;
    for (int i = 3; i < argc; ++i) {
        const std::string argument = argv[i];
        const std::size_t equals = argument.find('=');
        const std::string name = argument.substr(0, equals);
        const Type& type = types().at(argument.substr(equals + 1));
        const fast::TypeSupport support = type.support();
        support.register_type(participant);
        auto* const topic = participant->create_topic("rt" + name, support.get_type_name(), fast::TOPIC_QOS_DEFAULT);
        if (subscriber->create_datareader(topic, qos, new Listener{name, type}, fast::StatusMask::data_available()) == nullptr)
            return 1;
    }
    std::printf("listening\n");
    while (true) ::pause();
}
