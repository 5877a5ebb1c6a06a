// The only file that knows Fast DDS (2.9; its interface changes in version 3). Messages are passed as finished CDR bytes, so no generated
// code is needed. Only UDP over IPv4: segments of shared memory would stay behind after a kill.
#include <ros2/bus.hpp>
#include <ros2/rtps_message.hpp>
#include <ros2/type_hash.hpp>

#include <fastdds/rtps/transport/ChainingTransport.h>
#include <fastdds/rtps/transport/ChainingTransportDescriptor.h>
#include <fastdds/rtps/transport/TransportReceiverInterface.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/log/Log.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/Topic.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstring>
#include <exception>
#include <map>
#include <mutex>
#include <thread>
#include <utility>

namespace anogate {
namespace {

namespace dds = eprosima::fastdds::dds;
namespace rtps = eprosima::fastrtps::rtps;
using eprosima::fastrtps::types::ReturnCode_t;

constexpr std::int32_t kept = 10;                   // samples of a topic
constexpr std::uint32_t usual_size = 512;           // of a message; a larger one makes its buffer grow
constexpr std::size_t max_received = 64 * 1024;     // bytes of a message from others
constexpr std::size_t large_message = 32 * 1024;    // above, the message is sent in fragments by another thread
const eprosima::fastrtps::Duration_t announcement{0, 500'000'000}, lease{10, 0}, heartbeat{0, 200'000'000};
// A request to repeat a message that was sent less than this ago is ignored. With 0, the default, every message wakes a thread of the
// library only to note that, and both threads wait for each other's locks; with 20 ms, fewer lost messages arrive in time.
const eprosima::fastrtps::Duration_t before_repeats{0, 5'000'000};

// A message as CDR bytes, with the four bytes of the encapsulation.
class RawType final : public dds::TopicDataType {
public:
    explicit RawType(const std::string& name) {
        setName(name.c_str());
        m_typeSize = usual_size;
        m_isGetKeyDefined = false;
        auto_fill_type_object(false);
        auto_fill_type_information(false);
    }
    bool serialize(void* data, rtps::SerializedPayload_t* payload) override {
        const auto& cdr = *static_cast<const std::string_view*>(data);
        if (cdr.size() > payload->max_size) return false;
        payload->encapsulation = CDR_LE;
        payload->length = static_cast<std::uint32_t>(cdr.size());
        std::memcpy(payload->data, cdr.data(), cdr.size());
        return true;
    }
    bool deserialize(rtps::SerializedPayload_t* payload, void* data) override {
        if (payload->length > max_received) return false;
        static_cast<std::string*>(data)->assign(reinterpret_cast<const char*>(payload->data), payload->length);
        return true;
    }
    std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
        return [data] { return static_cast<std::uint32_t>(static_cast<const std::string_view*>(data)->size()); };
    }
    void* createData() override { return new std::string; }
    void deleteData(void* data) override { delete static_cast<std::string*>(data); }
    bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
};

struct Spec {
    std::string name, type, hash;
    Reliability reliability{};
    bool is_large = false;
    bool is_used = true;    // false: withdrawn
};

class WriterListener final : public dds::DataWriterListener {
public:
    void on_publication_matched(dds::DataWriter*, const dds::PublicationMatchedStatus& status) override {
        readers_ = status.current_count;
    }
    bool has_readers() const noexcept { return readers_ > 0; }

private:
    std::atomic<std::int32_t> readers_{0};
};

std::uint64_t nanoseconds(const rtps::Time_t& time) { return static_cast<std::uint64_t>(time.to_ns()); }

class ReaderListener final : public dds::DataReaderListener {
public:
    ReaderListener(std::size_t number, const BusEvents& events) : number_{number}, events_{events} {}

