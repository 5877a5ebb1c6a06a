#include <http/client_text.hpp>
#include <sys/local_client.hpp>

namespace anogate::http {

std::string format_client(const Request& request) {
    if (request.connection_info.is_network) return request.connection_info.peer;
    return request.user == unknown_user ? std::string{} : local_client(request.user, request.connection_info.process);
}

}    // namespace anogate::http
