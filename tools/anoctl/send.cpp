// anoctl send NAME FIELD=VALUE...: sends one frame through the running gateway.
#include <anoctl/text/frame_printer.hpp>
#include "anoctl.hpp"
#include "gateway.hpp"
#include "given_frame.hpp"

#include <ano/hex.hpp>
#include <http/client/client.hpp>

#include <nlohmann/json.hpp>

#include <memory>
#include <ostream>
#include <string>
#include <utility>

namespace anoctl {
namespace {

using Json = nlohmann::ordered_json;

struct Send {
    GivenFrame given;
    GatewayOptions gateway;
    FrameOptions frames;

    int run(Streams& streams) const {
        anogate::http::Request request;
        request.method = "POST";
        request.target = "/send";
        request.headers.push_back({"Content-Type", "application/json"});
        request.body = Json{{"hex", ano::hex(bytes())}}.dump();
        anogate::http::Outcome outcome = anogate::http::ask(gateway.socket(), std::move(request));
        if (!outcome.fault.empty()) throw Failure{outcome.fault};
        if (outcome.answer.status != 200) throw Failure{format_failure(outcome.answer)};
        if (frames.json) streams.out << outcome.answer.body;
        else print_result(Json::parse(outcome.answer.body, nullptr, false), streams);
        return fine;
    }

private:
    // NAME and the words after it may be the hex digits of a complete frame.
    std::vector<std::uint8_t> bytes() const {
        std::string digits = given.name;
        for (const std::string& word : given.fields) digits += word;
        const auto whole = ano::from_hex(digits);
        if (!whole || whole->empty() || whole->front() != ano::head) {
            const ano::FlexibleLayouts layouts = frames.layouts();
            return given.bytes(frames.json_options(layouts));
        }
        const auto frame = ano::frame_at(*whole);
        if (!frame || frame->bytes().size() != whole->size())
            throw UsageError{"the bytes are not exactly one valid frame; to find the fault: anoctl decode"};
        return *whole;
    }

    // "sent on ground (192.168.1.20:6000)"; "sent on fc" if the link has no other channels
    static void print_result(const Json& answer, Streams& streams) {
        const auto each = [&](const char* key, const char* words) {
            for (const Json& place : answer.value(key, Json::array())) {
                const std::string link = place.value("link", ""), peer = place.value("peer", "");
                streams.out << words << link;
                if (!peer.empty() && peer != link) streams.out << " (" << peer << ')';
                if (place.contains("cause")) streams.out << ": " << place.value("cause", "");
                streams.out << '\n';
            }
        };
        if (answer.contains("taken_by")) streams.out << "handled by the gateway itself\n";
        each("sent", "sent on ");
        each("waiting", "queued on ");
        each("dropped", "dropped on ");
    }
};

}    // namespace

Run add_send(Options& options) {
    const auto self = std::make_shared<Send>();
    GivenFrame::add(options, self->given, "Message, by name or id; or the hex digits of a complete frame");
    GatewayOptions::add(options, self->gateway);
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
