#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/shown_text.hpp>
#include <ano_json/split_frames.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace ano {
namespace {

template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;    // for clang 14

Json to_json(FrameView frame, const JsonOptions& options, bool inside_a_tunnel);

class FieldWriter {
public:
    FieldWriter(const Reading& reading, const JsonOptions& options) : reading_{reading}, options_{options} {}

    Json fields() {
        Json json = Json::object();
        for (const Field& f : reading_.fields()) write(f, json);
        return json;
    }
    /// The fields hold a null from which the bytes can't be restored.
    bool lossy() const noexcept { return lossy_; }

private:
    void write(const Field& f, Json& json) {
        Json& value = json[std::string{f.name}];
        switch (f.type) {
        case Type::ip: value = address(reading_.bytes_of(f)); break;
        case Type::list: value = elements(); break;
        case Type::frames: write_frames(reading_.bytes_of(f), json); break;
        case Type::bytes: value = hex(reading_.bytes_of(f)); break;
        default:
            if (is_number(f.type) && f.count > 1) {
                value = Json::array();
                const Bytes bytes = reading_.bytes_of(f);
                for (std::size_t at = 0; at < bytes.size(); at += width(f.type))
                    value.push_back(scalar(f, value_at(f, bytes.data() + at)));
            } else {
                value = scalar(f, reading_.value(f));
            }
        }
    }

    Json scalar(const Field& f, const Value& value) {
        return std::visit(Overloaded{
                              [](Nothing) -> Json { return nullptr; },
                              [&](double v) -> Json {
                                  if (!std::isfinite(v)) {
                                      lossy_ = true;
                                      return nullptr;
                                  }
                                  if (f.type == Type::f32 && f.scale.is_one()) return widened(static_cast<float>(v));
                                  return v;
                              },
                              [&](std::string_view text) -> Json { return shown_text(text, options_.encoding); },
                              [](Bytes bytes) -> Json { return hex(bytes); },
                              [](auto integer) -> Json { return integer; },
                          },
                          value);
    }

    Json elements() {
        Json list = Json::array();
        for (std::size_t i = 0; i < reading_.element_count(); ++i) {
            Json element = Json::object();
            for (const Field& f : reading_.element_fields()) element[std::string{f.name}] = scalar(f, reading_.element(i, f));
            list.push_back(std::move(element));
        }
        return list;
    }

    static Json address(Bytes ip) {
        std::string text;
        for (const std::uint8_t byte : ip) {
            if (!text.empty()) text += '.';
            text += std::to_string(byte);
        }
        return text;
    }

    // Bytes that are not a whole frame are added as `data`, next to the frames.
    void write_frames(Bytes bytes, Json& json) {
        Json frames = Json::array();
        std::string rest;
        split_frames(
            bytes, [&](FrameView frame) { frames.push_back(to_json(frame, options_, true)); },
            [&](std::size_t, Bytes gap) { rest += hex(gap); });
        json["frames"] = std::move(frames);
        if (!rest.empty()) json["data"] = rest;
    }

    const Reading& reading_;
    const JsonOptions& options_;
    bool lossy_ = false;
};

bool is_tunnel(const Reading& reading) noexcept {
    return !reading.fields().empty() && reading.fields().back().type == Type::frames;
}

// Compared with what a reader without our options would encode.
bool gives_back(const Json& json, FrameView frame, const JsonOptions& options) {
    const auto again = frame_from_json(json, {options.flexible, Encoding::utf8});
    const auto* bytes = std::get_if<std::vector<std::uint8_t>>(&again);
    return bytes != nullptr && std::equal(bytes->begin(), bytes->end(), frame.bytes().begin(), frame.bytes().end());
}

Json to_json(FrameView frame, const JsonOptions& options, bool inside_a_tunnel) {
    const Reading reading = read(frame, options.flexible);
    Json json{{"from", frame.source()}, {"to", frame.destination()}, {"id", frame.id()}};
    if (reading.message() != nullptr) json["name"] = reading.message()->name;
    // A tunnel frame inside a tunnel frame is data: it is never unwrapped.
    if (!reading || (inside_a_tunnel && is_tunnel(reading))) {
        json["data"] = hex(frame.data());
        return json;
    }
    FieldWriter writer{reading, options};
    json["fields"] = writer.fields();
    if (!reading.extra().empty()) json["extra"] = hex(reading.extra());
    if (writer.lossy() || !gives_back(json, frame, options)) json["data"] = hex(frame.data());
    return json;
}

}    // namespace

Json frame_to_json(FrameView frame, const JsonOptions& options) { return to_json(frame, options, false); }

Json fields_to_json(const Reading& reading, const JsonOptions& options) { return FieldWriter{reading, options}.fields(); }

}    // namespace ano
