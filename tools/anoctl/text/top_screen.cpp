#include "top_screen.hpp"
#include "gateway_json.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <tuple>

namespace anoctl {
namespace {

using Status = nlohmann::json;

// A member of a status; empty if it is missing or of another type.
const Status& member_of(const Status& object, std::string_view key) {
    static const Status nothing;
    if (!object.is_object()) return nothing;
    const auto found = object.find(std::string{key});
    return found != object.end() ? *found : nothing;
}
std::string text_member(const Status& object, std::string_view key) {
    const Status& value = member_of(object, key);
    return value.is_string() ? value.get<std::string>() : std::string{};
}
std::uint64_t count_at(const Status& object, std::string_view key) {
    const Status& value = member_of(object, key);
    return value.is_number_integer() && value >= 0 ? value.get<std::uint64_t>() : 0;
}
std::optional<double> seconds_at(const Status& object, std::string_view key) {
    const Status& value = member_of(object, key);
    return value.is_number() ? std::optional{value.get<double>()} : std::nullopt;
}

const Status& named(const Status& list, std::string_view key, const std::string& name) {
    static const Status nothing;
    if (list.is_array())
        for (const Status& entry : list)
            if (text_member(entry, key) == name) return entry;
    return nothing;
}

std::string number(double value) {
    std::array<char, 32> text{};
    if (value >= 100'000) std::snprintf(text.data(), text.size(), "%.0fk", value / 1000);
    else std::snprintf(text.data(), text.size(), value >= 100 || value == 0 ? "%.0f" : "%.1f", value);
    return text.data();
}

std::string age_text(std::optional<double> age) {
    if (!age) return "-";
    if (*age >= 3600) return std::to_string(static_cast<std::uint64_t>(*age / 3600)) + " h";
    if (*age >= 60) return std::to_string(static_cast<std::uint64_t>(*age / 60)) + " min";
    return number(*age) + " s";
}

double rate(const Status& before, const Status& now, std::string_view counter, double seconds) {
    if (!before.is_object() || seconds <= 0) return 0;
    const std::uint64_t then = count_at(before, counter), since = count_at(now, counter);
    return since >= then ? static_cast<double>(since - then) / seconds : 0;
}

void add_rates(TopChannel& row, const Status& before, const Status& now, double seconds, bool is_alone) {
    row.in = rate(before, now, "frames_in", seconds);
    row.out = rate(before, now, "frames_out", seconds);
    row.waiting = count_at(now, "waiting");
    for (const std::string& cause : drop_causes(is_alone)) {
        const double of_it = rate(before, now, cause, seconds);
        if (of_it == 0) continue;
        row.dropped += of_it;
        row.causes.append(row.causes.empty() ? "" : ", ").append(cause).append(" ").append(number(of_it));
    }
}

void add_link(TopView& view, const Status& before, const Status& now, double seconds) {
    const std::string name = text_member(now, "name");
    const Status& channels = member_of(now, "channels");
    if (!channels.is_array() || channels.empty()) {
        TopChannel row{name, "-"};
        add_rates(row, before, now, seconds, is_alone(now));
        if (row.causes.empty()) row.causes = text_member(now, "error");
        view.channels.push_back(std::move(row));
        return;
    }
    for (const Status& channel : channels) {
        TopChannel row{name, text_member(channel, "peer")};
        add_rates(row, named(member_of(before, "channels"), "peer", row.peer), channel, seconds, is_alone(now));
        row.age = seconds_at(channel, "heard_s");
        if (text_member(now, "state") == "waiting" && row.causes.empty()) row.causes = text_member(now, "error");
        view.channels.push_back(std::move(row));
    }
}

void add_address(TopView& view, const Status& route, double seconds, const HeardFrames& heard) {
    TopAddress row{text_member(route, "address"), text_member(route, "who"), {}};
    const Status& links = member_of(route, "links");
    if (links.is_array())
        for (const Status& link : links)
            if (link.is_string()) row.links.append(row.links.empty() ? "" : ", ").append(link.get<std::string>());
    const auto value = std::strtoul(row.address.c_str(), nullptr, 16);
    if (value < heard.size() && seconds > 0) row.rate = static_cast<double>(heard[value]) / seconds;
    row.age = seconds_at(route, "age_s");
    view.addresses.push_back(std::move(row));
}

// UTF-8 characters may have several bytes.
bool begins_character(char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; }

std::string printable_text(std::string_view text) {
    std::string shown;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const auto byte = static_cast<unsigned char>(text[i]);
        const bool c1 = byte == 0xC2 && i + 1 < text.size() && static_cast<unsigned char>(text[i + 1]) < 0xA0;
        if (c1) ++i;
        shown += byte < 0x20 || byte == 0x7F || c1 ? '?' : text[i];
    }
    return shown;
}

std::string cut(std::string_view text, std::size_t width) {
    std::string shown;
    std::size_t characters = 0;
    for (const char c : printable_text(text)) {
        if (begins_character(c) && characters++ == width) break;
        shown += c;
    }
    return shown;
}

std::size_t characters_of(std::string_view text) {
    return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), begins_character));
}

