// POST /send: one frame, and what became of it.
#pragma once
#include <http/request.hpp>
#include <http/response.hpp>

namespace anogate {

class Gateway;

/// {"hex": "AB..."} or the JSON of a frame. The answer says by which links it left, where it waits, and where it was dropped and why.
http::Response send_request(Gateway& gateway, const http::Request& request);

}    // namespace anogate
