// The message table, written out for people and for other programs.
#pragma once
#include <ano/flexible.hpp>
#include <ano_json/frame_json.hpp>

#include <iosfwd>

namespace anoctl {

/// The protocol reference (include/ano/messages.md).
void write_markdown(std::ostream& out);

/// A dissector for Wireshark, the layouts of flexible messages included: tshark -X lua_script:FILE.
void write_lua(std::ostream& out, const ano::FlexibleLayouts& flexible);

/// One row of the table.
ano::Json describe(const ano::Message& row);

}    // namespace anoctl
