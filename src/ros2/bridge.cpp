#include <ano/address.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ros/standard_types.hpp>
#include <ros2/bridge.hpp>
#include <ros2/topic_list.hpp>

#include <algorithm>
#include <cmath>

namespace anogate {
namespace {

using ano::id_of;

constexpr std::size_t max_devices = 64, max_refused = 64;
constexpr ano::Duration silent_after = std::chrono::seconds{5};

template <class Draft>
bool send_draft(BridgeOutput& output, const Draft& draft, std::uint8_t destination) {
    std::array<std::uint8_t, 64> frame{};
    const std::size_t size = draft.encode(frame, ano::address::ros_bridge, destination);
    return output.send({frame.data(), size});
}

}    // namespace

struct Bridge::InputState {
    Input input{};
    InputGuard guard{};
    std::uint64_t used = 0;
    std::array<std::uint64_t, input_faults> faults{};    // by InputFault
    std::optional<Guid> logged{};                        // the publisher that the log names
};

struct Bridge::Device {
    std::uint8_t address = 0;
    DevicePublisher publisher;
    ano::TimePoint heard_at{};
    std::optional<VelocityControl> velocity{};
    std::vector<std::unique_ptr<InputState>> inputs{};
    std::optional<Bus::Topic> results{};    // command_result
    // For the rates in /diagnostics:
    std::uint64_t shown_count = 0;
    std::uint64_t frames = 0;
};

Bridge::Bridge(const Ros2Settings& settings, Bus& bus, BridgeOutput& output)
    : output_{output}, context_{bus, settings}, prefixes_{settings}, decoding_{std::make_shared<const Decoding>()} {
    const auto qos = [&](const char* topic) {
        const auto found = settings.qos.find(topic);
        return found == settings.qos.end() ? Reliability::reliable : found->second;
    };
    diagnostics_ = bus.advertise({"/diagnostics", standard_types().diagnostic_array, qos("diagnostics")});
    if (settings.tf) context_.tf = bus.advertise({"/tf", standard_types().tf_message, qos("tf")});
    // The inputs of a device with a configured prefix are there before the device is.
    for (const Ros2Device& entry : settings.devices)
        if (!entry.prefix.empty() && !entry.accept.empty()) device_of(entry.link, entry.address);
}

Bridge::~Bridge() = default;

void Bridge::use(DecodingPtr decoding) {
    if (decode_alike(decoding_, decoding)) return;
    for (const auto& [prefix, device] : devices_) device->publisher.forget_layouts();
    context_.known.forget_layouts();
    decoding_ = std::move(decoding);
}

void Bridge::use(const std::vector<DeviceNote>& devices) {
    for (const DeviceNote& device : devices) names_[device.address] = device.name;
}

void Bridge::receive(std::string_view link, const FrameRecord& record, ano::TimePoint now) {
    const std::uint8_t address = record.frame.source();
    if (record.direction != Direction::in || record.is_elsewhere) return;
    if (ano::address::is_host(address) || ano::address::is_nobody(address)) return;
    const ano::Encoding encoding = encodings_.of(record.frame, link, true, decoding_.get());
    const ano::Reading reading = ano::read(record.frame, &decoding_->layouts());
    Device* const device = reading ? device_of(link, address) : nullptr;
    if (device == nullptr) return;
    device->heard_at = now;
    ++device->frames;
    if (const auto mode = ano::as<"mode">(record.frame); mode && device->velocity)
        device->velocity->on_mode(mode->get<"mode">(), now);
    device->publisher.receive(record, reading, *decoding_, decoding_->attitude(link), encoding);
    if (context_.topics == PublisherContext::max_topics && !std::exchange(told_full_, true))
        output_.warn("there are " + std::to_string(PublisherContext::max_topics) + " topics; no more are created");
}

// nullptr: it has no prefix.
Bridge::Device* Bridge::device_of(std::string_view link, std::uint8_t address) {
    const std::pair key{std::string{link}, address};
    if (const auto found = ways_.find(key); found != ways_.end()) return found->second;
    if (refused_.contains(key)) return nullptr;
    const Prefixes::Answer answer = prefixes_.of(address, link, names_[address]);
    if (answer.prefix.empty()) {
        needs_names_ = needs_names_ || answer.fault.empty();
        if (answer.fault.empty() || refused_.size() == max_refused) return nullptr;
        output_.warn("no topics for device " + ano::hex_byte(address) + " on link " + std::string{link} + ": " + answer.fault);
        refused_.emplace(key, answer.fault);
        return nullptr;
    }
    auto& device = devices_[answer.prefix];
    if (!device) {
        if (devices_.size() > max_devices) {
            devices_.erase(answer.prefix);
            return nullptr;
        }
        const Ros2Device* entry = prefixes_.entry(address, link);
        const bool accepts_joy = entry != nullptr && entry->accepts(Input::joy);
        device.reset(new Device{address, DevicePublisher{context_, answer.prefix, devices_.size(), !accepts_joy}});
        if (entry != nullptr) add_inputs(*device, *entry);
    }
    return ways_[key] = device.get();
}

void Bridge::add_inputs(Device& device, const Ros2Device& entry) {
    if (entry.accepts(Input::cmd_vel)) device.velocity.emplace(entry.hover_throttle, entry.velocity_modes);
    for (const Input input : {Input::cmd_vel, Input::joy, Input::command})
        if (entry.accepts(input)) subscribe(device, input);
}

// A velocity that was lost is never sent again: the next one replaces it. A command is.
void Bridge::subscribe(Device& device, Input input) {
    const auto& types = standard_types();
    const std::array of_input{types.twist, types.joy, types.string};
    const std::string topic = '/' + device.publisher.prefix() + '/' + std::string{input_names[static_cast<std::size_t>(input)]};
    const Reliability reliability = input == Input::command ? Reliability::reliable : Reliability::best_effort;
    const std::size_t number = context_.bus.subscribe({topic, of_input[static_cast<std::size_t>(input)], reliability});
    subscriptions_[number] = {&device, input};
    device.inputs.push_back(std::make_unique<InputState>(InputState{input}));
    if (input == Input::command) device.results = context_.bus.advertise({topic + "_result", types.string});
}

void Bridge::on_sample(const Sample& sample, ano::TimePoint now) {
    const auto found = subscriptions_.find(sample.topic);
    if (found == subscriptions_.end()) return;
    auto& [device, input] = found->second;
    InputState* state = nullptr;
    for (const auto& one : device->inputs)
        if (one->input == input) state = one.get();
    InputFault fault = state->guard.check(sample, now);
    if (fault == InputFault::none) {
        log_publisher(*state, *device, now);
        if (input == Input::cmd_vel) fault = on_velocity(*device, sample, now);
        else if (input == Input::joy) fault = on_joy(*device, sample);
        else fault = on_command(*device, sample);
    } else if (input == Input::command) {
        answer(*device, command_failure({}, "ignored: " + std::string{format_fault(fault)}));
    }
    if (fault == InputFault::none) ++state->used;
    else ++state->faults[static_cast<std::size_t>(fault)];
}

void Bridge::log_publisher(InputState& input, const Device& device, ano::TimePoint now) {
    const auto publisher = input.guard.publisher(now);
    if (publisher == input.logged) return;
    input.logged = publisher;
    log_change(input, device, "controlled by publisher " + format_guid(*publisher), now);
}

void Bridge::log_change(const InputState& input, const Device& device, const std::string& what, ano::TimePoint now) {
    const std::string topic = '/' + device.publisher.prefix() + '/' +
                              std::string{input_names[static_cast<std::size_t>(input.input)]};
    if (const std::string line = changes_.limited(topic + ": " + what, now); !line.empty()) output_.log(line);
}

InputFault Bridge::on_velocity(Device& device, const Sample& sample, ano::TimePoint now) {
    const auto twist = read_twist({reinterpret_cast<const std::uint8_t*>(sample.cdr.data()), sample.cdr.size()});
    VelocityFrame frame;
    if (!twist) return InputFault::malformed;
    const InputFault fault = device.velocity->on_twist(*twist, now, frame);
    return fault == InputFault::none ? send(device, frame) : fault;
}

InputFault Bridge::send(const Device& device, const VelocityFrame& frame) {
    constexpr double per_mille = 10;    // of a percent
    ano::Draft<"realtime_control"> draft;
    const bool is_set = draft.set<"ctrl_thr">(frame.throttle / per_mille) && draft.set<"ctrl_yaw_dps">(frame.yaw_rate) &&
                        draft.set<"ctrl_spd_x">(frame.x) && draft.set<"ctrl_spd_y">(frame.y) && draft.set<"ctrl_spd_z">(frame.z);
    return is_set && send_draft(output_, draft, device.address) ? InputFault::none : InputFault::not_sent;
}

// All ten channels are stated: none is invented.
InputFault Bridge::on_joy(Device& device, const Sample& sample) {
    const auto joy = read_joy({reinterpret_cast<const std::uint8_t*>(sample.cdr.data()), sample.cdr.size()});
    constexpr std::size_t channels = 10;
    if (!joy || joy->axes.size() != channels) return InputFault::malformed;
    std::array<std::int16_t, channels> wire{};
    for (std::size_t i = 0; i < channels; ++i) {
        constexpr float middle = 1500, half = 500;
        if (!std::isfinite(joy->axes[i])) return InputFault::malformed;
        wire[i] = static_cast<std::int16_t>(std::lround(middle + half * std::clamp(joy->axes[i], -1.0F, 1.0F)));
    }
    ano::Draft<"remote_control"> draft;
    const bool is_set = draft.set<"rol">(wire[0]) && draft.set<"pit">(wire[1]) && draft.set<"thr">(wire[2]) &&
                        draft.set<"yaw">(wire[3]) && draft.set<"aux1">(wire[4]) && draft.set<"aux2">(wire[5]) &&
                        draft.set<"aux3">(wire[6]) && draft.set<"aux4">(wire[7]) && draft.set<"aux5">(wire[8]) &&
                        draft.set<"aux6">(wire[9]);
    return is_set && send_draft(output_, draft, device.address) ? InputFault::none : InputFault::not_sent;
}

InputFault Bridge::on_command(Device& device, const Sample& sample) {
    const auto text = read_string({reinterpret_cast<const std::uint8_t*>(sample.cdr.data()), sample.cdr.size()});
    const Expected<CommandText> command = text ? parse_command(*text) : Unexpected{std::string{"not a std_msgs/String"}};
    if (!command) {
        answer(device, command_failure({}, command.error()));
        return InputFault::malformed;
    }
    const bool is_sent = output_.call(
        device.address, *command,
        [this, &device, command = *command](const http::Outcome& outcome) { answer(device, command_result(command, outcome)); });
    if (is_sent) return InputFault::none;
    answer(device, command_failure(*command, "too many commands are running; try again later"));
    return InputFault::not_sent;
}

void Bridge::answer(const Device& device, const std::string& text) {
    if (!device.results || !context_.bus.has_subscribers(*device.results)) return;
    context_.values.clear();
    context_.values.push(ano::Value{std::string_view{text}});
    context_.bus.publish(*device.results, context_.encoder.encode(*standard_types().string, context_.values.values()));
}

void Bridge::on_time(ano::TimePoint now) {
    for (const auto& [prefix, device] : devices_) {
        if (device->velocity)
            if (const auto stop = device->velocity->on_time(now)) send(*device, *stop);
        for (const auto& input : device->inputs) {
            if (!input->logged || input->input == Input::command || input->guard.publisher(now)) continue;
            input->logged.reset();
            log_change(*input, *device, "no messages for 0.5 s", now);
        }
    }
}

void Bridge::append_pair(std::string key, std::string value) {
    context_.values.push_copy(std::move(key));
    context_.values.push_copy(std::move(value));
}

// DiagnosticStatus: level, name, message, hardware_id, values
void Bridge::append_status(const Device& device, ano::TimePoint now) {
    constexpr std::int64_t ok = 0, stale = 3;
    const bool is_silent = now - device.heard_at > silent_after;
    ValueList& values = context_.values;
    values.push(ano::Value{is_silent ? stale : ok});
    values.push_copy("anogate: " + device.publisher.prefix());
    values.push_copy(is_silent ? "no frames for 5 s" : "receiving");
    values.push_copy(ano::hex_byte(device.address) + (names_[device.address].empty() ? "" : " " + names_[device.address]));
    std::vector<std::pair<std::string, std::string>> pairs{{"frames", std::to_string(device.frames)}};
    for (const auto& input : device.inputs) {
        const std::string name{input_names[static_cast<std::size_t>(input->input)]};
        const auto publisher = input->guard.publisher(now);
        pairs.emplace_back(name + " publisher", publisher ? format_guid(*publisher) : "none");
        pairs.emplace_back(name + " used", std::to_string(input->used));
        for (std::size_t fault = 1; fault < input_faults; ++fault)
            if (input->faults[fault] > 0)
                pairs.emplace_back(name + " ignored: " + std::string{format_fault(static_cast<InputFault>(fault))},
                                   std::to_string(input->faults[fault]));
    }
    values.push_count(pairs.size());
    for (auto& [key, value] : pairs) append_pair(std::move(key), std::move(value));
}

void Bridge::publish_diagnostics(const std::string& gateway, std::uint64_t time_ns, ano::TimePoint now) {
    constexpr std::uint64_t second_ns = 1'000'000'000;
    constexpr std::int64_t ok = 0, error = 2;
    if (!context_.bus.has_subscribers(*diagnostics_)) return;
    ValueList& values = context_.values;
    values.clear();
    values.push(ano::Value{static_cast<std::int64_t>(time_ns / second_ns)});
    values.push(ano::Value{static_cast<std::int64_t>(time_ns % second_ns)});
    values.push(ano::Value{std::string_view{}});
    values.push_count(1 + devices_.size());
    values.push(ano::Value{gateway.empty() ? ok : error});
    values.push(ano::Value{std::string_view{"anogate: gateway"}});
    values.push_copy(gateway.empty() ? "connected" : gateway);
    values.push(ano::Value{std::string_view{}});
    values.push_count(2 + refused_.size());
    append_pair("topics", std::to_string(context_.topics));
    append_pair("lost frames", std::to_string(lost_));
    for (const auto& [key, why] : refused_) append_pair("no topics for " + ano::hex_byte(key.second) + " on " + key.first, why);
    for (const auto& [prefix, device] : devices_) append_status(*device, now);
    context_.bus.publish(*diagnostics_, context_.encoder.encode(*standard_types().diagnostic_array, values.values()));
}

std::string Bridge::list(ano::Duration watched) const {
    TopicList list{watched};
    for (const auto& [prefix, device] : devices_) list.add(device->publisher);
    for (const auto& [prefix, device] : devices_)
        for (const auto& input : device->inputs) list.add_input(prefix, input->input);
    for (const auto& [key, why] : refused_) list.add_refused(key.first, key.second, why);
    if (needs_names_ && devices_.empty())
        list.add_note("the names of devices are not known yet; they are asked for by anoctl devices --scan");
    return list.text();
}

}    // namespace anogate
