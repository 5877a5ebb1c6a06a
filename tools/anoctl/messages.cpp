// anoctl messages: prints the message table.
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/text/reference.hpp>
#include "anoctl.hpp"

#include <ano/messages.hpp>
#include <ano_json/describe.hpp>
#include <ano_json/escapes.hpp>

#include <nlohmann/json.hpp>

#include <array>
#include <cstdio>
#include <memory>
#include <ostream>
#include <string>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using namespace ano;

void write_row(std::ostream& out, const Message& row, bool color) {
    std::array<char, 64> start{};
    std::snprintf(start.data(), start.size(), "0x%02X %-16.*s %-9.*s", row.id, static_cast<int>(row.name.size()), row.name.data(),
                  static_cast<int>(name_of(row.traffic.traffic_class).size()), name_of(row.traffic.traffic_class).data());
    out << start.data() << ' ' << row.title << (color ? "\x1b[2m" : "") << ':';
    for (const Field& f : row.fields()) out << ' ' << f.name;
    if (row.fields().empty()) out << " as configured";
    out << (color ? "\x1b[0m" : "") << '\n';
}

struct Messages {
    std::vector<std::string> names;
    bool markdown = false, json = false, lua = false;
    std::string config;

    int run(Streams& streams) const {
        FrameOptions options;
        options.config = config;
        if (markdown) write_markdown(streams.out);
        else if (lua) write_lua(streams.out, options.layouts());
        else if (json && names.empty())
            for (const Json& row : describe_all(options.layouts())) streams.out << ano::json_text(row) << '\n';
        else
            for (const Message& row : chosen()) {
                if (json) streams.out << ano::json_text(describe(row)) << '\n';
                else if (!names.empty()) write_details(streams.out, row, streams.color);
                else write_row(streams.out, row, streams.color);
            }
        return fine;
    }

private:
    std::vector<Message> chosen() const {
        if (names.empty()) return {messages.begin(), messages.end()};
        std::vector<Message> rows;
        for (const std::string& name : names) {
            const auto layouts = layouts_of(message_id_of(name));
            if (layouts.empty()) throw UsageError{"id " + name + " is not listed"};
            rows.insert(rows.end(), layouts.begin(), layouts.end());
        }
        return rows;
    }
};

}    // namespace

Run add_messages(Options& options) {
    const auto self = std::make_shared<Messages>();
    options.push_back({"names", &self->names, "[NAME...]",
                       "Show these messages, by name or id: types, units, ranges and values of their fields"});
    options.push_back(
        {"--markdown", &self->markdown, "", "Print the protocol reference as Markdown", false, {"--json", "--lua"}});
    options.push_back({"--json", &self->json, "", "Print one JSON object per layout and line", false, {"--lua"}});
    options.push_back({"--lua", &self->lua, "", "Print a Wireshark dissector: tshark -X lua_script:FILE"});
    options.push_back(
        {"--config", &self->config, "FILE",
         "With --lua, or with --json for all messages: gateway configuration with the layouts of flexible messages"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
