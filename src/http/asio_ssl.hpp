// Asio with OpenSSL, which one source alone needs.
#pragma once
#include <http/asio.hpp>

#include <boost/asio/ssl.hpp>
