#include <gtest/gtest.h>
#include <gateway/can_settings.hpp>
#include <link/replay_settings.hpp>
#include <link/serial/pty_settings.hpp>
#include <link/serial/serial_settings.hpp>
#include <link/sim_settings.hpp>
#include <link/tcp/tcp_settings.hpp>
#include <link/udp/udp_settings.hpp>

#include <support/temp_dir.hpp>
#include <unit/config/faults.hpp>

namespace anogate::read_link_tests {
namespace {

using testing::Test;

LinkSettings link_of(std::string_view text) {
    Draft draft{link_kinds()};
    read_link(text, "", draft);
    validate(draft);
    EXPECT_EQ(lines(draft.errors), "");
    return draft.settings.links.at(0);
}

LinkSettings of_kind(std::string_view name) {
    LinkSettings link;
    link.kind = find_link_kind(name);
    link.of_kind = link.kind->settings();
    return link;
}

/// One LINK text with one error: the words after "LINK '...': ".
std::string fault_of(const std::string& link) {
    const std::string text = faults_of({link});
    const std::string start = "LINK '" + link + "': ";
    EXPECT_EQ(text.rfind(start, 0), 0u) << text;
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
    return text.substr(std::min(text.size(), start.size()), text.size() - start.size() - 1);
}

TEST(LinkText, a_very_long_text_is_reported_in_short_lines) {
    std::string text = "sim:fc";
    while (text.size() < 1 << 16) text += ",k=v";
    Draft draft{link_kinds()};
    read_link(text, "", draft);
    std::size_t told = 0;
    for (const ConfigError& error : draft.errors) told += error.where.size();
    EXPECT_LT(told, std::size_t{1} << 24);
}

TEST(LinkText, an_impossible_device_path_is_reported_with_a_suggestion) {
    EXPECT_EQ(fault_of("serial:ttyUSB0"), "'device' 'ttyUSB0' is not the path of a port (did you mean '/dev/ttyUSB0'?)");
    EXPECT_EQ(fault_of("serial:dev/ttyS0,baud=9600"),
              "'device' 'dev/ttyS0' is not the path of a port (did you mean '/dev/ttyS0'?)");
    EXPECT_EQ(
        fault_of("serial:usb-FTDI_x-if00-port0"),
        "'device' 'usb-FTDI_x-if00-port0' is not the path of a port (did you mean '/dev/serial/by-id/usb-FTDI_x-if00-port0'?)");
    EXPECT_EQ(fault_of("serial:COM3"), "'device' 'COM3' is not the path of a port, such as /dev/ttyUSB0");
    EXPECT_EQ(fault_of("serial:/dev/x:500000"),
              "'device' '/dev/x:500000' ends with a number (did you mean '/dev/x' with baud=500000?)");
    EXPECT_EQ(fault_of("serial:ttyUSB0:500000"),
              "'device' 'ttyUSB0:500000' is not the path of a port (did you mean '/dev/ttyUSB0:500000'?)");
    for (const std::string device : {"/dev/ttyUSB*", "/dev/ttyUSB?", "/dev/ttyUSB[01]"})
        EXPECT_EQ(fault_of("serial:" + device),
                  "'device' '" + device +
                      "' is a pattern, but a link is one port: use its name in /dev/serial/by-id/, which does not change");
    EXPECT_EQ(fault_of("can:can*"), "'interface' 'can*' is a pattern, but a link is one interface, such as can0");
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "serial", "device": "ttyAMA0"}]})"),
              "/links/0/device: 'device' 'ttyAMA0' is not the path of a port (did you mean '/dev/ttyAMA0'?)\n");
    for (const std::string device : {"/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0",
                                     "/dev/serial/by-path/platform-x-usb-0:1:1.0", "./here", "a/b", "/dev/ttyUSB0"})
        EXPECT_EQ(link_of("serial:" + device).as<SerialSettings>().device, device);
}

TEST(LinkText, has_the_keys_of_protocol_v7) {
    const std::string keys =
        ",protocol=v7,v7_device=0xDD,v7_sources=0x51:0xDE+0xF1-0xFA:0xDB,v7_address=0x60,v7_acc=2048,v7_temp=10,"
        "v7_range=doc,v7_layout=keep,v7_down=0x40+0xF1-0xFA,v7_ack=sent,v7_repeat=1,v7_params=lx,v7_max=60";
    const V7LinkSettings serial = link_of("serial:/dev/ttyUSB0" + keys).as<SerialSettings>().v7;
    EXPECT_EQ(link_of("udp:192.168.1.2:6670" + keys).as<UdpSettings>().v7, serial);
    EXPECT_EQ(link_of("tcp:192.168.1.2:6670" + keys).as<TcpSettings>().v7, serial);
    EXPECT_EQ(link_of("pty:/tmp/fc" + keys).as<PtySettings>().v7, serial);
    EXPECT_EQ(link_of("udp-listen:0.0.0.0:12333" + keys).as<UdpListenSettings>().v7, serial);
    EXPECT_EQ(link_of("tcp-listen:0.0.0.0:12333" + keys).as<TcpListenSettings>().v7, serial);
    EXPECT_EQ(link_of("tls:192.168.1.2:6670" + keys).as<TcpSettings>().v7, serial);
    EXPECT_EQ(link_of("tls-listen:0.0.0.0:12333,verify=none,certificate=/c,key=/k" + keys).as<TcpListenSettings>().v7, serial);
    EXPECT_TRUE(serial.is_on());
    const V7Settings v7 = serial.translation();
    EXPECT_EQ(v7.address, 0xDD);
    EXPECT_EQ(v7.sources, (std::vector<V7Source>{{0x51, 0x51, 0xDE}, {0xF1, 0xFA, 0xDB}}));
    EXPECT_EQ(v7.v7_address, 0x60);
    EXPECT_EQ(v7.acc, v7_acc_flow);
    EXPECT_EQ(v7.temp, 10u);
    EXPECT_EQ(v7.range, V7Range::doc);
    EXPECT_EQ(v7.layout, V7Layout::keep);
    EXPECT_EQ(v7.down.count(), 11u);
    EXPECT_TRUE(v7.down[0x40] && v7.down[0xF1] && v7.down[0xFA]);
    EXPECT_EQ(v7.ack, V7Ack::sent);
    EXPECT_EQ(v7.repeats, 1u);
    EXPECT_EQ(v7.parameters, v7_lx_parameters());
    EXPECT_EQ(v7.max_data, 60u);
}

TEST(LinkText, with_only_the_device_of_v7_has_the_usual_settings) {
    const V7Settings v7 = link_of("serial:/dev/ttyUSB0,protocol=v7,v7_device=33").as<SerialSettings>().v7.translation();
    const V7Settings usual;
    EXPECT_EQ(v7.address, 33);
    EXPECT_EQ(v7.acc, std::nullopt);
    EXPECT_EQ(v7.temp, usual.temp);
    EXPECT_EQ(v7.range, std::nullopt);
    EXPECT_EQ(v7.v7_address, std::nullopt);
    EXPECT_EQ(v7.down, usual.down);
    EXPECT_EQ(v7.repeats, usual.repeats);
    EXPECT_EQ(v7.max_data, usual.max_data);
    EXPECT_TRUE(v7.parameters.empty());
    EXPECT_FALSE(link_of("serial:/dev/ttyUSB0").as<SerialSettings>().v7.is_on());
}

