#include "manual.hpp"
#include "page.hpp"

#include <ano/faults.hpp>
#include <link/link_error.hpp>

namespace reference {

std::string api_page(std::span<const anogate::http::Routes::Row> rows) {
    Page page{"anogate-api", 7, "control interface of anogated"};
    page.section("DESCRIPTION");
    page.text(
        "anogated serves HTTP/1.1 with JSON on a Unix socket: /run/anogate/control.sock for the service, "
        "$XDG_RUNTIME_DIR/anogate.sock for an ordinary user, or the path from --control or \"control\": {\"socket\"}. The socket "
        "of the service is accessible to the group anogate. anoctl(1) is its client for people and scripts. The interface is "
        "available over TCP only if \"control\": {\"http\"} is set; requests over TCP require a token, Authorization: Bearer "
        "TOKEN, unless an ordinary user started the gateway on a loopback address.");
    page.section("ROUTES");
    page.text(
        "Each route is listed with the token that it requires over TCP: open (no token), view or control. Routes that support "
        "GET also support HEAD.");
    page.begin_list();
    for (const auto& row : rows)
        page.item(row.method + " " + row.pattern, "", row.answers + " (" + std::string{text(row.access)} + ")");
    page.end_list();
    page.section("ERROR RESPONSES");
    page.text(
        "Responses other than 200 contain {\"error\": \"a message for people\", \"what\": \"its kind\", \"error_id\": \"its "
        "id\", "
        "\"error_args\": {its arguments}}, and so do jobs that failed; the ids are listed below:");
    page.begin_list();
    page.item("400", "", "The request is malformed");
    page.item("401, 403", "",
              "The token is missing or has insufficient rights; or the Host or Origin header does not belong to this gateway");
    page.item("404", "", "The route, link or address does not exist; the error suggests the nearest route");
    page.item("405", "", "The path does not support this method; see the header Allow");
    page.item("409", "", "The requested resource is not available at the moment");
    page.item("413", "", "The body is too large");
    page.item("415", "", "Over TCP the body must be application/json or application/octet-stream");
    page.item("422", "",
              "The configuration is invalid (\"faults\" lists the errors), or the name or format of a recording is invalid");
    page.item("429", "", "Too many requests or wrong tokens; \"wait_s\" or the header Retry-After gives the time to wait");
    page.item("503", "", "Too many connections or requests; see the header Retry-After");
    page.item("507", "", "The disk has not enough space for the body or the recording");
    page.end_list();
    page.section("RECORDINGS");
    page.text(
        "GET /recordings returns the running recordings and the files in the folder, newest first. Times are Unix seconds. "
        "frames and seconds (from the first frame to the last) are null if the file does not contain them; keep_last is null if "
        "no frames are kept in memory. by is configuration or request; state is recording, ended or unfinished.");
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
        "For a running recording, frames, bytes and seconds cover all its files; file_frames, file_bytes and file_seconds cover "
        "the current file, named by file. error gives the reason if the recording cannot be written now; not_written counts the "
        "missing frames. others counts files that the gateway did not write: it does not list, read or delete them. The status "
        "contains the same data under recording, without the files.");
    page.section("LINK ERRORS");
    page.text(
        "In the status each link has \"error\", a message for people that is empty without an error, \"error_id\" and "
        "\"error_args\":");
    page.begin_list();
    for (const anogate::LinkErrorId& row : anogate::link_error_ids)
        page.item(std::string{row.id} + (row.arguments.empty() ? "" : " {" + std::string{row.arguments} + "}"), "",
                  std::string{row.meaning});
    page.end_list();
    page.section("ERROR IDS");
    page.text(
        "The values of \"error_id\" with the text in \"error\", in which {name} is an argument of \"error_args\". An argument "
        "that is a "
        "clause is an object {\"error_id\", \"error_args\"}. \"error_remarks\" is a list of such objects: further clauses, which "
        "follow in "
        "the text.");
    page.begin_list();
    for (const ano::FaultRow& row : ano::fault_rows) page.item(std::string{row.id}, "", std::string{row.english});
    page.end_list();
    page.section("EXAMPLES");
    page.literal(
        "curl -sS --unix-socket /run/anogate/control.sock http://anogate/status\n"
        "curl -sS --unix-socket /run/anogate/control.sock http://anogate/gpio -d '{\"link\": \"fc\", \"use\": \"reset\"}'");
    page.see_also({"anoctl 1", "anogate.json 5", "anogated 8"});
    return page.str();
}

}    // namespace reference
