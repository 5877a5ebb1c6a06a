// POST /send: sends one frame, and reports the result.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

namespace anogate {

class Gateway;

/// {"hex": "AB..."} or the JSON of a frame. The response lists the links that sent it, those where it waits, and those that dropped it and
/// why.
http::Response send_request(Gateway& gateway, const http::Request& request);

}    // namespace anogate
