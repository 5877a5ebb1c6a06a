#include <daemon/descriptor_store.hpp>
#include <daemon/handover.hpp>
#include <link/clocks.hpp>

#include <spdlog/spdlog.h>

#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>

namespace anogate {
namespace {

constexpr char state_name[] = "state";
constexpr off_t max_state = 4 << 20;    // bytes; 64 channels that each know every address are some 400 KB

std::string wire_name(std::size_t place) { return "wire-" + std::to_string(place); }

UniqueFd find(std::vector<NamedDescriptor>& descriptors, const std::string& name) {
    for (auto& [its_name, fd] : descriptors)
        if (its_name == name) return std::move(fd);
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

StoredState take_handover() {
    std::vector<NamedDescriptor> descriptors = take_descriptors();
    auto state = parse_stored_state(read_all(find(descriptors, state_name)), read_clocks());
    if (!state) return {};
    for (std::size_t i = 0; i < state->links.size(); ++i) state->links[i].link.wire = find(descriptors, wire_name(i));
    return std::move(*state);
}

void hand_over(const Gateway& gateway) {
    if (!std::getenv("NOTIFY_SOCKET")) return;
    StoredState state = state_of(gateway);
    std::vector<NamedDescriptor> descriptors;
    descriptors.emplace_back(state_name, memory_with(text_of(state)));
    if (!descriptors.front().second) return;
    for (std::size_t i = 0; i < state.links.size(); ++i)
        if (state.links[i].link.wire) descriptors.emplace_back(wire_name(i), std::move(state.links[i].link.wire));
    if (!store_descriptors(descriptors)) spdlog::warn("systemd did not take all wires: a restart opens them again");
}

}    // namespace anogate
