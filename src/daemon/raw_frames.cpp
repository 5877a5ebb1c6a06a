#include <daemon/raw_frames.hpp>

#include <cstdint>
#include <span>
#include <utility>

namespace anogate {
namespace {

constexpr const char* schema_text =
    "# A frame of ANO V8 as it passed the gateway; its time is that of the message\n"
    "uint8 IN=0\n"
    "uint8 OUT=1\n"
    "uint8 DROPPED=2\n"
    "uint64 boottime_ns       # since the computer was started; 0: not known\n"
    "string link              # by name\n"
    "string link_description  # empty: not known\n"
    "uint8 direction\n"
    "string cause             # why it was dropped\n"
    "int16 channel            # its number in the gateway; -1: none\n"
    "string peer              # of that channel\n"
    "uint8[] frame            # from 0xAB to the check bytes\n";

// Little endian: each number stands at a multiple of its size, counted from behind the head.
class Cdr {
public:
    template <class Number>
    Cdr& number(Number value) {
        while ((bytes_.size() - head) % sizeof value != 0) bytes_ += '\0';
        for (std::size_t i = 0; i < sizeof value; ++i) bytes_ += static_cast<char>(value >> (8 * i) & 0xFF);
        return *this;
    }
    Cdr& text(std::string_view value) {
        number(static_cast<std::uint32_t>(value.size() + 1));
        bytes_.append(value).append(1, '\0');
        return *this;
    }
    Cdr& bytes(std::span<const std::uint8_t> value) {
        number(static_cast<std::uint32_t>(value.size()));
        bytes_.append(reinterpret_cast<const char*>(value.data()), value.size());
        return *this;
    }
    std::string take() { return std::move(bytes_); }

private:
    static constexpr std::size_t head = 4;
    std::string bytes_{'\0', '\1', '\0', '\0'};
};

}    // namespace

const DecodedSchema& raw_frame_schema() {
    static const DecodedSchema schema{"ano_msgs/msg/RecordedFrame", "ros2msg", schema_text};
    return schema;
}

std::string raw_frame(const RecordedFrame& frame) {
    constexpr std::uint16_t no_channel = 0xFFFF;
    Cdr cdr;
    cdr.number(frame.boottime_ns).text(frame.link).text(frame.link_description);
    cdr.number(static_cast<std::uint8_t>(frame.direction)).text(frame.cause);
    cdr.number(frame.channel ? std::uint16_t{*frame.channel} : no_channel).text(frame.peer).bytes(frame.frame.bytes());
    return cdr.take();
}

}    // namespace anogate
