// Login with a token or a one-time code: the browser receives a cookie, which it sends with all later requests.
#pragma once
#include <ano/time.hpp>
#include <control/sign_in_codes.hpp>
#include <http/listeners/admission.hpp>

namespace anogate {

/// POST /login {"token": "..."} or {"code": "..."}: 200 with the rights and a cookie; 401 if it is wrong, 429 after too many
/// failures. For a correct code, the cookie is that of a token with the same rights.
http::Response login(http::Admission& admission, SignInCodes& codes, const http::Request& request, ano::TimePoint now);

/// POST /login/code {"form": "link" or "digits", "access": "control" or "view"}: creates a code. 409 if no token has these
/// rights.
http::Response make_code(const http::Admission& admission, SignInCodes& codes, const http::Request& request, ano::TimePoint now);

/// POST /logout: the browser removes the cookie.
http::Response logout(const http::Admission& admission, const http::Request& request);

}    // namespace anogate
