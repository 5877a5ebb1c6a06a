// The client of a request, for people.
#pragma once
#include <http/request.hpp>

#include <string>

namespace anogate::http {

/// As far as the system knows it: "192.168.1.5"; at a Unix socket "anoctl of pi, process 712".
std::string format_client(const Request& request);

}    // namespace anogate::http
