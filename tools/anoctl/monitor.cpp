// anoctl monitor LINK: the frames received on a link of this process; without LINK, those of the running gateway.
#include <anoctl/recording/wanted_frames.hpp>
#include <anoctl/text/frame_printer.hpp>
#include "anoctl.hpp"
#include "gateway_layouts.hpp"
#include "own_link.hpp"
#include "watch.hpp"

#include <ano_json/text.hpp>

#include <cstdint>
#include <memory>
#include <ostream>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace anoctl {
namespace {

using namespace anogate;

/// Prints the wanted frames, up to the wanted number.
class Shown final : public FrameReceiver {
public:
    Shown(const WantedFrames& wanted, std::uint64_t count, Streams& streams, const FrameOptions& frames)
        : wanted_{wanted}, left_{count}, streams_{streams}, printer_{streams, frames} {}

    bool accept(ano::FrameView frame, const Passage& passage) override {
        ++seen;
        if (!wanted_.takes(frame)) return true;
        printer_.print(frame, passage);
        ++shown;
        return left_ == 0 || --left_ > 0;
    }
    bool flush() override { return bool{streams_.out.flush()}; }
    void miss(std::uint64_t, const std::string&, std::string_view) override {}

    std::uint64_t seen = 0, shown = 0;

private:
    const WantedFrames wanted_;
    std::uint64_t left_;    // 0: no limit
    Streams& streams_;
    FramePrinter printer_;
};

struct MonitorOptions {
    std::string link;
    std::vector<std::string> ids, from, to, links, directions;
    std::uint64_t count = 0;
    FrameOptions frames;
    GatewayOptions gateway;

    int run(Streams& streams) const {
        if (link.empty()) return attach(streams);
        if (!links.empty() || !directions.empty()) throw UsageError{"--link and --direction apply to a gateway; omit LINK"};
        Shown shown{{ids, from, to},
                    count,
                    streams,
                    options_for(link_settings_of(link, "for a link of the gateway, give its name: monitor --link"))};
        const std::uint64_t skipped = listen(link, shown, streams, "monitor");
        streams.out.flush();
        streams.err << "anoctl: " << shown.shown << (shown.shown == 1 ? " frame" : " frames") << " shown of " << shown.seen
                    << ", " << skipped << " bytes outside any frame\n";
        return fine;
    }

private:
    int attach(Streams& streams) const {
        for (const auto* words : {&ids, &from, &to, &links, &directions})    // these options consume all words after them
            for (const std::string& word : *words)
                if (word.find(':') != word.npos) throw UsageError{ano::in_quotes(word) + ": place LINK before the options"};
        const std::vector<std::string> once{"in"};
        const std::string query = filter_words("id", ids) + filter_words("from", from) + filter_words("to", to) +
                                  filter_words("link", links) + filter_words("direction", directions.empty() ? once : directions);
        FrameOptions options = frames;
        if (options.config.empty()) options.known = layouts_of_gateway(gateway);
        return watch({gateway.socket(), query, count, options}, streams);
    }
    // The options of the command line; where they are not given, those of the link.
    FrameOptions options_for(const LinkSettings& settings) const {
        FrameOptions options = frames;
        if (!options.encoding && settings.encoding)
            options.encoding = *settings.encoding == TextEncoding::gbk ? ano::Encoding::gbk : ano::Encoding::utf8;
        if (!options.value_type_7) options.value_type_7 = settings.meaning_of_type_7();
        return options;
    }
};

}    // namespace

Run add_monitor(Options& options) {
    const auto self = std::make_shared<MonitorOptions>();
    const auto read_count = [self](const std::string& word) -> std::string {
        const auto number = ano::parse_number(word);
        const auto* count = number ? std::get_if<std::uint64_t>(&*number) : nullptr;
        if (count == nullptr || *count == 0) return ano::in_quotes(word) + " is not a number of frames, 1 or more";
        self->count = *count;
        return {};
    };
    options.push_back({"link", &self->link, "LINK",
                       "Link to listen on, as for anogated: serial:/dev/ttyUSB0,baud=500000 udp-listen:0.0.0.0:12333 pty:PATH; "
                       "without it, show each frame that the running gateway receives, once"});
    options.push_back({"--id", &self->ids, "ID...", "Select only these messages, by name or id"});
    options.push_back({"--from", &self->from, "ADDRESS...", "Select only frames from these addresses"});
    options.push_back({"--to", &self->to, "ADDRESS...", "Select only frames to these addresses"});
    options.push_back({"--link", &self->links, "LINK...", "With a gateway: select only frames on these links, by name"});
    options.push_back({"--direction", &self->directions, "in|out|dropped...",
                       "With a gateway: frames received (in, the default), sent (out), or dropped (with the reason); a forwarded "
                       "frame appears as in and as out"});
    options.push_back({"--count", Option::Read{read_count}, "N", "Exit after N frames"});
    GatewayOptions::add(options, self->gateway);
    FrameOptions::add(options, self->frames);
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
