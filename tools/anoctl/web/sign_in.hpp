// Signs a browser in without typing a token, by a one-time code of the gateway.
#pragma once
#include <anoctl/gateway.hpp>

#include <ano_json/frame_json.hpp>

#include <string>

namespace anoctl {

struct SignIn {
    enum class Form { link, digits };

    const GatewayOptions& gateway;
    bool view = false;    // for watching only: the read-only token

    /// What POST /login/code answers: "code" and "expires_s".
    ano::Json code(Form form) const;
    /// `page` with the code of a link.
    std::string link(const std::string& page) const;
    /// Opens `page` in a browser here that is signed in then. Throws Failure, with the link, when no browser did so within a minute.
    void open(const std::string& page) const;
};

}    // namespace anoctl
