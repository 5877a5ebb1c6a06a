#include <ano/address.hpp>
#include <ano/conversation.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <managed/gateway_device.hpp>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace anogate {
namespace {

using ano::Type;
using ano::device::Value;

constexpr std::uint16_t action_save = 0xAB, action_defaults = 0xAA;
constexpr std::uint8_t first_flexible = 0xF1, last_flexible = 0xFA;

Value value_of(Type type, double number) {
    if (type == Type::f32) return number;
    return static_cast<std::int64_t>(number);
}
double number_of(const Value& value) { return ano::device::from_value<double>(value); }

bool can_be_asked(const GpioSettings& line) { return line.use == GpioUse::reset || line.use == GpioUse::power; }

void append_u32(std::vector<std::uint8_t>& bytes, std::uint64_t number) {
    for (unsigned shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::uint8_t>(number >> shift));
}

ano::device::Counters operator+(const ano::device::Counters& a, const ano::device::Counters& b) {
    ano::device::Counters sum = a;
    sum.answered += b.answered;
    sum.unknown += b.unknown;
    sum.malformed += b.malformed;
    sum.unanswered += b.unanswered;
    sum.from_nobody += b.from_nobody;
    return sum;
}

}    // namespace

void GatewayDevice::configure(const Settings& of_file, WrittenValues written) {
    const auto numbered = [](const Settings& s) {
        std::vector<std::string> names{s.gateway.name, std::to_string(s.gateway.id)};
        for (const LinkSettings& link : s.links) names.push_back(link.name);
        return names;
    };
    std::vector<ManagedParameter> rows = managed_parameters(of_file);
    const bool same = device_ && rows == rows_ && numbered(of_file) == numbered(of_file_) && of_file.gpio == of_file_.gpio;
    of_file_ = of_file;
    written_ = std::move(written);
    if (same) return;
    rows_ = std::move(rows);
    make_device();
}

// Keeps listeners and saves that are waiting for the disk.
void GatewayDevice::make_device() {
    if (device_) former_ = former_ + device_->counters();
    device_.reset();
    if (!is_device(of_file_.gateway)) {
        listeners_.clear();
        summary_due_.reset();
        return;
    }
    device_ = std::make_unique<ano::device::Device>(
        ano::device::Info{.id = of_file_.gateway.id, .name = cut_text(of_file_.gateway.name, ano::device::max_name)});
    add_parameters();
    add_commands();
}

void GatewayDevice::add_parameters() {
    for (std::size_t i = 0; i < rows_.size(); ++i) {
        const ManagedParameter& row = rows_[i];
        ano::device::Parameter parameter;
        parameter.name = row.name;
        parameter.type = row.type;
        parameter.info = row.info;
        parameter.min = value_of(row.type, row.min);
        parameter.max = value_of(row.type, row.max);
        parameter.initial = value_of(row.type, std::clamp(value_in(of_file_, row), row.min, row.max));
        parameter.get = [this, i] { return value_of(rows_[i].type, written_.effective(rows_[i], of_file_).first); };
        parameter.set = [this, i](const Value& value) { return write(i, value); };
        device_->parameters().add(std::move(parameter));
    }
    device_->parameters().on(action_defaults, [this] { return change({}); });
}

void GatewayDevice::add_commands() {
    ano::device::Commands& commands = device_->commands();
    commands.add({1, 0, 1}, "RELOAD", "reload the configuration; the result is logged",
                 [this] { return done(operations_.reload(), "RELOAD"); });
    commands.add({1, 0, 2}, "SCAN", "scan for devices; those found are logged",
                 [this] { return done(operations_.scan(), "SCAN"); });
    std::string links = "the number of the link:", lines = pulsed_lines();
    for (std::size_t i = 0; i < of_file_.links.size(); ++i) links += " " + std::to_string(i) + " " + of_file_.links[i].name;
    commands.add({1, 0, 3}, "RESTART_LINK", links, [this](std::uint8_t number) {
        if (number >= of_file_.links.size()) return done("there is no link " + std::to_string(number), "RESTART_LINK");
        return done(operations_.restart(of_file_.links[number].name), "RESTART_LINK");
    });
    commands.add({1, 0, 4}, "SUMMARY", "1 to 10: report each link once a second in the flexible frame with this number; 0: stop",
                 [this](std::uint8_t flexible) { return summarise(flexible); });
    if (!lines.empty())
        commands.add({1, 0, 5}, "PULSE", "the number of the GPIO line:" + lines,
                     [this](std::uint8_t number) { return done(operations_.pulse(number), "PULSE"); });
    commands.add({1, 0, 6}, "START_RECORDING", "start recording as configured; the status has the file",
                 [this] { return done(operations_.start_recording(), "START_RECORDING"); });
    commands.add({1, 0, 7}, "STOP_RECORDING", "stop that recording",
                 [this] { return done(operations_.stop_recording(), "STOP_RECORDING"); });
}

