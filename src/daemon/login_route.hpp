// A token given once, so that a browser gives it from then on.
#pragma once
#include <ano/time.hpp>
#include <http/admission.hpp>

namespace anogate {

/// POST /login {"token": "..."}: 200 with what the token may, and a cookie; 401 when it is not right, 429 for who fails often.
http::Response login(http::Admission& admission, const http::Request& request, ano::TimePoint now);

}    // namespace anogate
