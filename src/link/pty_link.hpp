// Makes a pseudo-terminal and links a path to it, for programs that expect a serial port.
#pragma once
#include <link/stream_link.hpp>

namespace anogate {

/// Up while a program has it open: what is sent while nobody reads would be stale when somebody does.
class PtyLink final : public StreamLink {
public:
    PtyLink(LinkId id, LinkSettings settings, const LinkContext& context)
        : StreamLink{id, std::move(settings), context}, watch_{context.io} {}
    void stop() override;
    LinkFacts facts() const override;

private:
    Opened open_wire() override;
    void leave_wire(int fd) override;
    void heard() override;
    std::string gone_text(int error) const override;
    void came_up() override;

    std::string link_path(const std::string& device);
    void watch_users();
    void count_users();
    void users_gone();

    UniqueFd user_side_;     // kept open, so that a user who closes his does not hang ours up
    std::string device_;     // /dev/pts/N
    Descriptor watch_;       // inotify on device_
    int users_ = 0;
    bool up_ = false;
};

}  // namespace anogate