std::string GatewayDevice::pulsed_lines() const {
    std::string lines;
    std::size_t number = 0;
    for (const GpioSettings& line : of_file_.gpio)
        if (can_be_asked(line))
            lines += " " + std::to_string(number++) + (line.use == GpioUse::reset ? " reset " : " power ") +
                     (line.link.empty() ? line.line : line.link);
    return lines;
}

bool GatewayDevice::concerns(std::uint8_t id) noexcept {
    return id == ano::id_of<"parameter_command"> || id == ano::id_of<"parameter_value"> || id == ano::id_of<"command"> ||
           id == ano::id_of<"command_query">;
}

void GatewayDevice::take(ano::FrameView frame, const Asker& asker, ano::TimePoint now) {
    if (!device_ || !concerns(frame.id())) return;
    now_ = now;
    asker_ = &asker;
    asker_address_ = frame.source();
    if (!ano::is_control(frame) || act(frame, asker)) device_->take(frame, now, asker.link);
    asker_ = nullptr;
}

// True: the frame must be passed to the device.
bool GatewayDevice::act(ano::FrameView frame, const Asker& asker) {
    if (frame.destination() != of_file_.gateway.id) return ++counters_.to_everybody, false;
    if (frame.source() == ano::address::unassigned || frame.source() == ano::address::broadcast ||
        frame.source() == of_file_.gateway.id)
        return true;    // the device counts these and does not answer
    if (!asker.may_manage)
        return refuse(&GatewayDeviceCounters::not_managed, "received on " + asker.name + ", which has no manage=yes"), false;
    const auto action = ano::as<"parameter_command", "action">(frame);
    return !(action && action->get<"val">() == action_save && begin_save(frame));
}

// The acknowledgement is sent after the values are stored on the disk.
bool GatewayDevice::begin_save(ano::FrameView frame) {
    const std::string why = saves_.size() < max_saves ? operations_.save(written_) : "others wait for the disk already";
    if (!done(why, "save")) return true;
    const ano::Checks checks = frame.checks();
    saves_.push_back({frame.source(), asker_->link, {frame.id(), checks.sum, checks.add}, asker_->is_ourselves});
    return true;
}

void GatewayDevice::saved(const std::string& fault, ano::TimePoint now) {
    if (saves_.empty()) return;
    const Pending first = saves_.front();
    saves_.pop_front();
    if (!device_) return;
    now_ = now;
    if (!fault.empty()) {
        ++counters_.refused;
        if (first.is_ourselves) operations_.refuse_ourselves("the parameters are not saved: " + fault);
        operations_.warn("the parameters are not saved: " + fault);
        return log("the parameters are not saved: " + fault, LogColor::red, now);
    }
    ++counters_.answered;
    ano::Draft<"check"> check;
    if (first.address != ano::address::unassigned && check.set<"id_get">(first.check[0]) && check.set<"sc_get">(first.check[1]) &&
        check.set<"ac_get">(first.check[2]))
        device_->send(check, first.address, first.link);
}

bool GatewayDevice::write(std::size_t row, const Value& value) {
    WrittenValues written = written_;
    written.write(rows_[row], number_of(value), of_file_);
    return change(std::move(written));
}

bool GatewayDevice::change(WrittenValues written) {
    if (locks_out(written)) {
        refuse(&GatewayDeviceCounters::would_lock_out, "it would close " + asker_->name + ", the link of the request");
        return false;
    }
    if (written == written_) return true;
    written_ = std::move(written);
    operations_.apply(written_);
    return true;
}

// Whether the write would close the asker's own link. An asker whose link was just closed by another one must not close any link
// either: otherwise two askers could close each other's link, and no link would be left.
bool GatewayDevice::locks_out(const WrittenValues& written) const {
    if (!asker_) return false;
    const Settings before = written_.applied(of_file_), after = written.applied(of_file_);
    bool is_left_out = false, closes = false;
    for (std::size_t i = 0; i < after.links.size(); ++i) {
        const bool closed = !after.links[i].enabled;
        is_left_out = is_left_out || (closed && after.links[i].name == asker_->name);
        closes = closes || (closed && before.links[i].enabled);
    }
    return is_left_out && closes;
}

bool GatewayDevice::done(const std::string& refusal, std::string_view what) {
    if (!refusal.empty()) refuse(&GatewayDeviceCounters::refused, std::string{what} + ": " + refusal);
    return refusal.empty();
}

