// A simulated device in simulated time, and the frames that it sent.
#pragma once
#include "bytes.hpp"

#include <ano/typed.hpp>
#include <ano/wire.hpp>
#include <world/simulated_device.hpp>

#include <functional>
#include <optional>
#include <string_view>
#include <vector>

namespace support {

template <class Device>
struct Simulated {
    static constexpr ano::TimePoint start{std::chrono::seconds{1000}};

    explicit Simulated(const ano::world::Settings& settings = {}) : device{settings, start} {}

    void run_for(ano::Duration time) {
        for (const ano::TimePoint end = now + time; now < end;) {
            now = std::min(end, device.due());
            device.run(now, receive);
        }
    }
    /// Runs until `holds` returns true, checked every 100 ms; false: it did not within `limit`.
    bool run_until(const std::function<bool()>& holds, ano::Duration limit = std::chrono::seconds{60}) {
        for (const ano::TimePoint end = now + limit; now < end && !holds();) run_for(std::chrono::milliseconds{100});
        return holds();
    }
    std::vector<Bytes> answers(std::uint8_t id, const Bytes& data, std::uint8_t from = 0xFE) {
        said.clear();
        const Bytes question = frame(from, device.device().info().id, id, data);
        device.take(ano::FrameView{question}, now, receive);
        return said;
    }
    /// Sends it this frame. Returns whether it acknowledged it.
    bool does(std::uint8_t id, const Bytes& data) {
        const Bytes question = frame(0xFE, device.device().info().id, id, data);
        const Bytes yes = frame(device.device().info().id, 0xFE, 0x00, {id, question[question.size() - 2], question.back()});
        for (const Bytes& answer : answers(id, data))
            if (answer == yes) return true;
        return false;
    }
    template <class... Values>
    bool command(std::uint8_t number, Values... values) {
        Bytes data{0x10, 0, number};
        [[maybe_unused]] const auto add = [&](auto value) {
            data.resize(data.size() + sizeof value);
            ano::store(data.data() + data.size() - sizeof value, value);
        };
        (add(values), ...);
        return does(0xC0, data);
    }
    template <class T>
    bool write(std::string_view name, T value) {
        const auto id = device.device().parameters().find(name);
        if (!id) return false;
        Bytes data(2 + sizeof value);
        ano::store(data.data(), *id);
        ano::store(data.data() + 2, value);
        return does(0xE1, data);
    }
    /// Number of frames with this id that it sent since `said` was cleared.
    std::size_t count(std::uint8_t id) const {
        std::size_t n = 0;
        for (const Bytes& f : said) n += f[3] == id;
        return n;
    }
    /// The last frame of this message that it sends within the next 1.1 s.
    template <ano::Name M, ano::Name Label = "">
    std::optional<ano::View<M, Label>> next() {
        said.clear();
        run_for(std::chrono::milliseconds{1100});
        for (auto f = said.rbegin(); f != said.rend(); ++f)
            if (const auto view = ano::as<M, Label>(ano::FrameView{*f})) {
                last.assign(view->data().begin(), view->data().end());
                return ano::View<M, Label>{last};
            }
        return std::nullopt;
    }

    ano::TimePoint now = start;
    std::vector<Bytes> said;
    Bytes last;
    const ano::world::SimulatedDevice::Send receive = [this](ano::Bytes f, ano::TimePoint) {
        said.emplace_back(f.begin(), f.end());
    };
    Device device;
};

}    // namespace support
