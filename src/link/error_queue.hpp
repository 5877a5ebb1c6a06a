// What the network says of datagrams that left by a socket with many peers: the kernel keeps it with the endpoint that each was
// for, and fails one later call, whoever that is for.
#pragma once
#include <gateway/ip.hpp>

#include <cstddef>
#include <functional>

namespace anogate {

/// Makes the kernel keep it.
void keep_error_reports(int fd, bool v6_socket) noexcept;

/// Whether a call may have failed with `error` by what such a report says. It may mean the call itself all the same.
bool may_be_reported(int error) noexcept;

/// Takes what is kept, at most 64 reports, and calls `on_refused` for each that says that nothing listens there. Returns how many
/// came from the network: while there are any, a call may fail for no reason of its own.
std::size_t take_error_reports(int fd, const std::function<void(const Endpoint&)>& on_refused);

}    // namespace anogate
