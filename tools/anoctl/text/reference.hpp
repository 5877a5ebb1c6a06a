// The message table, written out for people and for other programs.
#pragma once
#include <ano/flexible.hpp>
#include <ano/messages.hpp>

#include <iosfwd>
#include <string>

namespace anoctl {

/// The protocol reference (include/ano/messages.md).
void write_markdown(std::ostream& out);

/// A dissector for Wireshark, the layouts of flexible messages included: tshark -X lua_script:FILE.
void write_lua(std::ostream& out, const ano::FlexibleLayouts& flexible);

/// A layout for people on a terminal: every field with its type, unit, range and values.
void write_details(std::ostream& out, const ano::Message& row, bool color);

/// "u16", "text[20]", "bytes, to the end".
std::string type_text(const ano::Field& field);
/// The DATA that selects a layout, after a comma; empty for a base layout.
std::string taken_for(const ano::Message& row);

}    // namespace anoctl
