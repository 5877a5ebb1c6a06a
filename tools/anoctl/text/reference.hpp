// The message table in formats for people and for other programs.
#pragma once
#include <ano/flexible.hpp>
#include <ano/messages.hpp>

#include <iosfwd>
#include <string>

namespace anoctl {

/// The protocol reference (include/ano/messages.md).
void write_markdown(std::ostream& out);

/// A dissector for Wireshark, including the layouts of flexible messages: tshark -X lua_script:FILE.
void write_lua(std::ostream& out, const ano::FlexibleLayouts& flexible);

/// A layout for a terminal: all fields with type, unit, range and values.
void write_details(std::ostream& out, const ano::Message& row, bool color);

/// "u16", "text[20]", "bytes, to the end".
std::string type_text(const ano::Field& field);
/// The DATA values that select a layout, after a comma; empty for a base layout.
std::string selection_rule(const ano::Message& row);

}    // namespace anoctl
