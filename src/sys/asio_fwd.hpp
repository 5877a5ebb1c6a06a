// The names of Asio that headers need, without Asio.
#pragma once

namespace boost::asio {
class io_context;
}

namespace anogate {
namespace asio = boost::asio;
}