TEST(LinkText, with_a_v7_host_program_has_the_device_that_it_sees) {
    const V7LinkSettings v7 = link_of("udp-listen:0.0.0.0:1,protocol=v7,v7_role=host,v7_device=0xDD").as<UdpListenSettings>().v7;
    EXPECT_EQ(v7.role, V7Role::host);
    EXPECT_EQ(v7.translation().address, 0xDD);
    EXPECT_EQ(v7.translation().max_data, 255u);
    const std::string keys = "serial:/dev/ttyUSB0,protocol=v7,v7_role=host,v7_device=0xDD,";
    EXPECT_EQ(link_of(keys + "v7_max=40").as<SerialSettings>().v7.translation().max_data, 40u);
    for (const std::string key : {"v7_layout=keep", "v7_down=0x40", "v7_ack=sent"})
        EXPECT_EQ(fault_of(keys + key), "'v7_layout', 'v7_down' and 'v7_ack' have no effect with 'v7_role' host: remove them");
}

TEST(LinkText, of_a_v7_device_may_name_a_file_with_its_parameters) {
    const support::TempDir dir;
    const std::string file = dir.write("table.csv", "11, PID1_P, 1000\n12, PID1_I, 1000\n");
    const std::string text = "serial:/dev/ttyUSB0,protocol=v7,v7_device=0xDC,v7_params=" + file;
    const V7Settings v7 = link_of(text).as<SerialSettings>().v7.translation();
    EXPECT_EQ(v7.parameters, (std::vector<V7Parameter>{{11, "PID1_P", 1000}, {12, "PID1_I", 1000}}));
    dir.write("table.csv", "11, PID1_P, 1000\n12\n");
    EXPECT_EQ(fault_of(text), "the table of 'v7_params' cannot be used: " + file + ": line 2: NAME must have 1 to 20 bytes");
    EXPECT_EQ(fault_of(text + "x"), "the table of 'v7_params' cannot be used: " + file + "x: No such file or directory");
    EXPECT_EQ(fault_of("serial:/dev/ttyUSB0,protocol=v7,v7_device=0xDC,v7_params=table.csv"),
              "'v7_params' must be none, lx, tkz or the path of a file that begins with /, not 'table.csv'");
}

TEST(LinkText, explains_wrong_keys_of_protocol_v7) {
    const auto fault = [](const std::string& keys) { return fault_of("serial:/dev/ttyUSB0," + keys); };
    EXPECT_EQ(
        fault("protocol=v7"),
        "'protocol' v7 needs 'v7_device', the id under which hosts see the device: 0xDC, 0xDD, 0xDB, 0xDE, 0xE6, or 1 to 199");
    EXPECT_EQ(fault("v7_device=0xDD"), "the keys v7_... have no effect without 'protocol' v7");
    EXPECT_EQ(fault("protocol=v7,v7_device=0xFE"), "'v7_device' must be 0xDC, 0xDD, 0xDB, 0xDE, 0xE6, or 1 to 199, not 0xFE");
    EXPECT_EQ(fault("protocol=v7,v7_device=0xDD,v7_sources=0x51:0xDE+0xF1-0xFA:0xDB+0x50-0x52:0xDB"),
              "'v7_sources' must name one device for an id, not both 0xDE and 0xDB for 0x51");
    (void)link_of("serial:/dev/ttyUSB0,protocol=v7,v7_device=0xDD,v7_sources=0x51:0xDE+0x50-0x52:0xDE");
    EXPECT_EQ(
        fault("protocol=v7,v7_device=0xDD,v7_sources=51"),
        "'v7_sources' must be ID:DEVICE such as 0x51:0xDE or 0xF1-0xFA:0xDB, with a device of 0xDC, 0xDD, 0xDB, 0xDE, 0xE6, or 1 "
        "to 199, not '51'");
    EXPECT_EQ(fault("protocol=v7,v7_device=0xDD,v7_acc=0"),
              "'v7_acc' must be lx, flow, cmss, keep or a number above 0 such as 2048, not '0'");
    for (const std::string id : {"0x01", "0x0F", "0x20", "0x21"})
        EXPECT_EQ(fault("protocol=v7,v7_device=0xDD,v7_down=0x40+" + id),
                  "'v7_down' must not contain " + id + ": a V7 device would take it for a measurement of its own sensor");
    EXPECT_EQ(fault_of("sim:fc,protocol=v7"),
              "'protocol' is not a key of sim, but of serial, hid, udp-listen, udp, tcp, tcp-listen, tls, tls-listen, pty");
    EXPECT_EQ(
        faults_in(R"({"links": [{"kind": "tcp", "address": "10.0.0.1:5", "protocol": "v7"}]})"),
        "/links/0/v7_device: 'protocol' v7 needs 'v7_device', the id under which hosts see the device: 0xDC, 0xDD, 0xDB, 0xDE, "
        "0xE6, or 1 to 199\n");
}

TEST(LinkText, a_full_width_separator_is_named) {
    EXPECT_EQ(fault_of("serial:/dev/ttyUSB0，baud=500000"), "full-width '，': write ','");
    EXPECT_EQ(fault_of("serial：/dev/ttyUSB0"), "full-width '：': write ':'");
    EXPECT_EQ(fault_of("serial:/dev/ttyUSB0,baud＝500000"), "full-width '＝': write '='");
}

TEST(LinkText, explains_how_to_set_the_bit_rate_of_a_can_bus) {
    const std::string told = " is not a key of can: set the bit rate with sudo ip link set can0 up type can bitrate 500000";
    EXPECT_EQ(fault_of("can:can0,bitrate=500000"), "'bitrate'" + told);
    EXPECT_EQ(fault_of("can:can0,baud=500000"), "'baud'" + told);
    EXPECT_EQ(faults_in(R"({"links": [{"kind": "can", "interface": "can0", "dbitrate": 2000000}]})"),
              "/links/0/dbitrate: 'dbitrate'" + told + "\n");
    EXPECT_EQ(fault_of("can0,bitrate=500000"), "the kind is missing (did you mean 'can:can0,bitrate=500000'?)");
    EXPECT_EQ(fault_of("ttyUSB0"), "the kind is missing (did you mean 'serial:/dev/ttyUSB0'?)");
}

TEST(LinkText, reads_a_serial_link) {
    const LinkSettings link = link_of(
        "serial:/dev/ttyUSB0,baud=123456,parity=even,stop_bits=2,flow=hardware,low_latency=no,pace=off,dtr=off,rts");
    LinkSettings expected = of_kind("serial");
    expected.name = "ttyUSB0";
    expected.of_kind = SerialSettings{"/dev/ttyUSB0", 123456,    Parity::even, 2,   FlowControl::hardware,
                                      false,          Pace::off, false,        true};
    EXPECT_EQ(link, expected);
}

