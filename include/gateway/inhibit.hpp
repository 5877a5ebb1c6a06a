// A switch that blocks commands to the vehicle.
#pragma once
#include <gateway/ids.hpp>

#include <cstddef>
#include <vector>

namespace anogate {

/// Inhibit switches and the links they block. A switch is on until set() sets it off, so a switch that can't be read is on.
class Inhibit {
public:
    /// Returns the index of the switch, the lowest free one.
    std::size_t add(LinkSet links) {
        std::size_t place = 0;
        while (place < switches_.size() && switches_[place].used) ++place;
        if (place == switches_.size()) switches_.emplace_back();
        switches_[place] = {links, true, true};
        gather();
        return place;
    }
    /// Removes the switch: it no longer blocks links.
    void remove(std::size_t place) noexcept {
        switches_[place] = {};
        gather();
    }
    /// Changes the links that it blocks while it is on.
    void set_links(std::size_t place, LinkSet links) noexcept {
        switches_[place].links = links;
        gather();
    }
    void set(std::size_t place, bool on) noexcept {
        switches_[place].on = on;
        gather();
    }
    /// Call when the link is removed, so that no switch blocks the next link with its number.
    void remove_link(LinkId link) noexcept {
        for (Switch& s : switches_) s.links.erase(link);
        gather();
    }
    bool is_on(std::size_t place) const noexcept { return switches_[place].on; }
    /// The links whose control frames are dropped.
    LinkSet links() const noexcept { return links_; }

private:
    void gather() noexcept {
        links_.clear();
        for (const Switch& s : switches_)
            if (s.on) links_ |= s.links;
    }

    struct Switch {
        LinkSet links{};
        bool on = false;
        bool used = false;
    };
    std::vector<Switch> switches_;
    LinkSet links_;
};

}    // namespace anogate
