// The constants of pcapng (draft-ietf-opsawg-pcapng), and how a recording is stored in it.
//
//   link                      an interface: if_name, if_description; timestamps in ns
//   direction                 epb_flags; for a dropped frame the direction in which it passed before
//   cause of a drop           the comment "dropped: CAUSE": Wireshark lists comments as such and filters by frame.comment
//   channel                   epb_queue, which Wireshark shows as the interface's queue; the comment "channel N: PEER" of the first
//                             frame of a channel names its peer
//   loss                      epb_dropcount of the next frame, and its comment "lost: NAMES"; after the last frame in the statistics
//                             of an interface
//   decoding                  the comment "decoding: JSON" of the first frame, and of a frame before which it has changed; a long one
//                             is split into several comments, to be concatenated
//   time since the start      an option for local use: no tool shows it, and programs that save the file again drop it
//   program, both clocks      shb_userappl and the comment of the section
//   the end                   the statistics of every interface: a file without them was not ended properly
#pragma once
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace anogate::pcapng {

inline constexpr std::uint32_t section_header = 0x0A0D0D0A;
inline constexpr std::uint32_t interface_description = 1;
inline constexpr std::uint32_t old_packet = 2;
inline constexpr std::uint32_t simple_packet = 3;
inline constexpr std::uint32_t interface_statistics = 5;
inline constexpr std::uint32_t enhanced_packet = 6;
inline constexpr std::uint32_t byte_order_magic = 0x1A2B3C4D;
inline constexpr std::uint16_t link_type_user0 = 147;

inline constexpr std::uint16_t opt_end = 0;
inline constexpr std::uint16_t opt_comment = 1;
inline constexpr std::uint16_t shb_userappl = 4;
inline constexpr std::uint16_t if_name = 2;
inline constexpr std::uint16_t if_description = 3;
inline constexpr std::uint16_t if_tsresol = 9;
inline constexpr std::uint16_t if_tsoffset = 14;
inline constexpr std::uint16_t epb_flags = 2;
inline constexpr std::uint16_t epb_dropcount = 4;
inline constexpr std::uint16_t epb_queue = 6;
inline constexpr std::uint16_t isb_ifrecv = 4;
inline constexpr std::uint16_t isb_ifdrop = 5;
inline constexpr std::uint16_t isb_osdrop = 7;
inline constexpr std::uint16_t opt_boottime = 0x8B07;    // local use: u64 ns

inline constexpr std::uint32_t inbound = 1, outbound = 2;    // of epb_flags, the lowest two bits

inline constexpr std::string_view dropped_mark = "dropped: ";
inline constexpr std::string_view lost_mark = "lost: ";
inline constexpr std::string_view channel_mark = "channel ";    // "channel 3: 192.168.1.20:6000"
inline constexpr std::string_view decoding_mark = "decoding: ";
inline constexpr std::size_t max_decoding_part = 60'000;       // bytes; an option has 65535 at most
inline constexpr std::string_view unix_mark = "unix time ";    // "unix time 1763898044.123456789 s, boot time 1234.567890123 s"
inline constexpr std::string_view boot_mark = " s, boot time ";

/// The name of the interface in a recording without frames: the end mark needs an interface.
inline constexpr std::string_view no_link = "-";

}    // namespace anogate::pcapng
