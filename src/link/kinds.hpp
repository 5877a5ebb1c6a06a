// The kinds of link there are. A new kind is one file and one row here.
#pragma once
#include <span>
#include <string_view>

namespace anogate {

struct LinkKind {
    std::string_view name;       // "serial"
    std::string_view address;    // the key whose value is the ADDRESS of a LINK text: "device"
    std::string_view example;    // such an address
    std::string_view help;
    // The factory is to stand here: std::unique_ptr<Link> (*make)(...)
};

std::span<const LinkKind> link_kinds() noexcept;
/// nullptr when there is none of that name.
const LinkKind* find_link_kind(std::string_view name) noexcept;

}  // namespace anogate
