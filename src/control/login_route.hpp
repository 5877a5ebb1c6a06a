// Login with a token: the browser gets a cookie, which it sends with all later requests.
#pragma once
#include <ano/time.hpp>
#include <http/doors/admission.hpp>

namespace anogate {

/// POST /login {"token": "..."}: 200 with the rights of the token and a cookie; 401 when the token is wrong, 429 after too many failures.
http::Response login(http::Admission& admission, const http::Request& request, ano::TimePoint now);

/// POST /logout: the browser forgets the cookie.
http::Response logout(const http::Admission& admission, const http::Request& request);

}    // namespace anogate
