#include "manual.hpp"
#include "page.hpp"

#include <link/link_error.hpp>

namespace reference {

std::string api_page(std::span<const anogate::http::Routes::Row> rows) {
    Page page{"anogate-api", 7, "control interface of anogated"};
    page.section("DESCRIPTION");
    page.text(
        "HTTP/1.1 with JSON over a Unix socket: /run/anogate/control.sock of the service, $XDG_RUNTIME_DIR/anogate.sock of an "
        "ordinary user, or what --control and \"control\": {\"socket\"} say. The socket of the service is for its group, "
        "anogate. anoctl(1) asks it for people and scripts. Over TCP only where \"control\": {\"http\"} says so; who asks there "
        "gives a token, Authorization: Bearer TOKEN, unless a user started the gateway for himself on a loopback address.");
    page.section("ROUTES");
    page.text(
        "Each with what a token must allow where one is asked for: open (none is needed), view or control. Who answers GET "
        "answers HEAD as well.");
    page.begin_list();
    for (const auto& row : rows)
        page.item(row.method + " " + row.pattern, "", row.answers + " (" + std::string{text(row.access)} + ")");
    page.end_list();
    page.section("REFUSALS");
    page.text("An answer other than 200 has {\"error\": \"one clause\", \"what\": \"a word for programs\"}:");
    page.begin_list();
    page.item("400", "", "The request can't be meant");
    page.item("401, 403", "", "A token is needed, or one that allows more; or the Host or Origin is not one of this gateway");
    page.item("404", "", "There is no such route, link or address; the nearest route is named");
    page.item("405", "", "The path answers another method: header Allow");
    page.item("409", "", "What is asked for is not there at the moment");
    page.item("413", "", "The body is too large");
    page.item("415", "", "Over TCP a body is application/json or application/octet-stream");
    page.item("422", "", "The configuration has faults: \"faults\" lists them; or a recording can't be called or made like that");
    page.item("429", "", "Too early, or too many wrong tokens: \"wait_s\" or the header Retry-After says how long to wait");
    page.item("503", "", "All places are taken: header Retry-After");
    page.item("507", "", "There is no room on the disk for so large a body, or for a recording");
    page.end_list();
    page.section("RECORDINGS");
    page.text(
        "GET /recordings answers with what runs and what is in the folder, the newest first. Times are Unix seconds; frames and "
        "seconds, from the first frame to the last, are null where a file does not tell them, keep_last where nothing is kept. "
        "by is configuration or request, state recording, ended "
        "or "
        "unfinished.");
    page.literal(
        "{\"folder\": \"/var/lib/anogate/recordings\", \"free_bytes\": 12000000000, \"free_needed\": 505242880, \"error\": "
        "\"\",\n"
        " \"others\": 0,\n"
        " \"keep_last\": {\"seconds\": 60, \"held_s\": 59.9, \"frames\": 1200, \"bytes\": 48000, \"saved\": 2, \"skipped\": 0,\n"
        "               \"last\": \"20261123-154735Z-fault.pcapng\", \"error\": \"\"},\n"
        " \"running\": [{\"name\": \"flight\", \"by\": \"request\", \"file\": \"flight-2.pcapng\", \"files\": 2,\n"
        "              \"format\": \"pcapng\", \"frames\": 123, \"bytes\": 4567, \"file_frames\": 23,\n"
        "              \"file_bytes\": 967, \"file_seconds\": 2.1, \"not_written\": 0, \"error\": \"\",\n"
        "              \"since\": 1763898044.1, \"seconds\": 12.3, \"ends_in_s\": null}],\n"
        " \"recordings\": [{\"name\": \"flight.pcapng\", \"format\": \"pcapng\", \"bytes\": 4567, \"frames\": 123,\n"
        "                 \"seconds\": 5.9, \"begun\": 1763898044.1, \"time\": 1763898050, \"state\": \"ended\"}]}");
    page.text(
        "frames, bytes and seconds of one that runs are those of all its files, file_frames, file_bytes and file_seconds of the "
        "one that "
        "is written now, which file names. "
        "error of one that runs says why nothing of it is written now, and not_written how many frames are missing. others are "
        "files "
        "that the gateway did not write: they are neither listed, read nor deleted. The status has the same under recording, "
        "without "
        "the files.");
    page.section("ERRORS OF LINKS");
    page.text(
        "In the status each link has \"error\", a clause for people that is empty while all is well, \"error_id\" and "
        "\"error_args\":");
    page.begin_list();
    for (const anogate::LinkErrorId& row : anogate::link_error_ids)
        page.item(std::string{row.id} + (row.arguments.empty() ? "" : " {" + std::string{row.arguments} + "}"), "",
                  std::string{row.meaning});
    page.end_list();
    page.section("EXAMPLES");
    page.literal(
        "curl -sS --unix-socket /run/anogate/control.sock http://anogate/status\n"
        "curl -sS --unix-socket /run/anogate/control.sock http://anogate/gpio -d '{\"link\": \"fc\", \"use\": \"reset\"}'");
    page.see_also({"anoctl 1", "anogate.json 5", "anogated 8"});
    return page.str();
}

}    // namespace reference
