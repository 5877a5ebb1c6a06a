// anoctl plot-udp IP:PORT: sends the frames of a gateway, or of a link of this process, to PlotJuggler's UDP server.
#include <anoctl/anoctl.hpp>
#include <anoctl/counted.hpp>
#include <anoctl/gateway_layouts.hpp>
#include <anoctl/own_link.hpp>
#include <anoctl/say.hpp>
#include <anoctl/text/frame_printer.hpp>
#include <anoctl/watch.hpp>
#include "plot_json.hpp"
#include "wanted_frames.hpp"

#include <ano_json/text.hpp>
#include <link/udp/error_queue.hpp>
#include <link/udp/ip_socket.hpp>
#include <sys/errors.hpp>

#include <cerrno>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace anoctl {
namespace {

using namespace anogate;

class Plotted final : public FrameReceiver {
public:
    Plotted(const Endpoint& to, const WantedFrames& wanted, const FrameOptions& frames, Streams& streams)
        : to_{to}, wanted_{wanted}, layouts_{frames.layouts()}, options_{frames.json_options(layouts_)}, streams_{streams} {
        EndpointSpec any;
        any.address = to.address.v6 ? *IpAddress::parse("::") : IpAddress::v4(0, 0, 0, 0);
        auto opened = open_udp(any, false);
        if (!opened) throw Failure{opened.error().text};
        socket_ = std::move(*opened);
        keep_error_reports(socket_.get(), to.address.v6);
    }

    bool accept(ano::FrameView frame, const Passage& passage) override {
        if (!wanted_.takes(frame)) return true;
        const auto objects = plot_json(frame, passage.link, passage.time, options_);
        if (objects.empty()) return true;
        bool all_left = true;
        for (const std::string& json : objects) all_left = send(json) && all_left;
        ++(all_left ? sent : not_sent);
        return true;
    }
    bool flush() override { return true; }
    void miss(std::uint64_t count, const std::string&, std::string_view) override { lost += count; }

    void sum_up(Streams& streams) const {
        std::string text = counted(sent, "frame") + " sent to " + to_.text();
        if (not_sent > 0) text += "; " + std::to_string(not_sent) + " failed: " + why;
        if (lost > 0) text += "; " + std::to_string(lost) + " dropped by the gateway because its buffer was full";
        print_note(streams, text);
    }

    std::uint64_t sent = 0, not_sent = 0, lost = 0;
    std::string why;

private:
    bool send(const std::string& json) {
        const std::span<const std::uint8_t> bytes{reinterpret_cast<const std::uint8_t*>(json.data()), json.size()};
        int error = send_datagram(socket_.get(), to_, bytes, to_.address.v6);
        if (may_be_reported(error)) {    // error of an earlier datagram; this one was not sent
            read_error_reports(socket_.get(), [this](const Endpoint&, const IpAddress&) { report_no_listener(); });
            if (error == EHOSTUNREACH || error == ENETUNREACH) report_unsent(error);    // the second attempt may succeed
            error = send_datagram(socket_.get(), to_, bytes, to_.address.v6);
        }
        if (error == 0) return true;
        why = error_text(error);
        if (error != EAGAIN && error != EINTR) report_unsent(error);
        return false;
    }

    void report_unsent(int error) {
        if (std::exchange(has_reported_unsent_, true)) return;
        print_note(streams_, "cannot send to " + to_.text() + ": " + error_text(error) + "; retrying with each frame");
    }

    void report_no_listener() {
        if (std::exchange(has_reported_no_listener_, true)) return;
        print_note(streams_, "nothing listens at " + to_.text() +
                                 "; start PlotJuggler's UDP Server there, with the protocol json. Frames are still sent");
    }

    const Endpoint to_;
    const WantedFrames wanted_;
    const ano::FlexibleLayouts layouts_;
    const ano::JsonOptions options_;
    Streams& streams_;
    UniqueFd socket_;
    bool has_reported_no_listener_ = false;    // the message that nothing listens was printed
    bool has_reported_unsent_ = false;
};

struct PlotOptions {
    std::string to, link;
    std::vector<std::string> ids, from, addresses, links, directions;
    FrameOptions frames;
    GatewayOptions gateway;

    int run(Streams& streams) const {
        const auto written = EndpointSpec::parse(to);
        if (!written || written->port == 0)
            throw UsageError{ano::in_quotes(to) +
                             " is not an IP address and a port such as 127.0.0.1:9870; host names are not "
                             "looked up"};
        const auto there = endpoint_now(*written);
        if (!there) throw Failure{no_interface(written->interface).text};
        FrameOptions options = frames;
        if (link.empty() && options.config.empty()) options.known = layouts_of_gateway(gateway);
        Plotted plotted{*there, {ids, from, addresses}, options, streams};
        const std::string why = link.empty() ? watch_frames(gateway.socket(), query(), plotted)
                                             : listen_at_link(plotted, streams);
        plotted.sum_up(streams);
        if (!why.empty()) throw Failure{why};
        return fine;
    }

private:
    std::string listen_at_link(Plotted& plotted, Streams& streams) const {
        if (!links.empty() || !directions.empty()) throw UsageError{"--link and --direction apply to a gateway; omit LINK"};
        listen(link, plotted, streams, "plot-udp");
        return {};
    }
    std::string query() const {
        return filter_words("id", ids) + filter_words("from", from) + filter_words("to", addresses) +
               filter_words("link", links) + (directions.empty() ? "&direction=in" : filter_words("direction", directions)) +
               "&elsewhere=no";
    }
};

}    // namespace

Run add_plot_udp(Options& options) {
    const auto self = std::make_shared<PlotOptions>();
    options.push_back({"to", &self->to, "IP:PORT", "Address of PlotJuggler's UDP Server, protocol json: 127.0.0.1:9870", true});
    options.push_back(
        {"link", &self->link, "LINK", "Link to listen on, as for monitor; without it, the frames of the running gateway"});
    options.push_back({"--id", &self->ids, "ID...", "Select only these messages, by name or id"});
    options.push_back({"--from", &self->from, "ADDRESS...", "Select only frames from these addresses"});
    options.push_back({"--to", &self->addresses, "ADDRESS...", "Select only frames to these addresses"});
    options.push_back({"--link", &self->links, "LINK...", "With a gateway: select only frames on these links, by name"});
    options.push_back({"--direction", &self->directions, "in|out|dropped...",
                       "With a gateway: select received, sent or dropped frames (default: in)"});
    GatewayOptions::add(options, self->gateway);
    FrameOptions::add_encoding(options, self->frames);
    options.push_back({"--config", &self->frames.config, "FILE", "Gateway configuration with the layouts of flexible messages"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
