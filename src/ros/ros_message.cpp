#include <ros/ros_message.hpp>

#include <algorithm>
#include <array>

namespace anogate {
namespace {

// Each nested message once, in the order of first use.
void collect(const RosMessage& message, std::vector<const RosMessage*>& all) {
    for (const RosField& f : message.fields) {
        if (f.message == nullptr || std::find(all.begin(), all.end(), f.message) != all.end()) continue;
        all.push_back(f.message);
        collect(*f.message, all);
    }
}

std::string type_text(const RosField& f) {
    std::string text = f.message != nullptr ? f.message->package + '/' + f.message->name : std::string{name_of(f.type)};
    if (f.shape == RosField::Shape::sequence) text += "[]";
    if (f.shape == RosField::Shape::array) text += '[' + std::to_string(f.count) + ']';
    return text;
}

// Removes line breaks: texts of a configuration may contain them, and they would end the comment.
void append_comment(std::string_view comment, std::string& out) {
    out += "# ";
    for (const char c : comment) out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? ' ' : c;
}

void append_definition(const RosMessage& message, std::string& out) {
    if (!message.comment.empty()) {
        append_comment(message.comment, out);
        out += '\n';
    }
    for (const RosField& f : message.fields) {
        for (const RosConstant& constant : f.constants)
            out += std::string{name_of(f.type)} + ' ' + constant.name + '=' + std::to_string(constant.value) + '\n';
        out += type_text(f) + ' ' + f.name;
        if (!f.comment.empty()) append_comment(f.comment, out += "    ");
        out += '\n';
    }
    if (message.fields.empty()) out += "uint8 structure_needs_at_least_one_member\n";
}

}    // namespace

std::string_view name_of(RosType type) noexcept {
    static constexpr std::array<std::string_view, 14> names{"bool",   "byte",  "int8",   "uint8",   "int16",   "uint16", "int32",
                                                            "uint32", "int64", "uint64", "float32", "float64", "string", ""};
    return names[static_cast<std::size_t>(type)];
}

std::string full_name(const RosMessage& message) { return message.package + "/msg/" + message.name; }

std::string definition_of(const RosMessage& message) {
    std::vector<const RosMessage*> parts;
    collect(message, parts);
    std::string out;
    append_definition(message, out);
    for (const RosMessage* part : parts) {
        out += std::string(80, '=') + "\nMSG: " + part->package + '/' + part->name + '\n';
        append_definition(*part, out);
    }
    return out;
}

}    // namespace anogate