std::string column(std::string_view text, std::size_t width) {
    std::string shown = cut(text, width);
    return shown.append(width - characters_of(shown), ' ');
}

// With a leading space. Never cut, because that would show another number.
std::string number_column(std::string_view text, std::size_t width) {
    return std::string(1 + width - std::min(width, text.size()), ' ').append(text);
}

constexpr std::array<std::size_t, 5> number_widths{5, 5, 6, 5, 6};
constexpr std::size_t usual_width = 80, names_there = 31;    // names_there: cells for link and peer

struct NameWidths {
    std::size_t link = 0, peer = 0;
};

// The widths of link and peer, as far as available. Of the additional width of a wide screen, they get two thirds and the causes
// the rest.
NameWidths name_widths(const std::vector<TopChannel>& rows, std::size_t width) {
    NameWidths need{4, 4};
    for (const TopChannel& row : rows)
        need = {std::max(need.link, characters_of(printable_text(row.link))),
                std::max(need.peer, characters_of(printable_text(row.peer)))};
    const std::size_t room = names_there + (std::max(width, usual_width) - usual_width) * 2 / 3;
    if (need.link + need.peer <= room) return need;
    const std::size_t link = std::min(need.link, std::max(room / 3, room - std::min(room, need.peer)));
    return {link, room - link};
}

std::string channel_cells(NameWidths names, std::string_view link, std::string_view peer,
                          const std::array<std::string, 5>& numbers) {
    std::string line = column(link, names.link) + ' ' + column(peer, names.peer);
    for (std::size_t i = 0; i < numbers.size(); ++i) line += number_column(numbers[i], number_widths[i]);
    return line + "  ";
}

std::string channel_line(const TopChannel& row, NameWidths names) {
    return channel_cells(names, row.link, row.peer,
                         {number(row.in), number(row.out), number(row.dropped), std::to_string(row.waiting), age_text(row.age)}) +
           row.causes;
}

std::string address_line(const TopAddress& row) {
    return column(row.address, 5) + column(row.who, 19) + number_column(number(row.rate), 5) +
           number_column(age_text(row.age), 6) + "  " + row.links;
}

/// Appends the `lines` that fit in `room`; the last line says how many are omitted.
void put(std::vector<std::string>& screen, const std::vector<std::string>& lines, std::size_t room) {
    const std::size_t shown = lines.size() <= room ? lines.size() : room == 0 ? 0 : room - 1;
    screen.insert(screen.end(), lines.begin(), lines.begin() + static_cast<std::ptrdiff_t>(shown));
    if (shown < lines.size() && room > 0) screen.push_back("... and " + std::to_string(lines.size() - shown) + " more");
}

}    // namespace

