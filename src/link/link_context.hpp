// Shared by all links: the loop, the timer, the gateway, and the buffers for datagrams.
#pragma once
#include <link/link.hpp>
#include <sys/asio_fwd.hpp>

namespace anogate {

class AlarmClock;
class DatagramBatch;
class DatagramSender;
class Resolver;
struct V7Lines;

struct LinkContext {
    asio::io_context& io;
    AlarmClock& alarms;
    LinkHost& host;
    DatagramBatch& batch;
    DatagramSender& sender;
    Resolver& names;
    V7Lines& v7_lines;
};

}    // namespace anogate