TEST(LinkText, reads_the_traffic_keys) {
    const LinkSettings link = link_of(
        "udp:10.0.0.1:5,group=air,rate=5000,latency=50ms,pack=no,mtu=500,age.telemetry=300ms,"
        "receive.deny=firmware+0xB0,send.allow_destinations=30-40,limit.0x01=50,limit.euler=0.5");
    EXPECT_EQ(link.group, "air");
    EXPECT_EQ(link.rate, 5000u);
    EXPECT_EQ(link.latency, std::chrono::milliseconds{50});
    EXPECT_FALSE(link.pack);
    EXPECT_EQ(link.mtu, 500);
    EXPECT_EQ(link.age.telemetry, std::chrono::milliseconds{300});
    EXPECT_EQ(link.rules.receive.deny, (std::vector<ByteRange>{{0xF0, 0xF0}, {0xB0, 0xB0}}));
    EXPECT_EQ(link.rules.send.allow_destinations, (std::vector<ByteRange>{{30, 40}}));
    EXPECT_EQ(link.rules.limit, (std::vector<LimitRule>{{1, 50}, {3, 0.5}}));
}

TEST(LinkText, reports_errors_of_traffic_keys) {
    EXPECT_NE(fault_of("sim:fc,limit=5").find("write limit.0x01=50"), std::string::npos);
    EXPECT_NE(fault_of("sim:fc,limit.telemetry=5").find("not for 'telemetry', which covers several"), std::string::npos);
    EXPECT_NE(fault_of("sim:fc,limit.0x01-0x0F=5").find("not for '0x01-0x0F', which covers several"), std::string::npos);
    EXPECT_NE(fault_of("sim:fc,limit.elur=5").find("not for 'elur' (did you mean 'euler'?)"), std::string::npos);
    EXPECT_NE(fault_of("sim:fc,limit.0x01=50,limit.0x01=20").find("0x01 already has a limit"), std::string::npos);
    EXPECT_NE(fault_of("sim:fc,receive.denny=0x01").find("(did you mean 'receive.deny'?)"), std::string::npos);
    EXPECT_NE(fault_of("serial:/dev/x,pack=no").find("'pack' is not a key of serial, but of udp, udp-listen"), std::string::npos);
}

TEST(LinkText, serial_has_defaults) {
    LinkSettings expected = of_kind("serial");
    expected.name = "ttyUSB0";
    expected.as<SerialSettings>().device = "/dev/ttyUSB0";
    EXPECT_EQ(link_of("serial:/dev/ttyUSB0"), expected);
}

TEST(LinkText, reads_the_keys_common_to_all_links) {
    const LinkSettings link = link_of(
        "sim:fc,hz=100,name=飞控,id=0x05,max_data=65535,queue=70000,flood=no,broadcast=off,required");
    LinkSettings expected = of_kind("sim");
    expected.name = "飞控";
    expected.id = 5;
    expected.max_data = 65535;
    expected.queue = 70000;
    expected.flood = false;
    expected.broadcast = false;
    expected.required = true;
    expected.as<SimSettings>().hz = 100;
    EXPECT_EQ(link, expected);
}

TEST(LinkText, hello_is_a_switch_or_an_interval) {
    using namespace std::chrono_literals;
    EXPECT_EQ(hello_interval(link_of("serial:/dev/x")), 0s);
    EXPECT_EQ(hello_interval(link_of("serial:/dev/x,hello")), 2s);
    EXPECT_EQ(hello_interval(link_of("serial:/dev/x,hello=on")), 2s);
    EXPECT_EQ(hello_interval(link_of("udp:127.0.0.1:5,hello=10s")), 10s);
    EXPECT_EQ(hello_interval(link_of("serial:/dev/x,profile=vendor,hello=off")), 0s);
    EXPECT_EQ(fault_of("serial:/dev/x,hello=900ms"),
              "'hello' must be off, on, or a duration such as 5s, from 1s to 24h, not '900ms'");
}

TEST(LinkText, a_profile_only_sets_defaults) {
    using namespace std::chrono_literals;
    const LinkSettings vendor = link_of("serial:/dev/x,profile=vendor");
    EXPECT_EQ(vendor.max_data, 4096) << "of what comes in";
    EXPECT_EQ(vendor.effective_max_data_out(), 198);
    EXPECT_EQ(hello_interval(vendor), 2s);
    EXPECT_EQ(vendor.meaning_of_type_7(), ValueType7::u64);
    EXPECT_EQ(vendor.text_encoding(), TextEncoding::gbk);
    const LinkSettings said = link_of("serial:/dev/x,profile=vendor,max_data_out=298,hello=5s,value_type_7=f32,encoding=utf8");
    EXPECT_EQ(said.effective_max_data_out(), 298);
    EXPECT_EQ(hello_interval(said), 5s);
    EXPECT_EQ(said.meaning_of_type_7(), ValueType7::f32);
    EXPECT_EQ(said.text_encoding(), TextEncoding::utf8);
    const LinkSettings none = link_of("serial:/dev/x,max_data=1000");
    EXPECT_EQ(none.effective_max_data_out(), 1000);
    EXPECT_EQ(none.meaning_of_type_7(), ValueType7::f32);
    EXPECT_EQ(none.text_encoding(), TextEncoding::utf8);
    EXPECT_EQ(hello_interval(link_of("udp-listen:0.0.0.0:5,profile=vendor")), 0s) << "it has nobody to speak to";
    EXPECT_EQ(hello_interval(link_of("serial:/dev/x,profile=vendor,broadcast=no")), 0s);
}

// Also of devices that accept less than the bytes for which their parsers wait.
TEST(LinkText, a_flush_fills_the_parsers_of_most_devices) {
    for (const char* keys : {"", ",profile=vendor", ",profile=old", ",max_data_out=60", ",max_data=100"})
        EXPECT_EQ(flush_bytes_of(link_of(std::string{"serial:/dev/x"} + keys)), 206u) << keys;
    EXPECT_EQ(flush_bytes_of(link_of("serial:/dev/x,max_data_out=250")), 258u);
    EXPECT_EQ(flush_bytes_of(link_of("serial:/dev/x,profile=old,max_data_out=4000")), 306u);
    EXPECT_EQ(flush_bytes_of(link_of("udp:127.0.0.1:5")), 0u) << "no UART";
}

TEST(LinkText, the_queue_size_follows_max_data_out) {
    EXPECT_EQ(link_of("sim:fc,max_data=65535,max_data_out=100").queue, 32768u);
    EXPECT_EQ(link_of("sim:fc,max_data_out=65535").queue, 2u * 65543);
    EXPECT_EQ(link_of("sim:fc,profile=vendor,queue=206").queue, 206u);
    EXPECT_EQ(fault_of("sim:fc,profile=vendor,queue=205"),
              "'queue' must be at least max_data_out + 8, here 206, to hold one frame, not 205");
}

TEST(LinkText, reads_a_udp_listen_link) {
    const LinkSettings link = link_of("udp-listen:[::]:12333,peer_timeout=90s,max_peers=3,allow=192.168.0.0/16+::1");
    EXPECT_EQ(link.as<UdpListenSettings>().local.text(), "[::]:12333");
    EXPECT_EQ(link.as<UdpListenSettings>().peer_timeout, std::chrono::seconds{90});
    EXPECT_EQ(link.as<UdpListenSettings>().max_peers, 3);
    EXPECT_FALSE(link.as<UdpListenSettings>().allow_any);
    ASSERT_EQ(link.as<UdpListenSettings>().allow.size(), 2u);
    EXPECT_EQ(link.as<UdpListenSettings>().allow[1].text(), "::1/128");
    EXPECT_TRUE(link_of("udp-listen:0.0.0.0:0,allow=any").as<UdpListenSettings>().allow_any);
    EXPECT_FALSE(link.as<UdpListenSettings>().max_per_address);
    EXPECT_EQ(link_of("udp-listen:0.0.0.0:0,max_per_address=5").as<UdpListenSettings>().max_per_address, 5);
    EXPECT_TRUE(link.as<UdpListenSettings>().trusted.empty());
    const auto trusting = link_of("udp-listen:0.0.0.0:0,trusted=10.8.0.0/16+fd00::/8").as<UdpListenSettings>();
    ASSERT_EQ(trusting.trusted.size(), 2u);
    EXPECT_EQ(trusting.trusted[1].text(), "fd00::/8");
    EXPECT_TRUE(link_of("udp-listen:0.0.0.0:0,trusted=any").as<UdpListenSettings>().trusted_any);
}

