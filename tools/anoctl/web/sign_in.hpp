// Signs a browser in with a one-time code of the gateway, instead of a typed token.
#pragma once
#include <anoctl/gateway.hpp>

#include <ano_json/frame_json.hpp>

#include <string>

namespace anoctl {

struct SignIn {
    enum class Form { link, digits };

    const GatewayOptions& gateway;
    bool view = false;    // with the read-only token

    /// The response of POST /login/code: "code" and "expires_s".
    ano::Json code(Form form) const;
    /// `page` with a code appended.
    std::string link(const std::string& page) const;
    /// Opens `page` in a browser on this computer, signed in. Throws Failure, with the link, if no browser signs in within a
    /// minute.
    void open(const std::string& page) const;
};

}    // namespace anoctl
