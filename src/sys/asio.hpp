// The only header that includes Asio. <utility> is first, because some headers of Boost 1.74 need it and do not include it.
#pragma once
#include <utility>

#include <boost/asio/io_context.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>

namespace anogate {

namespace asio = boost::asio;
using boost::system::error_code;

}    // namespace anogate
