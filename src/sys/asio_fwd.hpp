// Forward declarations of Asio for headers.
#pragma once

namespace boost::asio {
class io_context;
}

namespace anogate {
namespace asio = boost::asio;
}
