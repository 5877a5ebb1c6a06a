// The topics of ROS 2, as anogate-ros2 uses them. The implementation (fast_dds.cpp) is the only file that knows a DDS library.
#pragma once
#include <ano/frame.hpp>
#include <ano/time.hpp>
#include <ros/ros_message.hpp>
#include <ros2/settings.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

struct TopicSpec {
    std::string name;                    // "/fc/imu/data"
    const RosMessage* type = nullptr;    // must outlive the bus
    Reliability reliability = Reliability::reliable;
};

/// Identifies a publisher in the whole network.
using Guid = std::array<std::uint8_t, 16>;
/// "01.0f.0b.…": as `ros2 topic info -v` shows it.
std::string format_guid(const Guid& guid);

struct Sample {
    std::size_t topic = 0;    // the number of its subscription
    Guid publisher{};
    std::string cdr;
    std::uint64_t sent_ns = 0;        // by the clock of the publisher; 0: not stated
    std::uint64_t received_ns = 0;    // by the clock of this computer
    ano::TimePoint received_at{};
};

/// Not thread-safe, except that implementations receive samples in threads of their own.
class Bus {
public:
    using Topic = std::size_t;

    virtual ~Bus() = default;
    /// Creates a topic to publish on; its number is never used again.
    virtual Topic advertise(TopicSpec spec) = 0;
    /// Removes it. Its number must not be used afterwards.
    virtual void withdraw(Topic topic) = 0;
    /// If nobody subscribes, a message need not be encoded.
    virtual bool has_subscribers(Topic topic) const = 0;
    virtual void publish(Topic topic, std::string_view cdr) = 0;

    /// Subscribes to a topic and returns the number of the subscription. `best_effort`: a lost message is never sent again.
    virtual std::size_t subscribe(TopicSpec spec) = 0;
};

/// A bus on the network. Topics are kept while it is closed and are made anew by open().
class NetworkBus : public Bus {
public:
    /// Joins the network with these addresses of this computer; empty: all of its interfaces. Replaces what was open before, without
    /// waiting for its end. Empty: done; else the error.
    virtual std::string open(const std::vector<std::string>& addresses) = 0;
    /// Leaves the network, so that others notice it at once; gives up after `patience`.
    virtual void close(ano::Duration patience) = 0;
};

struct BusEvents {
    std::function<void(Sample)> sample = [](auto) {};              // called in threads of the library
    std::function<void(const std::string&)> log = [](auto&) {};    // as well: an error that the library reports
};

/// By Fast DDS.
std::unique_ptr<NetworkBus> make_network_bus(std::uint32_t domain, BusEvents events);

}    // namespace anogate
