// Writes the message table as a Lua table, followed by the Lua code that uses it.
#include "reference.hpp"

#include <ano/messages.hpp>
#include <ano/v7.hpp>
#include <ano_json/text.hpp>

#include <ostream>
#include <string>
#include <string_view>

namespace anoctl {
namespace {

using namespace ano;

constexpr const char* head_text =
    R"lua(-- A Wireshark dissector for ANO V8 and V7 frames: over UDP, and in recordings (LINKTYPE_USER0). Made by `anoctl messages --lua`.
-- Use: tshark -X lua_script:FILE, or copy it to Wireshark's folder of personal Lua plugins.

local ano = Proto("ano", "ANO V8")

-- Every layout: id, name, title, exact length (0: any), size of the fixed part, source (flexible messages), fields.
-- v7: only in frames of V7 (0xAA).
-- by_look: taken where the base layout reads as nonsense and this one does not.
-- A field: name, filter name, type, count (0: to the end), offset, wire and value of the scale, and what else it has.
local rows = {
)lua";

constexpr const char* engine = R"lua(}

local width = {u8 = 1, i8 = 1, u16 = 2, i16 = 2, u32 = 4, i32 = 4, u64 = 8, i64 = 8, f32 = 4, f64 = 8,
               text = 1, bytes = 1, ip = 4, frames = 1, list = 1}
local integer = {u8 = "uint8", i8 = "int8", u16 = "uint16", i16 = "int16", u32 = "uint32", i32 = "int32",
                 u64 = "uint64", i64 = "int64"}

local header = {
    source = ProtoField.uint8("ano.source", "Source", base.HEX),
    destination = ProtoField.uint8("ano.destination", "Destination", base.HEX),
    id = ProtoField.uint8("ano.id", "Id", base.HEX),
    name = ProtoField.string("ano.name", "Name"),
    length = ProtoField.uint16("ano.length", "Length"),
    sum = ProtoField.uint8("ano.sum", "Sum check", base.HEX),
    add = ProtoField.uint8("ano.add", "Additional check", base.HEX),
    extra = ProtoField.bytes("ano.extra", "Extra"),
    data = ProtoField.bytes("ano.data", "Data"),
    junk = ProtoField.bytes("ano.junk", "Bytes outside any frame"),
}
local malformed = ProtoExpert.new("ano.malformed", "Fewer bytes than the layout has", expert.group.MALFORMED,
                                  expert.severity.ERROR)
local unknown = ProtoExpert.new("ano.unknown_layout", "Unknown layout", expert.group.UNDECODED, expert.severity.WARN)
local all_fields = {}
for _, field in pairs(header) do all_fields[#all_fields + 1] = field end

local function is_scaled(f) return f.wire ~= f.value end

local function declare(f)
    if f.type == "frames" or f.type == "list" then return end
    if f.type == "text" then f.proto = ProtoField.string(f.filter, f.name)
    elseif f.type == "bytes" then f.proto = ProtoField.bytes(f.filter, f.name)
    elseif f.type == "ip" then f.proto = ProtoField.ipv4(f.filter, f.name)
    elseif is_scaled(f) or not integer[f.type] then f.proto = ProtoField.double(f.filter, f.name)
    else f.proto = ProtoField[integer[f.type]](f.filter, f.name, f.hex and base.HEX or base.DEC, f.meanings) end
    all_fields[#all_fields + 1] = f.proto
end

local by_id, by_id_in_v7 = {}, {}
for _, row in ipairs(rows) do
    for _, f in ipairs(row.fields) do declare(f) end
    for _, f in ipairs(row.element or {}) do declare(f) end
    local all = row.v7 and by_id_in_v7 or by_id
    all[row.id] = all[row.id] or {}
    table.insert(all[row.id], row)
end
for id, layouts in pairs(by_id) do
    if not by_id_in_v7[id] and not new_in_v8[id] then by_id_in_v7[id] = layouts end
end
ano.fields = all_fields
ano.experts = {malformed, unknown}

local function load(range, f)
    local t = f.type
    if t == "i8" then return range:int() end
    if t == "f32" or t == "f64" then return f.big and range:float() or range:le_float() end
    if t == "u64" then return f.big and range:uint64() or range:le_uint64() end
    if t == "i64" then return f.big and range:int64() or range:le_int64() end
    if t == "i16" or t == "i32" then return f.big and range:int() or range:le_int() end
    return f.big and range:uint() or range:le_uint()
end

local function add_number(tree, f, range)
    local wire = load(range, f)
    if f.no_data and wire == f.no_data then
        tree:add(range, f.name .. ": no data")
        return
    end
    local item
    if is_scaled(f) then item = tree:add(f.proto, range, wire * f.value / f.wire)
    elseif integer[f.type] then item = f.big and tree:add(f.proto, range) or tree:add_le(f.proto, range)
    else item = tree:add(f.proto, range, wire) end
    if f.unit then item:append_text(" " .. f.unit) end
    if f.label then item:append_text(" (" .. f.label .. ")") end
end

local function add_text(tree, f, range)
    local text = range:raw()
    local nul = text:find("\0", 1, true)
    local size = nul and nul - 1 or #text
    if size > 0 then tree:add(f.proto, range, range(0, size):string(ENC_UTF_8))
    else tree:add(f.proto, range, "") end
end

local dissect_frames

local function add_field(tree, row, f, data, pinfo)
    local size = f.count == 0 and data:len() - f.offset or width[f.type] * f.count
    if size == 0 then return end
    local range = data(f.offset, size)
    if f.type == "text" then add_text(tree, f, range)
    elseif f.type == "bytes" or f.type == "ip" then tree:add(f.proto, range)
    elseif f.type == "frames" then
        dissect_frames(range, pinfo, tree, true)
    elseif f.type == "list" then
        for at = 0, size - row.element_size, row.element_size do
            local point = tree:add(range(at, row.element_size), f.name)
            for _, e in ipairs(row.element) do add_number(point, e, range(at + e.offset, width[e.type])) end
        end
    else
        for at = 0, size - width[f.type], width[f.type] do add_number(tree, f, range(at, width[f.type])) end
    end
end

local function padded_text(data, offset, count)
    local over = false
    for at = offset, offset + count - 1 do
        local byte = data(at, 1):uint()
        if over and byte ~= 0 or byte ~= 0 and (byte < 0x20 or byte == 0x7F) then return false end
        over = over or byte == 0
    end
    return true
end

local function plausible(row, data, length)
    if length < row.size then return false end
    local min, max
    for _, f in ipairs(row.fields) do
        if row.by_look and f.name == "min" then min = data(f.offset, 4):le_int() end
        if row.by_look and f.name == "max" then max = data(f.offset, 4):le_int() end
        if f.type == "text" and f.count > 0 then
            local first = data(f.offset, 1):uint()
            if first < 0x20 or first == 0x7F or first == 0x80 or first == 0xFF then return false end
            if row.by_look and not padded_text(data, f.offset, f.count) then return false end
        elseif f.min and integer[f.type] then
            local value = tonumber(tostring(load(data(f.offset, width[f.type]), f))) * f.value / f.wire
            if value < f.min or value > f.max then return false end
        end
    end
    return not (min and max and min > max)
end

local function fits(row, base, source, data, length)
    if row.source and row.source ~= source then return false end
    local is_base = row == base
    if row.length ~= 0 and (is_base and length > row.length or not is_base and length ~= row.length) then return false end
    if row.exact and length > row.size then return false end
    if row.by_look and plausible(base, data, length) then return false end
    if row.by_look and not plausible(row, data, length) then return false end
    for _, f in ipairs(row.fields) do
        if f.first then
            if length < f.offset + width[f.type] then return false end
            local value = load(data(f.offset, width[f.type]), f)
            if value < f.first or value > f.last then return false end
        end
    end
    return true
end

-- The base layout stands first and is asked last.
local function select(layouts, source, data, length)
    for i = 2, #layouts do
        if fits(layouts[i], layouts[1], source, data, length) then return layouts[i] end
    end
    if layouts[1] and fits(layouts[1], layouts[1], source, data, length) then return layouts[1] end
end

local function behind(row, length)
    local last = row.fields[#row.fields]
    if not last or last.count ~= 0 then return length - row.size end
    return last.type == "list" and (length - row.size) % row.element_size or 0
end

local function dissect_frame(frame, pinfo, tree, inside)
    -- V7 has no source and a LEN of one byte.
    local v7 = frame(0, 1):uint() == 0xAA
    local to, id_at, begin = v7 and 1 or 2, v7 and 2 or 3, v7 and 4 or 6
    local source = not v7 and frame(1, 1):uint() or nil
    local id, length = frame(id_at, 1):uint(), v7 and frame(3, 1):uint() or frame(4, 2):le_uint()
    local layouts = (v7 and by_id_in_v7 or by_id)[id]
    local name = layouts and layouts[1].name or string.format("0x%02X", id)
    local item = tree:add(ano, frame, v7 and string.format("ANO V7 %s, to 0x%02X", name, frame(to, 1):uint())
                                      or string.format("ANO V8 %s, 0x%02X to 0x%02X", name, source, frame(to, 1):uint()))
    if source then item:add(header.source, frame(1, 1)) end
    item:add(header.destination, frame(to, 1))
    item:add(header.id, frame(id_at, 1))
    if layouts then item:add(header.name, frame(id_at, 1), name) end
    if v7 then item:add(header.length, frame(3, 1)) else item:add_le(header.length, frame(4, 2)) end
    local data = length > 0 and frame(begin, length):tvb() or nil
    local row = select(layouts or {}, source, data, length)
    -- A tunnel frame inside a tunnel frame is data: it is never unwrapped.
    local sealed = inside and row and #row.fields > 0 and row.fields[#row.fields].type == "frames"
    if row and #row.fields > 0 and length >= row.size and not sealed then
        local extra = behind(row, length)
        for _, f in ipairs(row.fields) do
            if data then
                local whole = f.type == "list" and extra > 0 and data(0, length - extra):tvb() or data
                add_field(item, row, f, whole, pinfo)
            end
        end
        if extra > 0 then item:add(header.extra, frame(begin + length - extra, extra)) end
    else
        if length > 0 then item:add(header.data, frame(begin, length)) end
        if row and length < row.size then item:add_proto_expert_info(malformed) end
        if not row and layouts then item:add_proto_expert_info(unknown, "unknown layout, LEN " .. length) end
    end
    item:add(header.sum, frame(begin + length, 1))
    item:add(header.add, frame(begin + 1 + length, 1))
    return name
end

-- The length of the whole frame at `at` of the bytes `raw`, if both checks hold.
local function frame_length(raw, at)
    local head, length = raw:byte(at + 1), nil
    if head == 0xAB and #raw - at >= 8 then length = raw:byte(at + 5) + 256 * raw:byte(at + 6) + 8
    elseif head == 0xAA and #raw - at >= 6 then length = raw:byte(at + 4) + 6
    else return end
    if at + length > #raw then return end
    local sum, add = 0, 0
    for i = at + 1, at + length - 2 do
        sum = (sum + raw:byte(i)) % 256
        add = (add + sum) % 256
    end
    if raw:byte(at + length - 1) == sum and raw:byte(at + length) == add then return length end
end

-- Names of the frames found.
dissect_frames = function(range, pinfo, tree, inside)
    local raw, at, told, names = range:raw(), 0, 0, {}
    while at < #raw do
        local length = frame_length(raw, at)
        if length then
            if at > told then tree:add(header.junk, range(told, at - told)) end
            names[#names + 1] = dissect_frame(range(at, length), pinfo, tree, inside)
            at = at + length
            told = at
        else
            at = at + 1
        end
    end
    if at > told then tree:add(header.junk, range(told, at - told)) end
    return names
end

function ano.dissector(tvb, pinfo, tree)
    if tvb:len() == 0 then return 0 end
    pinfo.cols.protocol = tvb(0, 1):uint() == 0xAA and "ANO V7" or "ANO V8"
    pinfo.cols.info = table.concat(dissect_frames(tvb(), pinfo, tree, false), ", ")
    return tvb:len()
end

for _, port in ipairs({12333, 6669, 6670}) do DissectorTable.get("udp.port"):add(port, ano) end
ano:register_heuristic("udp", function(tvb, pinfo, tree)
    if tvb:len() == 0 or not frame_length(tvb():raw(), 0) then return false end
    ano.dissector(tvb, pinfo, tree)
    return true
end)
DissectorTable.get("wtap_encap"):add(wtap.USER0, ano)
)lua";

std::string lua_text(std::string_view text) {
    std::string out = "\"";
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (c == '"' || c == '\\') out += {'\\', c};
        else if (byte < 0x20 || byte == 0x7F)
            out += "\\x" + std::string{"0123456789ABCDEF"[byte >> 4], "0123456789ABCDEF"[byte & 15]};
        else out += c;
    }
    return out + '"';
}

// Filter names of Wireshark consist of ASCII letters, digits, '-', '_' and '.'.
std::string filter_part(std::string_view name, std::size_t position) {
    std::string out;
    for (const char c : name) {
        const bool ok = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
        if (ok) out += c;
        else if (c >= 'A' && c <= 'Z') out += static_cast<char>(c - 'A' + 'a');
    }
    return out.size() == name.size() ? out : "value" + std::to_string(position);
}

void write_field(std::ostream& out, const Field& f, const std::string& filter) {
    out << "        {name = " << lua_text(f.name) << ", filter = " << lua_text(filter) << ", type = \"" << name_of(f.type)
        << "\", count = " << f.count << ", offset = " << f.offset << ", wire = " << number_text(f.scale.wire)
        << ", value = " << number_text(f.scale.value);
    if (!f.unit.empty()) out << ", unit = " << lua_text(f.unit);
    if (f.no_data) out << ", no_data = " << *f.no_data;
    if (f.range) out << ", min = " << number_text(f.range.first) << ", max = " << number_text(f.range.last);
    if (f.role == Role::code) out << ", hex = true";
    if (f.order == ByteOrder::big) out << ", big = true";
    if (!f.label.empty()) out << ", label = " << lua_text(f.label);
    if (f.selects) out << ", first = " << f.selects->first << ", last = " << f.selects->last;
    if (!f.meanings.empty()) {
        out << ",\n         meanings = {";
        for (const Meaning& m : f.meanings) out << '[' << m.value << "] = " << lua_text(m.text) << ", ";
        out << '}';
    }
    out << "},\n";
}

void write_fields(std::ostream& out, std::span<const Field> fields, const std::string& prefix) {
    for (std::size_t i = 0; i < fields.size(); ++i)
        write_field(out, fields[i], prefix + "." + filter_part(fields[i].name, i + 1));
}

void write_row(std::ostream& out, const Message& row, bool is_v7) {
    std::string prefix = (is_v7 ? "ano.v7." : "ano.") + std::string{row.name};
    if (!row.is_base()) prefix += "." + std::string{row.variant.label};
    out << "    {id = " << +row.id << ", name = " << lua_text(row.name) << ", title = " << lua_text(row.title)
        << ", length = " << row.variant.length << ", size = " << row.fixed_size << (is_v7 ? ", v7 = true" : "")
        << (row.variant.by_look ? ", by_look = true" : "") << (row.is_exact() ? ", exact = true" : "") << ", fields = {\n";
    write_fields(out, row.fields(), prefix);
    out << "    }";
    if (!row.element().empty()) {
        out << ", element_size = " << row.element_size << ", element = {\n";
        write_fields(out, row.element(), prefix);
        out << "    }";
    }
    out << "},\n";
}

void write_layout(std::ostream& out, const FlexibleLayout& layout) {
    const Message& row = *find_message(layout.id());
    std::string prefix = "ano." + std::string{row.name};
    out << "    {id = " << +row.id << ", name = " << lua_text(row.name) << ", length = 0, size = " << layout.size();
    if (layout.source()) {
        prefix += "." + std::to_string(*layout.source());
        out << ", source = " << +*layout.source();
    }
    if (layout.when()) prefix += ".when" + std::to_string(*layout.when());
    out << ", fields = {\n";
    write_fields(out, layout.fields(), prefix);
    out << "    }},\n";
}

}    // namespace

void write_lua(std::ostream& out, const FlexibleLayouts& flexible) {
    out << head_text;
    for (const Message& row : messages) write_row(out, row, false);
    for (const Message& row : v7::table::differences) write_row(out, row, true);
    // Specific layouts come first: those for one source before those for all, those for one value of the first field before those
    // for all.
    for (const bool with_source : {true, false})
        for (const bool with_value : {true, false})
            for (const FlexibleLayout& layout : flexible.all())
                if (layout.source().has_value() == with_source && layout.when().has_value() == with_value)
                    write_layout(out, layout);
    out << "}\n\nlocal new_in_v8 = {";
    for (unsigned id = 0; id < 256; ++id)
        if (v7::table::is_new_in_v8(static_cast<std::uint8_t>(id))) out << '[' << id << "] = true, ";
    out << engine;
}

}    // namespace anoctl
