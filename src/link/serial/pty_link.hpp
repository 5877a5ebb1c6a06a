// Makes a pseudo-terminal and links a path to it, for programs that expect a serial port.
#pragma once
#include <link/serial/pty_settings.hpp>
#include <link/stream_link.hpp>
#include <sys/files/path_lock.hpp>

namespace anogate {

/// Up while a program has it open: data sent earlier would be stale when a program reads it.
class PtyLink final : public StreamLink, public KernelQueue {
public:
    PtyLink(LinkId id, LinkSettings settings, const LinkContext& context)
        : StreamLink{id, std::move(settings), context}, watch_{context.io}, look_{context.alarms, [this] { look(); }} {
        translate(this->settings().as<PtySettings>().v7, this->settings());
    }
    void stop_reading() override;
    void stop() override;
    std::size_t unsent() const override;
    LinkFacts facts() const override;
    bool write_raw(std::span<const std::uint8_t> bytes) override { return up_ && StreamLink::write_raw(bytes); }

private:
    Opened<UniqueFd> open_wire() override;
    const std::string& peer() const override { return settings().as<PtySettings>().path; }
    void leave_wire(int fd) override;
    void read_ended(int error) override;
    LinkError why_gone(int error) const override;
    void came_up() override;

    Expected<void> link_path();
    void watch_users();
    void watch_path();
    void keep_path();
    void look();
    void look_for_users();
    void users_gone();
    UniqueFd open_user_side() const;
    LinkError no_user_error() const;

    std::string device_;    // /dev/pts/N
    PathLock lock_;         // so that only one gateway makes this path
    Descriptor watch_;      // inotify: device_ was opened, or the link at the path was changed
    Alarm look_;            // polls instead if inotify is not available
    bool up_ = false;
};

}    // namespace anogate
