// Sends requests to the control interface of a gateway, with the client of anoctl.
#pragma once
#include "wait.hpp"

#include <http/client/client.hpp>

#include <gtest/gtest.h>

#include <string>

namespace support {

/// Returns the response. The test fails if there is none.
inline anogate::http::Answer asked(const std::string& socket, const std::string& method, const std::string& target,
                                   const std::string& body = {}, const std::string& accept = {}) {
    anogate::http::Request request;
    request.method = method;
    request.target = target;
    request.body = body;
    if (target.find("/firmware") != std::string::npos) request.headers.push_back({"Content-Type", "application/octet-stream"});
    if (!accept.empty()) request.headers.push_back({"Accept", accept});
    const anogate::http::Outcome outcome = anogate::http::ask(socket, request, {.patience = patience});
    EXPECT_EQ(outcome.fault, "") << method << ' ' << target;
    return outcome.answer;
}

}    // namespace support