std::string_view text(TopSort sort) noexcept {
    switch (sort) {
    case TopSort::name: return "name";
    case TopSort::in: return "in";
    case TopSort::out: return "out";
    case TopSort::dropped: return "dropped";
    case TopSort::age: return "age";
    }
    return "";
}

TopSort next(TopSort sort) noexcept {
    return sort == TopSort::age ? TopSort::name : static_cast<TopSort>(static_cast<std::uint8_t>(sort) + 1);
}

TopView top_view(const Status& before, const Status& now, double seconds, const HeardFrames& heard) {
    TopView view;
    const Status& gateway = member_of(now, "gateway");
    const Status& links = member_of(now, "links");
    if (links.is_array())
        for (const Status& link : links)
            add_link(view, named(member_of(before, "links"), "name", text_member(link, "name")), link, seconds);
    const Status& routes = member_of(now, "routes");
    if (routes.is_array())
        for (const Status& route : routes) add_address(view, route, seconds, heard);
    double in = 0, out = 0, dropped = 0;
    for (const TopChannel& channel : view.channels) {
        in += channel.in;
        out += channel.out;
        dropped += channel.dropped;
    }
    view.title = text_member(gateway, "name") + " " + text_member(gateway, "version") + ", up " +
                 age_text(seconds_at(gateway, "uptime_s")) + "; frames/s: " + number(in) + " in, " + number(out) + " out, " +
                 number(dropped) + " dropped";
    return view;
}

void sort(TopView& view, TopSort by) {
    const auto key = [by](const TopChannel& row) {
        switch (by) {
        case TopSort::in: return -row.in;
        case TopSort::out: return -row.out;
        case TopSort::dropped: return -row.dropped;
        case TopSort::age: return row.age.value_or(HUGE_VAL);
        case TopSort::name: return 0.0;
        }
        return 0.0;
    };
    std::stable_sort(view.channels.begin(), view.channels.end(), [&](const TopChannel& a, const TopChannel& b) {
        return std::tuple{key(a), a.link, a.peer} < std::tuple{key(b), b.link, b.peer};
    });
    std::stable_sort(view.addresses.begin(), view.addresses.end(), [by](const TopAddress& a, const TopAddress& b) {
        if (by == TopSort::name) return a.address < b.address;
        if (by == TopSort::age) return a.age.value_or(HUGE_VAL) < b.age.value_or(HUGE_VAL);
        return a.rate > b.rate;
    });
}

std::vector<std::string> top_screen(const TopView& view, TopSort by, std::size_t width, std::size_t height) {
    constexpr std::size_t fixed = 5;    // title, two headings, an empty line, the keys
    const std::size_t room = height > fixed ? height - fixed : 0;
    const std::size_t for_addresses = std::min(view.addresses.size(),
                                               std::max(room / 3, room - std::min(room, view.channels.size())));
    std::vector<std::string> channels, addresses;
    const NameWidths names = name_widths(view.channels, width);
    for (const TopChannel& row : view.channels) channels.push_back(channel_line(row, names));
    for (const TopAddress& row : view.addresses) addresses.push_back(address_line(row));
    std::vector<std::string> screen{
        view.title, channel_cells(names, "LINK", "PEER", {"IN/s", "OUT/s", "LOST/s", "QUEUE", "AGE"}) + "LOST BY CAUSE"};
    put(screen, channels, room - for_addresses);
    screen.emplace_back();
    screen.push_back(column("ADDR", 5) + column("WHO", 19) + "SENT/s    AGE  LINKS");
    put(screen, addresses, for_addresses);
    if (height > 0) screen.resize(height - 1);
    screen.push_back("q quit   s sort, by " + std::string{text(by)});
    screen.resize(height);
    for (std::string& line : screen) line = cut(line, width);
    return screen;
}

}    // namespace anoctl