TEST(LinkText, reads_a_udp_link) {
    const LinkSettings link = link_of("udp:[::1]:12333,bind=[::]:0");
    EXPECT_EQ(link.as<UdpSettings>().peer.text(), "[::1]:12333");
    ASSERT_TRUE(link.as<UdpSettings>().bind);
    EXPECT_EQ(link.as<UdpSettings>().bind->text(), "[::]:0");
    EXPECT_FALSE(link_of("udp:255.255.255.255:6670").as<UdpSettings>().bind);
}

TEST(LinkText, reads_a_can_link) {
    const LinkSettings link = link_of("can:can0,fd,brs=no,extended,base=0x40000");
    LinkSettings expected = of_kind("can");
    expected.name = "can0";
    expected.of_kind = CanSettings{"can0", CanFraming::stream, true, false, true, 0x40000, {}, {}};
    EXPECT_EQ(link, expected);
    const CanSettings isotp = link_of("can:can0,framing=isotp,tx=0x7E0,rx=2024").as<CanSettings>();
    EXPECT_EQ(isotp.framing, CanFraming::isotp);
    EXPECT_EQ(isotp.tx, 0x7E0u);
    EXPECT_EQ(isotp.rx, 0x7E8u);
    EXPECT_FALSE(isotp.base);
    EXPECT_EQ(fault_of("can:can0,base=0x601"), "base is a multiple of 0x100 up to 0x700 (11-bit ids), not 0x601");
    EXPECT_EQ(fault_of("can:can0,base=600"),
              "base is a multiple of 0x100 up to 0x700 (11-bit ids), not 600 (did you mean 0x600?)");
    EXPECT_EQ(fault_of("can:can0,base=0x20000000"),
              "'base' must be a CAN id such as 0x600, at most 0x1FFFFFFF, not '0x20000000'");
    EXPECT_EQ(fault_of("can:can0,framing=isotp,tx=1"), "framing=isotp needs tx and rx, the two CAN ids");
}

TEST(LinkText, reads_a_pty_link) { EXPECT_EQ(link_of("pty:/run/anogate/app").as<PtySettings>().path, "/run/anogate/app"); }

TEST(LinkText, links_without_a_name_get_a_unique_name) {
    Draft draft{link_kinds()};
    for (const char* text : {"serial:/dev/ttyUSB0", "serial:/dev/serial/ttyUSB0", "pty:/run/app", "udp-listen:0.0.0.0:12333",
                             "udp:1.2.3.4:6670", "sim:fc", "sim:fc", "sim:fc,name=fc-2", "pty:/tmp/control", "pty:/tmp/"})
        read_link(text, "", draft);
    validate(draft);
    EXPECT_EQ(lines(draft.errors), "");
    std::vector<std::string> names;
    for (const LinkSettings& link : draft.settings.links) names.push_back(link.name);
    EXPECT_EQ(names, (std::vector<std::string>{"ttyUSB0", "ttyUSB0-2", "app", "udp-listen-12333", "udp-6670", "fc", "fc-3",
                                               "fc-2", "control-2", "pty"}));
    EXPECT_EQ(link_of("pty:/tmp/" + std::string(60, 'x')).name, std::string(60, 'x'));
    EXPECT_EQ(link_of("pty:/tmp/" + std::string(61, 'x')).name, "pty") << "with a number behind it, it would be too long";
}

TEST(LinkText, the_queue_holds_two_of_the_largest_frames_by_default) {
    EXPECT_EQ(link_of("sim:fc,max_data=16376").queue, 32768u);
    EXPECT_EQ(link_of("sim:fc,max_data=65535").queue, 2u * 65543);
    EXPECT_EQ(link_of("sim:fc,max_data=65535,queue=65543").queue, 65543u);
}

TEST(LinkText, a_mistyped_key_is_reported_with_the_nearest_key) {
    EXPECT_EQ(fault_of("serial:/dev/x,bauds=9"), "unknown key 'bauds' (did you mean 'baud'?)");
    EXPECT_EQ(fault_of("serial:/dev/x,encryption"), "unknown key 'encryption'");
    EXPECT_EQ(fault_of("udp:1.2.3.4:5,baud=9"), "'baud' is not a key of udp, but of serial");
    EXPECT_EQ(fault_of("serial:/dev/x,baud=9,baud=9"), "'baud' is given twice");
    EXPECT_EQ(fault_of("serial:/dev/x,device=/dev/y"), "'device' is given twice");
    EXPECT_EQ(fault_of("serial:/dev/x,kind=udp"), "unknown key 'kind'");
    EXPECT_EQ(fault_of("serial:/dev/x,"), "a comma without a key after it");
    EXPECT_EQ(fault_of("serial:/dev/x,baud"), "'baud' needs a value: baud=NUMBER");
}

TEST(LinkText, a_value_out_of_range_is_reported_with_the_range) {
    EXPECT_EQ(fault_of("serial:/dev/x,baud=fast"), "'baud' must be a whole number from 1 to 4294967295, not 'fast'");
    EXPECT_EQ(fault_of("sim:fc,max_data=65536"), "'max_data' must be a whole number from 0 to 65535, not '65536'");
    EXPECT_EQ(fault_of("sim:fc,queue=4103"), "'queue' must be at least max_data_out + 8, here 4104, to hold one frame, not 4103");
    EXPECT_EQ(fault_of("sim:fc,id=21"), "'id' must be an address from 1 to 20 (or in hex such as 0x05), not '21'");
    EXPECT_EQ(fault_of("sim:fc,flood=maybe"), "'flood' must be true or false, not 'maybe'");
    EXPECT_EQ(fault_of("serial:/dev/x,parity=evn"), "'parity' must be one of none, even, odd, not 'evn' (did you mean 'even'?)");
    EXPECT_EQ(fault_of("udp-listen:0.0.0.0:1,peer_timeout=30"),
              "'peer_timeout' must be a duration such as 30s or 2m, from 1s to 24h, not '30'");
    EXPECT_EQ(fault_of("udp-listen:0.0.0.0:1,allow=10.0.0.0/33"),
              "'allow' must be any, or networks such as 192.168.0.0/24, not '10.0.0.0/33'");
    EXPECT_EQ(fault_of("sim:fc,name="), "'name' must be text of 1 to 64 bytes, not ''");
    EXPECT_EQ(fault_of("sim:fc,name=flood"), "'name' can't be 'flood', a reserved word");
    EXPECT_EQ(fault_of("sim:plane"), "'device' must be one of fc, imu, flow, radio, car, lx, not 'plane'");
}

TEST(LinkText, any_cannot_be_combined_with_networks) {
    EXPECT_TRUE(fault_of("udp-listen:0.0.0.0:1,allow=any+10.0.0.0/8").starts_with("'allow' must be any, or networks"));
}

