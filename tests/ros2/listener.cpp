// Prints what a CycloneDDS subscriber with types of idlc receives: listener DOMAIN TOPIC=TYPE[,best_effort]...
//     TOPIC RECEIVED_NS SENT_NS [value, ...]
// The values of all fields in order; one that is not finite is null. Prints "matched TOPIC HASH" when a publisher appears.
#include <dds/dds.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "types.h"

#define MESSAGE(package, name) package##_msg_dds__##name##_
#define FIELD(name) m.name
#include "values.hpp"

namespace {

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
#define TYPE(package, name) {#name, type_of<MESSAGE(package, name)>(package##_msg_dds__##name##__desc)},
    static const std::map<std::string, Type> all{EACH_MESSAGE(TYPE)};
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