// The reason is sent as a line of the log, because the protocol has no negative answer.
void GatewayDevice::refuse(std::uint64_t GatewayDeviceCounters::*cause, const std::string& why) {
    ++(counters_.*cause);
    if (asker_ && asker_->is_ourselves) operations_.refuse_ourselves(why);
    if (now_ < next_refusal_) {
        ++unreported_refusals_;
        return;
    }
    next_refusal_ = now_ + between_refusals;
    std::string line = "refused a request of " + ano::hex_byte(asker_address_) + " to the gateway: " + why;
    if (unreported_refusals_ > 0) line += " (" + std::to_string(std::exchange(unreported_refusals_, 0)) + " more since the last)";
    operations_.warn(line);
    ano::Draft<"log"> log_frame;
    if (ano::address::is_host(asker_address_) && log_frame.set<"color">(static_cast<std::uint8_t>(LogColor::red)) &&
        log_frame.set<"str">(ano::device::what_fits(line, log_frame.data_size())))
        device_->send(log_frame, asker_address_, asker_->link);
}

// Summaries are sent to the asker, or to all hosts if the asker is the control interface.
bool GatewayDevice::summarise(std::uint8_t flexible) {
    if (flexible > last_flexible - first_flexible + 1) return done("the number of a flexible frame must be 1 to 10", "SUMMARY");
    const Link link = asker_->is_ourselves ? ano::device::every_link : asker_->link;
    const std::uint8_t address = asker_->is_ourselves ? ano::address::host : asker_address_;
    std::erase_if(listeners_, [&](const Listener& l) { return l.link == link && l.address == address; });
    if (flexible != 0) {
        if (listeners_.size() >= max_listeners) return done("eight hosts already receive it", "SUMMARY");
        listeners_.push_back({address, link, static_cast<std::uint8_t>(first_flexible + flexible - 1)});
        if (!summary_due_) summary_due_ = now_;
    }
    if (listeners_.empty()) summary_due_.reset();
    return true;
}

void GatewayDevice::forget(Link link) {
    std::erase_if(listeners_, [link](const Listener& l) { return l.link == link; });
    for (Pending& save : saves_)
        if (save.link == link) save.address = ano::address::unassigned;
    if (listeners_.empty()) summary_due_.reset();
}

void GatewayDevice::send_summaries() {
    const std::vector<LinkSummary> links = operations_.summaries();
    for (const Listener& to : listeners_)
        for (std::size_t i = 0; i < links.size(); ++i) {
            std::vector<std::uint8_t> data{static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(links[i].state)};
            append_u32(data, links[i].frames_in);
            append_u32(data, links[i].frames_out);
            append_u32(data, links[i].dropped);
            std::vector<std::uint8_t>& frame = frames_.emplace_back(ano::overhead + data.size());
            ano::encode(frame, of_file_.gateway.id, to.address, to.id, data);
            frame_links_.push_back(to.link);
        }
}

void GatewayDevice::log(std::string_view text, LogColor color, ano::TimePoint now) {
    if (!device_) return;
    if (now >= lines_until_) {
        report_left_out();
        lines_until_ = now + lines_per;
        lines_ = 0;
    }
    if (lines_ < max_lines) {
        ++lines_;
        device_->log(text, color);
    } else {
        ++lines_left_out_;
        ++counters_.lines_left_out;
    }
}

void GatewayDevice::report_left_out() {
    if (lines_left_out_ > 0 && device_)
        device_->log(static_cast<float>(std::exchange(lines_left_out_, 0)), "log lines of the gateway were omitted");
}

void GatewayDevice::run(ano::TimePoint now) {
    now_ = now;
    if (!device_) return;
    if (lines_left_out_ > 0 && now >= lines_until_) report_left_out();
    if (!summary_due_ || now < *summary_due_) return;
    summary_due_ = std::max(*summary_due_ + between_summaries, now);    // missed summaries are not sent later
    send_summaries();
}

std::optional<ano::TimePoint> GatewayDevice::due() const noexcept {
    if (!device_ || lines_left_out_ == 0) return summary_due_;
    return summary_due_ ? std::min(*summary_due_, lines_until_) : lines_until_;
}

std::optional<ano::device::Outgoing::Departure> GatewayDevice::next() {
    if (device_)
        if (const auto first = device_->next()) return first;
    if (frames_.empty()) return std::nullopt;
    leaving_ = std::move(frames_.front());
    frames_.pop_front();
    const Link link = frame_links_.front();
    frame_links_.pop_front();
    return ano::device::Outgoing::Departure{ano::FrameView{leaving_}, link};
}

GatewayDeviceCounters GatewayDevice::counters() const noexcept {
    GatewayDeviceCounters all = counters_;
    const ano::device::Counters sum = device_ ? former_ + device_->counters() : former_;
    all.answered += sum.answered;
    all.unanswered += sum.unknown + sum.malformed + sum.unanswered + sum.from_nobody;
    return all;
}

std::vector<ManagedValue> GatewayDevice::values() const {
    std::vector<ManagedValue> values;
    if (!device_) return values;
    for (const ManagedParameter& row : rows_) {
        const auto [value, from] = written_.effective(row, of_file_);
        values.push_back({&row, value, from});
    }
    return values;
}

}    // namespace anogate
