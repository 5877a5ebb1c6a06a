// Login with a token or a one-time code: the browser gets a cookie, which it sends with all later requests.
#pragma once
#include <ano/time.hpp>
#include <control/sign_in_codes.hpp>
#include <http/doors/admission.hpp>

namespace anogate {

/// POST /login {"token": "..."} or {"code": "..."}: 200 with the rights and a cookie; 401 when it is wrong, 429 after too many failures. A right
/// code gives the cookie of a token with its rights.
http::Response login(http::Admission& admission, SignInCodes& codes, const http::Request& request, ano::TimePoint now);

/// POST /login/code {"form": "link" or "digits", "access": "control" or "view"}: makes a code. 409 when no token has these rights.
http::Response make_code(const http::Admission& admission, SignInCodes& codes, const http::Request& request, ano::TimePoint now);

/// POST /logout: the browser forgets the cookie.
http::Response logout(const http::Admission& admission, const http::Request& request);

}    // namespace anogate
