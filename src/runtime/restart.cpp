#include <link/clocks.hpp>
#include <log/log_line.hpp>
#include <runtime/restart.hpp>
#include <sys/descriptor_store.hpp>

#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>

namespace anogate {
namespace {

constexpr char state_name[] = "state";
constexpr char wire_name[] = "wire";
constexpr off_t max_state = 1 << 20;    // bytes; 64 channels with all addresses each need about 400 KB

UniqueFd find(std::vector<NamedDescriptor>& descriptors, const std::string& name) {
    for (auto& [its_name, fd] : descriptors)
        if (its_name == name) return std::move(fd);
    return {};
}

UniqueFd find(std::vector<NamedDescriptor>& descriptors, const WireIdentity& wire) {
    for (auto& [name, fd] : descriptors)
        if (name == wire_name && fd && WireIdentity::of(fd.get()) == wire) return std::move(fd);
    return {};
}

std::string read_all(const UniqueFd& file) {
    struct stat info {};
    if (!file || ::fstat(file.get(), &info) != 0 || !S_ISREG(info.st_mode) || info.st_size > max_state) return {};
    std::string text(static_cast<std::size_t>(info.st_size), '\0');
    const ssize_t n = ::pread(file.get(), text.data(), text.size(), 0);
    text.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return text;
}

UniqueFd memory_with(const std::string& text) {
    UniqueFd file{::memfd_create("anogate-state", MFD_CLOEXEC)};
    if (!file || ::write(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) return {};
    return file;
}

}    // namespace

RestartState receive_restart_state() {
    std::vector<NamedDescriptor> descriptors = receive_descriptors();
    auto state = parse_restart_state(read_all(find(descriptors, state_name)), read_clocks());
    if (!state) return {};
    for (RestartState::OfLink& link : state->links) link.link.wire = find(descriptors, link.wire);
    return std::move(*state);
}

void send_restart_state(const Gateway& gateway, const ClockReading& unread_since) {
    if (!std::getenv("NOTIFY_SOCKET")) return;
    const RestartState state = state_of(gateway, unread_since);
    const UniqueFd text = memory_with(to_string(state));
    std::vector<int> wires;
    for (const RestartState::OfLink& link : state.links)
        if (link.link.wire) wires.push_back(link.link.wire.get());
    const int texts[] = {text.get()};
    const bool is_stored = text && (wires.empty() || store_descriptors(wire_name, wires)) &&
                           store_descriptors(state_name, texts) && await_systemd();
    if (!is_stored) log_warning("systemd does not answer: a restart reopens all links");
}

}    // namespace anogate
