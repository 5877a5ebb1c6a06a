// The keys of protocol V7, for the tables of the kinds of links that have them.
#pragma once
#include <config/key_rows.hpp>
#include <config/link_kind.hpp>
#include <link/v7_settings.hpp>

#include <algorithm>
#include <array>
#include <string>
#include <utility>

namespace anogate {

/// Adds the errors that involve several of the keys.
void check_v7(const V7LinkSettings& v7, LinkFaults& faults);

namespace key_rows {

/// The error for a value, or "".
std::string fault_of_v7_device(std::uint64_t device);
std::string fault_of_v7_sources(const std::vector<std::string>& sources);
std::string fault_of_v7_acceleration(const std::string& text);
std::string fault_of_v7_params(const std::string& text);
std::string fault_of_v7_down(const std::vector<ByteRange>& ids);

/// A row whose value is refused if `fault` returns an error for it.
template <class Settings, class T, auto field, auto fault>
constexpr Key<LinkSettings> v7_row(KeyFacts facts) {
    Key<LinkSettings> key = row<own<Settings>, &Settings::v7, field>(facts);
    key.put = [](const KeyFacts& about, Value value, LinkSettings& link) {
        std::string wrong = fault(std::get<T>(value));
        if (wrong.empty()) store(about, std::move(value), link.as<Settings>().v7.*field);
        return wrong;
    };
    return key;
}

/// `Settings` has a V7LinkSettings `v7`.
template <class Settings>
constexpr auto v7_rows() {
    using V = V7LinkSettings;
    constexpr auto v7 = &Settings::v7;
    constexpr auto own_settings = own<Settings>;
    return std::array<Key<LinkSettings>, 14>{
        choice<own_settings, v7, &V::protocol>("protocol", "v8|v7",
                                               "the version of the protocol that the devices of this link use; v7 is "
                                               "translated, and needs v7_device"),
        choice<own_settings, v7, &V::role>("v7_role", "device|host",
                                           "what is at the other end of the link; host: a V7 ground station, ROS bridge or MCU "
                                           "that sees one V8 device, v7_device"),
        v7_row<Settings, std::uint64_t, &V::device, fault_of_v7_device>(
            {.name = "v7_device",
             .form = Form::address,
             .help = "with protocol=v7: the id under which hosts see the device: 0xDC, 0xDD (LX IMU), 0xDB, 0xDE (optical flow), "
                     "0xE6 (radio), or 1 to 199",
             .min = first_id,
             .max = last_id}),
        v7_row<Settings, std::vector<std::string>, &V::sources, fault_of_v7_sources>(
            {.name = "v7_sources",
             .form = Form::words,
             .help = "for a line with several V7 devices: the frames with these ids come from another device: "
                     "0x51:0xDE+0xF1-0xFA:0xDB",
             .min = 1,
             .max = 32,
             .stands_for = "ID:DEVICE[+ID:DEVICE...]"}),
        address<own_settings, v7, &V::address>("v7_address", 0, 255,
                                               "the destination in V7 frames to the device (default: 0xFF; for parameters, "
                                               "after v7_device)"),
        v7_row<Settings, std::string, &V::acc, fault_of_v7_acceleration>(
            {.name = "v7_acc",
             .form = Form::text,
             .help = "the unit of the device's accelerometer: a number is 1 g; lx: 1365.33; flow: 2048; cmss: cm per second "
                     "squared, and the gyroscope in degrees per second; keep changes nothing (default: after v7_device)",
             .min = 1,
             .max = 16,
             .stands_for = "lx|flow|cmss|keep|NUMBER"}),
        integer<own_settings, v7, &V::temp>("v7_temp", 1, 1000, "the device's number for 1 °C in its 0x02: 100, for some 10"),
        choice<own_settings, v7, &V::range>("v7_range", "lx|doc|flow",
                                            "the meaning of direction and angle in the device's 0x34 (default: flow for 0xDE, "
                                            "otherwise lx)"),
        choice<own_settings, v7, &V::layout>("v7_layout", "v8|keep",
                                             "0x02, 0x05, 0x08 and 0x34 of the device get the layout of V8, or keep theirs"),
        v7_row<Settings, std::vector<ByteRange>, &V::down, fault_of_v7_down>(
            {.name = "v7_down",
             .form = Form::frames,
             .help = "the frames that may be sent to the device, never 0x01-0x0F, 0x20, 0x21 (default: 0x00, 0x30, 0x32-0x34, "
                     "0x40, 0x41, 0x51, 0x60, 0x61, 0xA0, 0xC0, 0xE0, 0xE1, 0xF1-0xFA)"}),
        choice<own_settings, v7, &V::ack>("v7_ack", "device|sent",
                                          "who acknowledges commands; sent: the gateway, once the command is sent, for devices "
                                          "that never acknowledge"),
        integer<own_settings, v7, &V::repeat>(
            "v7_repeat", 1, 10,
            "how often a request for a parameter or waypoint is sent, every 200 ms, until it is "
            "answered; commands are never repeated"),
        v7_row<Settings, std::string, &V::params, fault_of_v7_params>(
            {.name = "v7_params",
             .form = Form::text,
             .help =
                 "the table of parameters that hosts see: lx, tkz, or the path of a file with a line NUMBER, NAME, SCALE, TYPE "
                 "for each parameter; none: they read and write parameters by number",
             .min = 1,
             .max = max_path,
             .stands_for = "none|lx|tkz|FILE"}),
        integer<own_settings, v7, &V::max>("v7_max", 1, 255,
                                           "maximum DATA length of a V7 frame that is sent (default: 44; with v7_role=host 255)"),
    };
}

template <std::size_t N, std::size_t M>
constexpr std::array<Key<LinkSettings>, N + M> with_v7(const Key<LinkSettings> (&own_rows)[N],
                                                       const std::array<Key<LinkSettings>, M>& v7) {
    std::array<Key<LinkSettings>, N + M> all;
    std::copy(std::begin(own_rows), std::end(own_rows), all.begin());
    std::copy(v7.begin(), v7.end(), all.begin() + N);
    return all;
}

}    // namespace key_rows
}    // namespace anogate