TEST(LinkText, a_text_must_have_an_allowed_length) {
    EXPECT_EQ(link_of("sim:fc,name=" + std::string(64, 'x')).name.size(), 64u);
    EXPECT_TRUE(fault_of("sim:fc,name=" + std::string(65, 'x')).starts_with("'name' must be text of 1 to 64 bytes"));
    EXPECT_TRUE(fault_of("sim:fc,name=").starts_with("'name' must be text of 1 to 64 bytes"));
}

TEST(LinkText, an_address_or_id_without_0x_is_recognized) {
    const auto ends = [](const std::string& link, const std::string& end) {
        EXPECT_TRUE(fault_of(link).ends_with(end)) << fault_of(link);
    };
    ends("sim:fc,id=0C", "not '0C' (did you mean '0x0C'?)");
    ends("sim:fc,present_as=FE", "not 'FE' (did you mean '0xFE'?)");
    ends("sim:fc,limit.B0=50", "not for 'B0' (did you mean '0xB0'?)");
    ends("sim:fc,send.deny=0xF0+B0", "not 'B0' (did you mean '0xB0'?)");
    ends("sim:fc,send.deny=B0-B2", "not 'B0-B2' (did you mean '0xB0-0xB2'?)");
    ends("sim:fc,send.deny=30-4F", "not '30-4F' (did you mean '0x30-0x4F'?)");
    ends("sim:fc,receive.allow_sources=FE", "not 'FE' (did you mean '0xFE'?)");
    ends("can:can0,framing=isotp,tx=7E0,rx=0x7E8", "not '7E0' (did you mean '0x7E0'?)");
}

TEST(LinkText, a_number_with_a_unit_is_recognized) {
    EXPECT_TRUE(fault_of("serial:/dev/x,baud=500k").ends_with("not '500k' (did you mean '500000'?)"));
    EXPECT_TRUE(fault_of("serial:/dev/x,baud=115200bps").ends_with("not '115200bps' (did you mean '115200'?)"));
    EXPECT_TRUE(fault_of("serial:/dev/x,baud=115200bauds").ends_with("not '115200bauds'")) << "what is meant is a guess";
    EXPECT_TRUE(fault_of("serial:/dev/x,baud=115,200").find("not '115") == std::string::npos)
        << "two keys: that is another fault";
    EXPECT_TRUE(fault_of("sim:fc,queue=64KiB").ends_with("not '64KiB' (did you mean '65536'?)"));
    EXPECT_TRUE(fault_of("sim:fc,hz=50Hz").ends_with("not '50Hz' (did you mean '50'?)"));
    EXPECT_TRUE(fault_of("serial:/dev/x,rate=5kB").ends_with("not '5kB' (did you mean '5000'?)"));
    EXPECT_TRUE(fault_of("sim:fc,hz=5k").ends_with("not '5k'")) << "not in its range either";
    EXPECT_TRUE(fault_of("sim:fc,queue=99999999999999999999k").ends_with("k'"));
}

TEST(LinkText, a_key_separated_from_its_link_is_recognized) {
    EXPECT_EQ(fault_of("baud=500000"),
              "'baud' is a key: append it to its LINK with a comma and no space: KIND:ADDRESS,baud=500000");
    EXPECT_EQ(fault_of("bind=0.0.0.0:6669").substr(0, 15), "'bind' is a key");
    EXPECT_EQ(fault_of("limit.0x01=5").substr(0, 21), "'limit.0x01' is a key");
}

TEST(LinkText, several_values_separated_by_commas_are_recognized) {
    EXPECT_EQ(fault_of("udp-listen:0.0.0.0:1,allow=10.0.0.0/8,192.168.0.0/16"),
              "unknown key '192.168.0.0/16': join several values of 'allow' with +: allow=10.0.0.0/8+192.168.0.0/16");
    EXPECT_EQ(fault_of("sim:fc,send.deny=0xB0,0xB1"),
              "unknown key '0xB1': join several values of 'send.deny' with +: send.deny=0xB0+0xB1");
    EXPECT_NE(faults_of({"sim:fc,send.deny=0xB0,0xB1,0xB2"}).find("send.deny=0xB0+0xB1+0xB2"), std::string::npos);
    EXPECT_EQ(fault_of("sim:fc,send.deny=firmware,floood"), "unknown key 'floood' (did you mean 'flood'?)");
}

TEST(LinkText, a_limit_of_zero_is_rejected_with_the_filter_to_use) {
    EXPECT_TRUE(fault_of("sim:fc,limit.euler=0").ends_with("not '0'; to block them all: send.deny=euler"))
        << fault_of("sim:fc,limit.euler=0");
}

TEST(LinkText, reports_every_error_not_only_the_first) {
    const std::string faults = faults_of({"serial:/dev/x,bauds=9,id=99,flow=soft", "sim:fc,hz=0"});
    EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 4) << faults;
}

TEST(LinkText, a_baud_rate_without_a_key_is_recognized) {
    EXPECT_EQ(fault_of("serial:/dev/x,115200"), "unknown key '115200' (did you mean 'baud=115200'?)");
    EXPECT_EQ(fault_of("sim:fc,100"), "unknown key '100'");
}

TEST(LinkText, a_port_without_an_address_is_reported) {
    for (const char* port : {"12333", ":12333", "*:12333"})
        EXPECT_EQ(fault_of(std::string{"udp-listen:"} + port),
                  "'" + std::string{port} + "' has no IP address: write 0.0.0.0:12333 for every interface");
    EXPECT_EQ(fault_of("udp:6670"), "'6670' has no host name or IP address: write HOST:6670");
    EXPECT_EQ(fault_of("udp:10.0.0.1:6670,bind=6669"), "'6669' has no IP address: write 0.0.0.0:6669 for every interface");
    EXPECT_EQ(fault_of("udp:65536").rfind("'address' must be a host name or IP address, and a port", 0), 0u);
}

TEST(LinkText, a_local_address_cannot_be_a_host_name) {
    EXPECT_EQ(fault_of("udp-listen:localhost:1"),
              "'localhost:1': host names are not supported here; give an IP address such as 127.0.0.1:1");
    EXPECT_EQ(fault_of("tcp-listen:gw.example.org"),
              "'gw.example.org': host names are not supported here; give an IP address such as 127.0.0.1:PORT");
}

TEST(LinkText, a_udp_peer_is_a_host_and_a_port) {
    EXPECT_EQ(faults_of({"udp:fc.local:6670,bind=[::]:5"}), "");
    EXPECT_EQ(fault_of("udp:gw.example.org"), "'gw.example.org' has no port: write gw.example.org:PORT");
    EXPECT_EQ(fault_of("udp:fc.local:0"), "'fc.local:0' has port 0: give the port of the peer, 1 to 65535");
    EXPECT_EQ(fault_of("udp:1.2.3.4"), "'1.2.3.4' has no port: write 1.2.3.4:PORT");
    EXPECT_EQ(fault_of("udp:::1"), "'::1' has no port: write [::1]:PORT");
    EXPECT_EQ(fault_of("udp:1.2.3.4:70000"),
              "'address' must be a host name or IP address, and a port, such as 192.168.4.1:8888 or flow.local:8888, not "
              "'1.2.3.4:70000': a port is at most 65535");
    EXPECT_EQ(fault_of("udp:1.2.3.4:0"), "'1.2.3.4:0' has port 0: give the port of the peer, 1 to 65535");
    EXPECT_EQ(fault_of("udp:0.0.0.0:5"),
              "'0.0.0.0:5' is not the address of a peer; to accept peers there, use udp-listen:0.0.0.0:5");
    EXPECT_EQ(fault_of("udp:1.2.3.4:5,bind=[::]:5"), "'bind' [::]:5 and the peer 1.2.3.4:5 must both be IPv4 or both IPv6");
}