    void on_data_available(dds::DataReader* reader) override {
        Sample sample;
        dds::SampleInfo info;
        while (reader->take_next_sample(&sample.cdr, &info) == ReturnCode_t::RETCODE_OK) {
            if (!info.valid_data) continue;
            sample.topic = number_;
            const rtps::GUID_t guid = info.sample_identity.writer_guid();
            std::copy_n(guid.guidPrefix.value, sample.publisher.size() - 4, sample.publisher.begin());
            std::copy_n(guid.entityId.value, 4, sample.publisher.end() - 4);
            sample.sent_ns = nanoseconds(info.source_timestamp);
            sample.received_ns = nanoseconds(info.reception_timestamp);
            sample.received_at = ano::Clock::now();
            events_.sample(std::exchange(sample, {}));
        }
    }

private:
    std::size_t number_;
    const BusEvents& events_;
};

template <class Qos>
void set_common(Qos& qos, const Spec& spec) {
    qos.reliability().kind = spec.reliability == Reliability::reliable ? dds::RELIABLE_RELIABILITY_QOS
                                                                       : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind = dds::VOLATILE_DURABILITY_QOS;
    qos.history().kind = dds::KEEP_LAST_HISTORY_QOS;
    qos.history().depth = kept;
    qos.data_sharing().off();
    qos.endpoint().history_memory_policy = rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    qos.resource_limits().max_samples = kept;
    qos.resource_limits().max_instances = 1;
    qos.resource_limits().max_samples_per_instance = kept;
    qos.resource_limits().allocated_samples = 1;
    const std::string hash = "typehash=" + spec.hash + ';';
    qos.user_data().setValue({hash.begin(), hash.end()});
}

// UDP, whose datagrams are checked before the library reads them.
class CheckedTransport final : public eprosima::fastdds::rtps::ChainingTransport {
public:
    using ChainingTransport::ChainingTransport;
    eprosima::fastdds::rtps::TransportDescriptorInterface* get_configuration() override {
        return low_level_transport_->get_configuration();
    }
    bool send(rtps::SenderResource* sender, const rtps::octet* data, std::uint32_t size,
              eprosima::fastdds::rtps::LocatorsIterator* begin, eprosima::fastdds::rtps::LocatorsIterator* end,
              const std::chrono::steady_clock::time_point& timeout) override {
        return sender->send(data, size, begin, end, timeout);
    }
    void receive(eprosima::fastdds::rtps::TransportReceiverInterface* receiver, const rtps::octet* data, std::uint32_t size,
                 const rtps::Locator_t& local, const rtps::Locator_t& remote) override {
        if (const std::size_t valid = valid_part({data, size}); valid > 0)
            receiver->OnDataReceived(data, static_cast<std::uint32_t>(valid), local, remote);
    }
};

struct CheckedTransportDescriptor final : eprosima::fastdds::rtps::ChainingTransportDescriptor {
    using eprosima::fastdds::rtps::ChainingTransportDescriptor::ChainingTransportDescriptor;
    eprosima::fastdds::rtps::TransportInterface* create_transport() const override { return new CheckedTransport{*this}; }
};

// One participant with everything that belongs to it.
class Session {
public:
    Session(std::uint32_t domain, const std::vector<std::string>& addresses) {
        auto udp = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
        udp->interfaceWhiteList = addresses;
        udp->non_blocking_send = true;
        dds::DomainParticipantQos qos;
        qos.name("anogate_ros2");
        qos.transport().use_builtin_transports = false;
        qos.transport().user_transports.push_back(std::make_shared<CheckedTransportDescriptor>(udp));
        auto& discovery = qos.wire_protocol().builtin.discovery_config;
        discovery.leaseDuration = lease;
        discovery.leaseDuration_announcementperiod = announcement;
        participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(domain, qos);
        if (participant_ == nullptr) return;
        publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
        subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
    }
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;
    // May take long if an address of the participant is gone.
    ~Session() {
        if (participant_ == nullptr) return;
        participant_->delete_contained_entities();
        dds::DomainParticipantFactory::get_instance()->delete_participant(participant_);
    }

    bool is_good() const noexcept { return publisher_ != nullptr && subscriber_ != nullptr; }

    void add_writer(std::size_t number, const Spec& spec) {
        dds::DataWriterQos qos = dds::DATAWRITER_QOS_DEFAULT;
        set_common(qos, spec);
        qos.publish_mode().kind = spec.is_large ? dds::ASYNCHRONOUS_PUBLISH_MODE : dds::SYNCHRONOUS_PUBLISH_MODE;
        qos.reliable_writer_qos().times.heartbeatPeriod = heartbeat;
        qos.reliable_writer_qos().times.nackSupressionDuration = before_repeats;
        auto writer = std::make_unique<Writer>();
        if (dds::Topic* topic = topic_of(spec))
            writer->writer = publisher_->create_datawriter(topic, qos, &writer->listener, dds::StatusMask::publication_matched());
        writers_[number] = std::move(writer);
    }
    void add_reader(std::size_t number, const Spec& spec, const BusEvents& events) {
        dds::DataReaderQos qos = dds::DATAREADER_QOS_DEFAULT;
        set_common(qos, spec);
        listeners_.push_back(std::make_unique<ReaderListener>(number, events));
        if (dds::Topic* topic = topic_of(spec))
            subscriber_->create_datareader(topic, qos, listeners_.back().get(), dds::StatusMask::data_available());
    }
    void remove_writer(std::size_t number) {
        const auto found = writers_.find(number);
        if (found == writers_.end()) return;
        if (found->second->writer != nullptr) publisher_->delete_datawriter(found->second->writer);
        writers_.erase(found);
    }
    bool has_readers(std::size_t number) const {
        const auto found = writers_.find(number);
        return found != writers_.end() && found->second->listener.has_readers();
    }
    void write(std::size_t number, std::string_view cdr) {
        const auto found = writers_.find(number);
        if (found != writers_.end() && found->second->writer != nullptr) found->second->writer->write(&cdr);
    }

private:
    struct Writer {
        WriterListener listener;
        dds::DataWriter* writer = nullptr;
    };
    // Topics with the same name and type are one.
    dds::Topic* topic_of(const Spec& spec) {
        if (auto* known = dynamic_cast<dds::Topic*>(participant_->lookup_topicdescription(spec.name))) return known;
        const dds::TypeSupport type{new RawType{spec.type}};
        type.register_type(participant_);
        return participant_->create_topic(spec.name, spec.type, dds::TOPIC_QOS_DEFAULT);
    }

