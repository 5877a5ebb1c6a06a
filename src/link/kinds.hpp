// The kinds of link there are. A new kind is one file and one row here.
#pragma once
#include <gateway/ids.hpp>

#include <memory>
#include <span>
#include <string_view>

namespace anogate {

class Link;
struct LinkContext;
struct LinkSettings;

struct LinkKind {
    std::string_view name;       // "serial"
    std::string_view address;    // the key whose value is the ADDRESS of a LINK text: "device"
    std::string_view example;    // such an address
    std::string_view help;
    std::unique_ptr<Link> (*make)(LinkId, const LinkSettings&, const LinkContext&);
};

std::span<const LinkKind> link_kinds() noexcept;
/// nullptr when there is none of that name.
const LinkKind* find_link_kind(std::string_view name) noexcept;

/// A link of the kind that `settings.kind` names, not yet started.
std::unique_ptr<Link> make_link(LinkId id, const LinkSettings& settings, const LinkContext& context);

}    // namespace anogate