TEST(LinkText, a_tcp_peer_is_a_host_and_a_port) {
    for (const char* good : {"tcp:192.168.4.1:23", "tcp:flow.local:8888,dead_after=5s,hello=on,rate=9000,group=g", "tcp:[::1]:23",
                             "tcp:[fe80::1%wlan0]:23", "tcp:localhost:1"})
        EXPECT_EQ(faults_of({good}).find("error"), std::string::npos) << good;
    EXPECT_EQ(fault_of("tcp:192.168.4.1"), "'192.168.4.1' has no port: write 192.168.4.1:PORT");
    EXPECT_EQ(fault_of("tcp:8888"), "'8888' has no host name or IP address: write HOST:8888");
    EXPECT_EQ(fault_of("tcp:fe80::1"), "'fe80::1' has no port: write [fe80::1]:PORT");
    EXPECT_EQ(fault_of("tcp:host:0"), "'host:0' has port 0: give the port of the peer, 1 to 65535");
    EXPECT_EQ(fault_of("tcp:0.0.0.0:5"),
              "'0.0.0.0:5' is not the address of a peer; to accept connections there, use tcp-listen:0.0.0.0:5");
    for (const char* many : {"224.0.0.1:5", "255.255.255.255:5"})
        EXPECT_EQ(
            fault_of(std::string{"tcp:"} + many),
            "'" + std::string{many} + "' is a multicast or broadcast address: TCP needs the address of one host; use a UDP link");
    EXPECT_EQ(fault_of("tcp:[fe80::1]:5"), "'[fe80::1]:5' is a link-local address: add the interface, [fe80::1%eth0]:5");
    EXPECT_NE(fault_of("tls:0.0.0.0:5").find("use tls-listen:0.0.0.0:5"), std::string::npos);
}

TEST(LinkText, every_kind_over_tcp_has_the_keys_of_links) {
    const std::string keys =
        ",group=g,limit.0xF1=10,profile=vendor,gap=2ms,rate=9000,id=7,flood=no,queue=1000,age.rest=2s,manage=yes,send.deny=bulk";
    for (const std::string kind : {"tcp:192.168.4.1:23", "tls:192.168.4.1:23", "tcp-listen:0.0.0.0:23",
                                   "tls-listen:0.0.0.0:23,verify=none,certificate=/c,key=/k"}) {
        const LinkSettings link = link_of(kind + keys);
        EXPECT_EQ(link.group, "g") << kind;
        EXPECT_EQ(link.id, 7) << kind;
        EXPECT_EQ(faults_of({kind + keys, "serial:/dev/x,group=g,manage=yes"}), "") << kind;
    }
    EXPECT_EQ(faults_of({"tls:192.168.4.1:23,hello=on"}), "");
    EXPECT_EQ(fault_of("tls-listen:0.0.0.0:23,verify=none,certificate=/c,key=/k,hello=on"),
              "'hello' is not possible where the device connects; for a device at a known address use tls:HOST:PORT,hello=on");
}

TEST(LinkText, a_tcp_listener_has_a_local_address_of_one_host) {
    for (const std::string kind : {"tcp-listen:", "tls-listen:"}) {
        const std::string files = kind == "tcp-listen:" ? "" : ",verify=none,certificate=/c,key=/k";
        for (const char* many : {"224.0.0.1:5", "[ff02::1]:5", "255.255.255.255:5"})
            EXPECT_NE(fault_of(kind + many + files).find("' is a multicast or broadcast address"), std::string::npos)
                << kind << many;
        EXPECT_EQ(fault_of(kind + "[fe80::1]:5" + files),
                  "'[fe80::1]:5' is a link-local address: add the interface, [fe80::1%eth0]:5");
    }
}

TEST(LinkText, two_tcp_links_have_different_peers) {
    EXPECT_EQ(faults_of({"tcp:10.0.0.1:5,name=a", "tcp:10.0.0.1:5,name=b"}),
              "LINK 'tcp:10.0.0.1:5,name=b': '10.0.0.1:5' is already the peer of 'a' (LINK 'tcp:10.0.0.1:5,name=a')\n");
    EXPECT_NE(faults_of({"tls:fc.local:5", "tls:fc.local:5"}), "");
    EXPECT_NE(faults_of({"tls:fc.local:5", "tls:FC.local.:5"}), "");
    for (const char* other : {"tcp:10.0.0.1:6", "tcp:10.0.0.2:5", "tcp:fc.local:5"})
        EXPECT_EQ(faults_of({"tcp:10.0.0.1:5", other}), "") << other;
    EXPECT_EQ(faults_of({"tcp:[fe80::1%eth0]:5", "tcp:[fe80::1%wlan0]:5"}), "") << "two paths";
}

TEST(LinkText, a_number_that_the_resolver_reads_as_an_ip_address_is_not_a_host_name) {
    for (const char* number : {"0x7f000001", "0X7F.0.0.1", "127.1", "0x7f.1."})
        EXPECT_EQ(fault_of("tcp:" + std::string{number} + ":5"),
                  "'address' must be a host name or IP address, and a port, such as 192.168.4.1:8888 or flow.local:8888, not '" +
                      std::string{number} + ":5'");
    for (const char* name : {"0x", "0x7g", "0x7f.local", "7f"}) EXPECT_EQ(faults_of({"tcp:" + std::string{name} + ":5"}), "");
}

TEST(LinkText, tcp_and_udp_ports_are_separate_and_no_link_connects_to_this_gateway) {
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:5", "tcp-listen:0.0.0.0:5"}), "");
    EXPECT_NE(faults_of({"tcp-listen:0.0.0.0:5", "tcp-listen:10.0.0.1:5,name=b"}), "");
    EXPECT_NE(faults_of({"tcp-listen:0.0.0.0:5", "tls-listen:10.0.0.1:5,name=b,verify=none,certificate=/c,key=/k"})
                  .find("local port 5 is already used by"),
              std::string::npos);
    EXPECT_EQ(faults_of({"tcp-listen:0.0.0.0:5,name=port", "tcp:localhost:5,name=loop"}),
              "LINK 'tcp:localhost:5,name=loop': 'localhost:5' is this gateway itself: 'port' (LINK "
              "'tcp-listen:0.0.0.0:5,name=port') listens there\n");
    for (const char* itself : {"tcp:127.0.0.1:5", "tcp:127.0.0.9:5", "tcp:localhost:5", "tcp:localhost.:5"})
        EXPECT_NE(faults_of({itself, "tcp-listen:0.0.0.0:5"}), "") << itself;
    for (const char* itself : {"tcp:127.0.0.1:5", "tcp:[::1]:5", "tcp:localhost:5"})
        EXPECT_NE(faults_of({itself, "tcp-listen:[::]:5"}), "") << itself << ": [::] accepts IPv4, too";
    EXPECT_EQ(faults_of({"tcp:[::1]:5", "tcp-listen:0.0.0.0:5"}), "") << "that accepts IPv4 only";
    EXPECT_EQ(faults_of({"tcp:localhost:5", "tcp-listen:[::1]:5"}), "") << "localhost may be 127.0.0.1 alone";
    EXPECT_NE(faults_of({"tcp-listen:10.0.0.1:5", "tcp:10.0.0.1:5"}), "");
    EXPECT_EQ(faults_of({"tcp-listen:10.0.0.1:5", "tcp:localhost:5"}), "");
    EXPECT_EQ(faults_of({"tcp-listen:0.0.0.0:5", "tcp:localhost:6", "udp:127.0.0.1:5"}), "");
}

