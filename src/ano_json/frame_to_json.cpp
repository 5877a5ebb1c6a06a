#include <ano/hex.hpp>
#include <ano/reading.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/json_writer.hpp>
#include <ano_json/restored.hpp>
#include <ano_json/shown_text.hpp>
#include <ano_json/split_frames.hpp>

#include <nlohmann/json.hpp>

namespace ano {
namespace {

template <class... F>
struct Overloaded : F... {
    using F::operator()...;
};
template <class... F>
Overloaded(F...) -> Overloaded<F...>;    // for clang 14

void write_scalar(const Field& f, const Value& value, const JsonOptions& options, JsonWriter& out) {
    std::visit(Overloaded{
                   [&](Nothing) { out.null(); },
                   [&](double number) {
                       out.number(f.type == Type::f32 && f.scale.is_one() ? widened(static_cast<float>(number)) : number);
                   },
                   [&](std::string_view text) {
                       if (is_ascii(text)) out.text(text);
                       else out.text(display_text(text, options.encoding));
                   },
                   [&](Bytes bytes) { out.text(hex(bytes)); },
                   [&](auto integer) { out.number(integer); },
               },
               value);
}

void write_elements(const Reading& reading, const JsonOptions& options, JsonWriter& out) {
    out.begin_array();
    for (std::size_t i = 0; i < reading.element_count(); ++i) {
        out.begin_object();
        for (const Field& f : reading.element_fields()) {
            out.key(f.name);
            write_scalar(f, reading.element(i, f), options, out);
        }
        out.end_object();
    }
    out.end_array();
}

bool is_tunnel(const Reading& reading) noexcept {
    return !reading.fields().empty() && reading.fields().back().type == Type::frames;
}

void write_members(FrameView frame, const JsonOptions& options, bool inside_a_tunnel, JsonWriter& out) {
    const Reading reading = read(frame, options.flexible);
    for (const auto& [key, byte] : {std::pair{"from", frame.source()}, {"to", frame.destination()}, {"id", frame.id()}}) {
        out.key(key);
        out.number(std::uint64_t{byte});
    }
    if (reading.message() != nullptr) out.text("name", reading.message()->name);
    // A tunnel frame inside a tunnel frame is data: it is never unwrapped.
    if (!reading || (inside_a_tunnel && is_tunnel(reading))) return out.text("data", hex(frame.data()));
    out.key("fields");
    out.begin_object();
    write_fields(reading, options, out);
    out.end_object();
    if (!reading.extra().empty()) out.text("extra", hex(reading.extra()));
    if (!is_restored(frame, reading, options)) out.text("data", hex(frame.data()));
}

void write_frames(Bytes bytes, const JsonOptions& options, JsonWriter& out) {
    out.begin_array();
    split_frames(
        bytes,
        [&](FrameView frame) {
            out.begin_object();
            write_members(frame, options, true, out);
            out.end_object();
        },
        [](std::size_t, Bytes) {});
    out.end_array();
}

}    // namespace

void write_value(const Reading& reading, const Field& f, const JsonOptions& options, JsonWriter& out) {
    const Bytes bytes = reading.bytes_of(f);
    if (f.type == Type::ip) return out.text(address_text(bytes));
    if (f.type == Type::list) return write_elements(reading, options, out);
    if (f.type == Type::frames) return write_frames(bytes, options, out);
    if (!is_number(f.type) || f.count == 1) return write_scalar(f, reading.value(f), options, out);
    out.begin_array();
    for (std::size_t at = 0; at < bytes.size(); at += width(f.type))
        write_scalar(f, value_at(f, bytes.data() + at), options, out);
    out.end_array();
}

void write_fields(const Reading& reading, const JsonOptions& options, JsonWriter& out, bool without_null) {
    for (const Field& f : reading.fields()) {
        const auto write = [&] { write_value(reading, f, options, out); };
        if (without_null) {
            out.member_unless_null(f.name, write);
        } else {
            out.key(f.name);
            write();
        }
    }
    if (!is_tunnel(reading)) return;
    if (const std::string rest = hex_between_frames(reading); !rest.empty()) out.text("data", rest);
}

std::string hex_between_frames(const Reading& tunnel) {
    std::string rest;
    split_frames(
        tunnel.bytes_of(tunnel.fields().back()), [](FrameView) {}, [&](std::size_t, Bytes gap) { rest += hex(gap); });
    return rest;
}

void write_frame(FrameView frame, const JsonOptions& options, JsonWriter& out) { write_members(frame, options, false, out); }

Json frame_to_json(FrameView frame, const JsonOptions& options) {
    std::string text;
    JsonWriter out{text};
    out.begin_object();
    write_frame(frame, options, out);
    out.end_object();
    return Json::parse(text);
}

}    // namespace ano
