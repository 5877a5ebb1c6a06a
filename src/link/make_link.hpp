// LinkKind::make for most kinds of links.
#pragma once
#include <link/link_context.hpp>

#include <memory>

namespace anogate {

template <class OneLink>
std::unique_ptr<Link> make_link_of(LinkId id, const LinkSettings& settings, const LinkContext& context) {
    return std::make_unique<OneLink>(id, settings, context);
}

}    // namespace anogate