TEST(LinkText, no_udp_link_sends_to_its_own_gateway) {
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:5,name=port", "udp:localhost:5,name=loop"}),
              "LINK 'udp:localhost:5,name=loop': 'localhost:5' is this gateway itself: 'port' (LINK "
              "'udp-listen:0.0.0.0:5,name=port') listens there\n");
    EXPECT_NE(faults_of({"udp-listen:0.0.0.0:5", "udp:127.0.0.9:5"}), "");
    EXPECT_EQ(faults_of({"udp-listen:127.0.0.1:5", "udp:127.0.0.9:5"}), "");
    for (const char* itself : {"udp:127.0.0.1:5", "udp:LocalHost:5"})
        for (const char* port : {"udp-listen:0.0.0.0:5", "udp-listen:127.0.0.1:5", "udp:10.0.0.1:6,bind=0.0.0.0:5"})
            EXPECT_NE(faults_of({itself, port}), "") << itself << ' ' << port;
    EXPECT_NE(faults_of({"udp-listen:10.0.0.1:5", "udp:10.0.0.1:5"}), "");
    EXPECT_EQ(faults_of({"udp:127.0.0.1:5,bind=127.0.0.1:5,name=a"}),
              "LINK 'udp:127.0.0.1:5,bind=127.0.0.1:5,name=a': '127.0.0.1:5' is this gateway itself: 'a' (LINK "
              "'udp:127.0.0.1:5,bind=127.0.0.1:5,name=a') listens there\n");
    EXPECT_EQ(faults_of({"udp-listen:10.0.0.1:5", "udp:localhost:5"}), "");
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:5", "udp:localhost:6", "tcp:localhost:5", "udp:10.0.0.1:5"}), "");
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:5,interface=eth0", "udp:localhost:5"}), "")
        << "what comes from here is not received";
    EXPECT_NE(faults_of({"udp-listen:0.0.0.0:5,interface=lo", "udp:127.0.0.1:5"}), "");
    EXPECT_EQ(faults_of({"udp-listen:0.0.0.0:5", "udp:[::1]:5"}), "");
    EXPECT_NE(faults_of({"udp-listen:[::]:5", "udp:[::1]:5"}), "");
    EXPECT_EQ(faults_of({"udp-listen:[fe80::1%eth0]:5", "udp:[fe80::1%eth1]:5"}), "") << "of another network";
    EXPECT_NE(faults_of({"udp-listen:[fe80::1%eth0]:5", "udp:[fe80::1%eth0]:5"}), "");
    EXPECT_EQ(faults_of({"udp-listen:239.0.0.1:5", "udp:239.0.0.1:5"}), "") << "others receive it too";
    EXPECT_EQ(faults_of({"udp:255.255.255.255:5,bind=0.0.0.0:5"}), "");
}

TEST(LinkText, a_link_local_address_requires_an_interface_and_others_reject_it) {
    EXPECT_EQ(fault_of("udp:[fe80::1%no such]:5"), "'[fe80::1%no such]:5': 'no such' is not the name of a network interface");
    EXPECT_EQ(fault_of("udp:[fe80::1%]:5"), "'[fe80::1%]:5': '' is not the name of a network interface");
    EXPECT_EQ(faults_of({"udp:[fe80::1%wlan9]:5"}), "") << "it may come yet";
    EXPECT_EQ(faults_of({"udp-listen:[fe80::1%wlan8]:5", "udp-listen:[fe80::1%wlan9]:5"}), "");
    EXPECT_EQ(fault_of("udp:[2001:db8::7%lo]:5"),
              "'[2001:db8::7%lo]:5': only a link-local address (fe80::...) can have an interface");
    EXPECT_EQ(fault_of("udp:[fe80::1]:5"), "'[fe80::1]:5' is a link-local address: add the interface, [fe80::1%eth0]:5");
    EXPECT_EQ(faults_of({"udp:[fe80::1%lo]:5", "udp:[fe80::2]:5,bind=[fe80::1%lo]:0"}), "");
}

TEST(LinkText, interface_is_for_udp_links_and_must_match_the_one_of_an_address) {
    EXPECT_EQ(faults_of({"udp:1.2.3.5:5,interface=wg0", "udp-listen:1.2.3.4:5,interface=wg0"}), "");
    EXPECT_EQ(fault_of("udp:1.2.3.4:5,interface="), "'interface' must be text of 1 to 15 bytes, not ''");
    EXPECT_EQ(fault_of("serial:/dev/x,interface=wg0"), "'interface' is not a key of serial, but of udp-listen, udp, can");
    EXPECT_EQ(
        faults_of({"udp:[fe80::1]:5,interface=wg0", "udp:[fe80::1%wg0]:5,interface=wg0", "udp:[fe80::1%3]:5,interface=wg0"}), "");
    for (const char* link : {"udp:[fe80::1%wg1]:5,interface=wg0", "udp:[fe80::2]:5,bind=[fe80::1%wg1]:5,interface=wg0",
                             "udp-listen:[fe80::1%wg1]:5,interface=wg0"})
        EXPECT_EQ(fault_of(link), "'interface' 'wg0' contradicts [fe80::1%wg1]:5: remove one of them");
}

TEST(LinkText, one_port_can_be_used_by_one_link_per_interface) {
    const auto collide = [](const std::string& a, const std::string& b) {
        const std::string faults = faults_of({a.c_str(), b.c_str()});
        EXPECT_TRUE(faults.empty() || faults.find("local port 5 is already used by") != std::string::npos) << faults;
        return !faults.empty();
    };
    for (const char* other : {"udp-listen:0.0.0.0:5", "udp-listen:10.0.0.1:5", "udp:10.0.0.2:6,bind=0.0.0.0:5"}) {
        const std::string link = std::string{other} + ",name=other";
        EXPECT_FALSE(collide("udp-listen:0.0.0.0:5,interface=wg0", link + ",interface=wg1")) << link;
        EXPECT_TRUE(collide("udp-listen:0.0.0.0:5,interface=wg0", link + ",interface=wg0")) << link;
        EXPECT_TRUE(collide("udp-listen:0.0.0.0:5,interface=wg0", link)) << link;
        EXPECT_TRUE(collide(link, "udp-listen:0.0.0.0:5,interface=wg0")) << link;
        EXPECT_TRUE(collide(link, "udp-listen:[::]:5")) << link;
        EXPECT_TRUE(collide("udp-listen:[::]:5", link)) << link;
        EXPECT_FALSE(collide(link, "udp-listen:[::1]:5")) << link;
    }
}

