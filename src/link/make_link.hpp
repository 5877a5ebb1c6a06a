#pragma once
#include <link/link_context.hpp>

namespace anogate {

/// A link of the kind that `settings.kind` names, not yet started.
std::unique_ptr<Link> make_link(LinkId id, const LinkSettings& settings, const LinkContext& context);

}  // namespace anogate
