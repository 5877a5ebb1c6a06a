// Asio with OpenSSL, included by one source only.
#pragma once
#include <http/asio.hpp>

#include <boost/asio/ssl.hpp>