TEST(LinkText, a_text_that_is_not_a_link_is_reported_with_an_explanation) {
    EXPECT_EQ(fault_of("/dev/ttyUSB0"), "the kind is missing (did you mean 'serial:/dev/ttyUSB0'?)");
    EXPECT_EQ(fault_of("1.2.3.4:5"), "the kind is missing (did you mean 'udp:1.2.3.4:5' or 'udp-listen:...'?)");
    EXPECT_EQ(fault_of("help"), "a LINK is KIND:ADDRESS[,KEY=VALUE...], for example serial:/dev/ttyUSB0,baud=500000");
    EXPECT_EQ(fault_of(""), "a LINK is KIND:ADDRESS[,KEY=VALUE...], for example serial:/dev/ttyUSB0,baud=500000");
    EXPECT_EQ(fault_of("sim"), "the address is missing, for example sim:fc");
    EXPECT_EQ(fault_of("udp-listen,name=x"), "the address is missing, for example udp-listen:0.0.0.0:12333");
    EXPECT_EQ(fault_of("serail:/dev/x"),
              "unknown kind 'serail' (did you mean 'serial'?); the kinds are serial, hid, udp-listen, udp, tcp, tcp-listen, tls, "
              "tls-listen, can, pty, sim, replay");
    EXPECT_EQ(fault_of("serial:"), "the address is missing, for example serial:/dev/ttyUSB0");
    EXPECT_EQ(fault_of("serial:,baud=9"), "the address is missing, for example serial:/dev/ttyUSB0");
    EXPECT_EQ(fault_of("serial:/dev/\xFF"), "not UTF-8 text");
}

TEST(LinkText, two_links_cannot_be_the_same) {
    EXPECT_EQ(faults_of({"serial:/dev/x", "serial:/dev/x,name=y"}),
              "LINK 'serial:/dev/x,name=y': 'device' '/dev/x' is already used by 'x' (LINK 'serial:/dev/x')\n");
    EXPECT_EQ(faults_of({"pty:/tmp/a", "pty:/tmp/a"}),
              "LINK 'pty:/tmp/a': 'path' '/tmp/a' is already created by 'a' (LINK 'pty:/tmp/a')\n");
    EXPECT_EQ(faults_of({"sim:fc,name=a", "sim:fc,name=a"}),
              "LINK 'sim:fc,name=a': 'name' 'a' is already the name of LINK 'sim:fc,name=a'\n");
    EXPECT_EQ(faults_of({"sim:fc,id=3", "pty:/x,id=3"}),
              "LINK 'pty:/x,id=3': 'id' 3 is already the port id of 'fc' (LINK 'sim:fc,id=3')\n");
}

TEST(LinkText, two_links_cannot_have_the_same_local_port) {
    const auto collide = [](std::string_view a, std::string_view b) { return !faults_of({a, b}).empty(); };
    EXPECT_TRUE(collide("udp-listen:0.0.0.0:1", "udp-listen:0.0.0.0:1"));
    EXPECT_TRUE(collide("udp-listen:0.0.0.0:1", "udp-listen:127.0.0.1:1"));
    EXPECT_TRUE(collide("udp-listen:127.0.0.1:1", "udp:1.2.3.4:5,bind=0.0.0.0:1"));
    EXPECT_FALSE(collide("udp-listen:127.0.0.1:1", "udp-listen:127.0.0.2:1"));
    EXPECT_FALSE(collide("udp-listen:0.0.0.0:1", "udp-listen:0.0.0.0:2"));
    EXPECT_FALSE(collide("udp-listen:0.0.0.0:0", "udp-listen:0.0.0.0:0"));
    EXPECT_FALSE(collide("udp:1.2.3.4:5", "udp:1.2.3.5:5"));
    EXPECT_FALSE(collide("udp:1.2.3.4:5", "udp-listen:0.0.0.0:5"));
}

TEST(LinkText, allows_at_most_64_links) {
    Draft draft{link_kinds()};
    for (int i = 0; i < 64; ++i) read_link("sim:fc", "", draft);
    validate(draft);
    EXPECT_EQ(lines(draft.errors), "");
    EXPECT_EQ(draft.settings.links.back().name, "fc-64");
    read_link("sim:fc", "", draft);
    validate(draft);
    EXPECT_EQ(lines(draft.errors), "anogated: LINK 'sim:fc': 65 links; at most 64 are supported\n");

    Draft with_tunnel{link_kinds()};
    read_config(R"({"tunnel": {"links": ["fc"]}})", "", with_tunnel);
    for (int i = 0; i < 64; ++i) read_link("sim:fc", "", with_tunnel);
    validate(with_tunnel);
    EXPECT_EQ(lines(with_tunnel.errors), "anogated: LINK 'sim:fc': 64 links; at most 63 are supported\n");
}

TEST(RouteText, with_one_error_causes_no_other) {
    Draft draft{link_kinds()};
    read_link("sim:fc", "", draft);
    read_route("999=nobody", "--route", draft);
    validate(draft);
    EXPECT_EQ(draft.errors.size(), 1u) << lines(draft.errors);
}

TEST(LinkText, reads_a_replay_link) {
    const LinkSettings link = link_of("replay:/a/flight.pcapng,rate=0.5,loop,from=30s,to=2m,links=fc+radio,commands=yes");
    EXPECT_EQ(link.name, "flight");
    const auto& replay = link.as<ReplaySettings>();
    EXPECT_EQ(replay.file, "/a/flight.pcapng");
    EXPECT_EQ(replay.rate, 500u);
    EXPECT_TRUE(replay.loop);
    EXPECT_EQ(replay.from, std::chrono::seconds{30});
    EXPECT_EQ(replay.to, std::chrono::minutes{2});
    EXPECT_EQ(replay.links, (std::vector<std::string>{"fc", "radio"}));
    EXPECT_TRUE(replay.commands);
    EXPECT_EQ(link_of("replay:a").as<ReplaySettings>().rate, 1000u);
    EXPECT_EQ(link_of("replay:a,rate=0").as<ReplaySettings>().rate, 0u);
}

TEST(LinkText, reports_errors_of_a_replay_link) {
    const std::string rate = "'rate' must be a number from 0 to 1000 such as 2 or 0.5, with at most three decimals, not ";
    EXPECT_EQ(fault_of("replay:a,rate=0.0001"), rate + "'0.0001'");
    EXPECT_EQ(fault_of("replay:a,rate=1000.5"), rate + "'1000.5'");
    EXPECT_EQ(fault_of("replay:a,rate=-1"), rate + "'-1'");
    EXPECT_EQ(fault_of("replay:a,from=2m,to=30s"), "'to' must be later than 'from'");
    EXPECT_NE(fault_of("replay:a,broadcast=no").find("'broadcast' is not a key of replay, but of serial"), std::string::npos);
}

TEST(LinkText, hostile_bytes_are_escaped_and_reported_in_one_line) {
    EXPECT_EQ(lines({{"LINK 'a\nb'", "c\x1B[2J"}}), "anogated: LINK 'a\\x0ab': c\\x1b[2J\n");
    EXPECT_EQ(lines({{"",
                      "\xC2\x9B"
                      "31m \xC2\xA0 \xC3\x9B"}}),
              "anogated: \\xc2\\x9b31m \xC2\xA0 \xC3\x9B\n");
    const std::string faults = faults_of({std::string(1 << 20, ',')});
    EXPECT_EQ(std::count(faults.begin(), faults.end(), '\n'), 1);
}

}    // namespace
}    // namespace anogate::read_link_tests
