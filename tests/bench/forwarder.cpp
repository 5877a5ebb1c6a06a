#include "forwarder.hpp"

namespace bench {

Forwarder::Forwarder(std::size_t outputs) {
    for (std::size_t i = 0; i < outputs; ++i) takers.push_back(std::make_unique<Socket>());
}

std::uint64_t Forwarder::frames() const {
    return gateway ? gateway->link("out0").at("frames_out").get<std::uint64_t>() : *loop_frames;
}

std::vector<int> Forwarder::taken_at() const {
    std::vector<int> fds;
    for (const auto& taker : takers) fds.push_back(taker->fd());
    return fds;
}

std::vector<std::string> Forwarder::links_out(const std::string& keys) const {
    std::vector<std::string> links{"--route", "0x42=out0"};
    for (std::size_t i = 0; i < takers.size(); ++i)
        links.push_back("udp:" + takers[i]->text() + ",name=out" + std::to_string(i) + keys);
    return links;
}

Forwarder anogated_from_udp(const std::string& program, std::size_t outputs, const std::string& keys,
                            const std::vector<std::string>& tracer) {
    Forwarder forwarder{outputs};
    std::vector<std::string> links = forwarder.links_out(keys);
    links.push_back("udp-listen:127.0.0.1:0,name=in");
    forwarder.gateway = std::make_unique<GatewayProcess>(program, links, tracer);
    forwarder.port = forwarder.gateway->port("in");
    return forwarder;
}

Forwarder anogated_from_pty(const std::string& program) {
    Forwarder forwarder{1};
    forwarder.ptys = std::make_unique<TalkingPtys>(1, target, 0);
    std::vector<std::string> links = forwarder.links_out("");
    links.push_back("serial:" + forwarder.ptys->path(0) + ",name=in");
    forwarder.gateway = std::make_unique<GatewayProcess>(program, links);
    return forwarder;
}

Forwarder bare_from_udp(std::size_t outputs, std::size_t pack) {
    Forwarder forwarder{outputs};
    const Socket in;
    std::vector<Socket> senders(outputs);
    std::vector<int> out;
    for (std::size_t i = 0; i < outputs; ++i) {
        senders[i].connect(forwarder.takers[i]->port());
        out.push_back(senders[i].fd());
    }
    std::uint64_t* const frames = forwarder.loop_frames = shared_word();
    forwarder.loop = std::make_unique<support::Child>([&] {
        stay_on_second_processor();
        bare_loop(in.fd(), out, pack, frames);
        return 0;
    });
    forwarder.port = in.port();
    return forwarder;
}

}    // namespace bench