    dds::DomainParticipant* participant_ = nullptr;
    dds::Publisher* publisher_ = nullptr;
    dds::Subscriber* subscriber_ = nullptr;
    std::map<std::size_t, std::unique_ptr<Writer>> writers_;
    std::vector<std::unique_ptr<ReaderListener>> listeners_;
};

class LogConsumer final : public dds::LogConsumer {
public:
    explicit LogConsumer(const BusEvents& events) : events_{events} {}
    void Consume(const dds::Log::Entry& entry) override { events_.log(entry.message); }

private:
    const BusEvents& events_;
};

class FastDdsBus final : public NetworkBus {
public:
    FastDdsBus(std::uint32_t domain, BusEvents events)
        : domain_{domain}, events_{std::make_shared<const BusEvents>(std::move(events))} {
        dds::Log::ClearConsumers();
        dds::Log::RegisterConsumer(std::make_unique<LogConsumer>(*events_));
        dds::Log::SetVerbosity(dds::Log::Kind::Error);
    }

    Topic advertise(TopicSpec spec) override {
        constexpr std::string_view image = "Image";
        topics_.push_back(spec_of(spec));
        topics_.back().is_large = spec.type->name == image;
        if (session_) session_->add_writer(topics_.size() - 1, topics_.back());
        return topics_.size() - 1;
    }
    void withdraw(Topic topic) override {
        topics_[topic].is_used = false;
        if (session_) session_->remove_writer(topic);
    }
    bool has_subscribers(Topic topic) const override { return session_ && session_->has_readers(topic); }
    void publish(Topic topic, std::string_view cdr) override {
        if (session_ && (topics_[topic].is_large || cdr.size() <= large_message)) session_->write(topic, cdr);
    }
    std::size_t subscribe(TopicSpec spec) override {
        subscriptions_.push_back(spec_of(spec));
        if (session_) session_->add_reader(subscriptions_.size() - 1, subscriptions_.back(), *events_);
        return subscriptions_.size() - 1;
    }

    std::string open(const std::vector<std::string>& addresses) override {
        end_session();
        try {
            auto session = std::make_unique<Session>(domain_, addresses);
            if (!session->is_good()) return "Fast DDS can't join the network";
            session_ = std::move(session);
            for (std::size_t i = 0; i < topics_.size(); ++i)
                if (topics_[i].is_used) session_->add_writer(i, topics_[i]);
            for (std::size_t i = 0; i < subscriptions_.size(); ++i) session_->add_reader(i, subscriptions_[i], *events_);
            return {};
        } catch (const std::exception& error) {    // no more descriptors or threads
            end_session();
            return std::string{"Fast DDS can't join the network: "} + error.what();
        }
    }
    void close(ano::Duration patience) override {
        end_session();
        std::unique_lock lock{ending_->mutex};
        ending_->changed.wait_for(lock, patience, [this] { return ending_->count == 0; });
    }

private:
    struct Ending {
        std::mutex mutex;
        std::condition_variable changed;
        int count = 0;    // sessions that end at present
    };

    static Spec spec_of(const TopicSpec& spec) {
        return {"rt" + spec.name, dds_type_name(*spec.type), type_hash(*spec.type), spec.reliability};
    }

    // In a thread of its own, which nobody has to wait for.
    void end_session() {
        if (!session_) return;
        {
            const std::lock_guard lock{ending_->mutex};
            ++ending_->count;
        }
        std::thread{[session = std::move(session_), ending = ending_, events = events_]() mutable {
            session.reset();
            const std::lock_guard lock{ending->mutex};
            --ending->count;
            ending->changed.notify_all();
        }}.detach();
    }

    std::uint32_t domain_;
    std::shared_ptr<const BusEvents> events_;
    std::vector<Spec> topics_, subscriptions_;
    std::unique_ptr<Session> session_;    // nullptr: closed
    std::shared_ptr<Ending> ending_ = std::make_shared<Ending>();
};

}    // namespace

std::unique_ptr<NetworkBus> make_network_bus(std::uint32_t domain, BusEvents events) {
    return std::make_unique<FastDdsBus>(domain, std::move(events));
}

}    // namespace anogate
