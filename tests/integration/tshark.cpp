// The dissector that `anoctl messages --lua` prints, loaded by tshark, shows what `anoctl decode` shows.
#include <gtest/gtest.h>
#include <ano/reading.hpp>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include <support/anoctl.hpp>
#include <support/temp_dir.hpp>
#include <support/v7_vectors.hpp>
#include <support/vectors.hpp>

namespace tshark_tests {
namespace {

using ano::Json;
using support::anoctl;
using support::Bytes;

std::string output_of(const std::string& command) {
    std::string text;
    FILE* pipe = popen(command.c_str(), "r");
    char buffer[4096];
    for (std::size_t n; pipe != nullptr && (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;) text.append(buffer, n);
    return pipe != nullptr && pclose(pipe) == 0 ? text : std::string{};
}

void put(std::string& out, std::uint64_t value, int bytes, bool big_endian = false) {
    for (int i = 0; i < bytes; ++i) out += static_cast<char>(value >> 8 * (big_endian ? bytes - 1 - i : i));
}

/// A capture of UDP datagrams over raw IP; some packets are recognised by their port, others by their content.
std::string pcap_of(const std::vector<support::Vector>& vectors) {
    std::string file;
    put(file, 0xA1B2C3D4, 4);
    put(file, 2, 2);
    put(file, 4, 2);
    put(file, 0, 8);
    put(file, 65535, 4);
    put(file, 101, 4);    // LINKTYPE_RAW
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const auto& payload = vectors[i].bytes;
        std::string packet;
        put(packet, 0x4500, 2, true);
        put(packet, 28 + payload.size(), 2, true);
        put(packet, 0, 4, true);
        put(packet, 0x40110000, 4, true);    // time to live 64, UDP, no check
        put(packet, 0x7F000001, 4, true);
        put(packet, 0x7F000001, 4, true);
        put(packet, 40000, 2, true);
        put(packet, i % 2 ? 12333 : 45678, 2, true);
        put(packet, 8 + payload.size(), 2, true);
        put(packet, 0, 2, true);
        packet.append(payload.begin(), payload.end());
        put(file, 0, 8);
        put(file, packet.size(), 4);
        put(file, packet.size(), 4);
        file += packet;
    }
    return file;
}

/// All values of `key` in `tree`, except those of frames inside this one.
void collect(const Json& tree, const std::string& key, std::vector<std::string>& values) {
    for (const auto& [name, value] : tree.items()) {
        if (name == "ano") continue;
        if (name == key) {
            if (value.is_string()) values.push_back(value.get<std::string>());
            else if (value.is_array())
                for (const Json& one : value) values.push_back(one.get<std::string>());
        } else if (value.is_object()) {
            collect(value, key, values);
        } else if (value.is_array()) {
            for (const Json& one : value)
                if (one.is_object()) collect(one, key, values);
        }
    }
}
std::vector<std::string> values_of(const Json& tree, const std::string& key) {
    std::vector<std::string> values;
    collect(tree, key, values);
    return values;
}

std::string without_colons(std::string text) {
    std::erase(text, ':');
    return text;
}

class Comparison {
public:
    explicit Comparison(std::string name) : name_{std::move(name)} {}

    void frame(const Json& expected, const Json& shown) {
        EXPECT_EQ(number(shown, "ano.source"), expected["from"]) << name_;
        EXPECT_EQ(number(shown, "ano.destination"), expected["to"]) << name_;
        EXPECT_EQ(number(shown, "ano.id"), expected["id"]) << name_;
        if (!expected.contains("fields")) {
            bytes(expected["data"], shown, "ano.data");
            return;
        }
        const auto encoded = ano::frame_from_json(expected);
        const auto& whole = std::get<0>(encoded);
        const ano::Message* row = ano::select_layout(ano::layouts_of(whole[3]),
                                                     {whole.data() + ano::header_size, whole.size() - ano::overhead});
        ASSERT_NE(row, nullptr) << name_;
        prefix_ = "ano." + std::string{row->name} + ".";
        if (!row->is_base()) prefix_ += std::string{row->variant.label} + ".";
        for (const ano::Field& f : row->fields()) field(f, *row, expected["fields"], shown);
        if (expected.contains("extra")) bytes(expected["extra"], shown, "ano.extra");
    }
    void v7_frame(const Bytes& whole, const Json& expected, const Json& shown) {
        EXPECT_TRUE(values_of(shown, "ano.source").empty()) << name_;
        EXPECT_EQ(number(shown, "ano.destination"), expected["to"]) << name_;
        EXPECT_EQ(number(shown, "ano.id"), expected["id"]) << name_;
        const ano::v7::FrameView frame{whole};
        if (!expected.contains("fields")) {
            bytes(expected["data"], shown, "ano.data");
            return;
        }
        const ano::Message* row = ano::select_layout(ano::v7::layouts_of(frame.id()), frame.data());
        ASSERT_NE(row, nullptr) << name_;
        prefix_ = (ano::v7::is_same_in_v8(frame.id()) ? "ano." : "ano.v7.") + std::string{row->name} + ".";
        if (!row->is_base()) prefix_ += std::string{row->variant.label} + ".";
        for (const ano::Field& f : row->fields()) field(f, *row, expected["fields"], shown);
        if (expected.contains("extra")) bytes(expected["extra"], shown, "ano.extra");
    }
    std::size_t compared() const { return compared_; }

private:
    unsigned number(const Json& shown, const std::string& key) {
        const auto values = values_of(shown, key);
        return values.size() == 1 ? static_cast<unsigned>(std::stoul(values[0], nullptr, 0)) : 9999;
    }
    void bytes(const Json& expected, const Json& shown, const std::string& key) {
        std::string all;
        for (const std::string& value : values_of(shown, key)) all += without_colons(value);
        EXPECT_EQ(all, expected.get<std::string>()) << name_ << " " << key;
        ++compared_;
    }
    void field(const ano::Field& f, const ano::Message& row, const Json& fields, const Json& shown) {
        const Json& expected = fields[std::string{f.name}];
        const std::string key = prefix_ + std::string{f.name};
        switch (f.type) {
        case ano::Type::bytes: return bytes(expected, shown, key);
        case ano::Type::frames: return inner(expected, shown);
        case ano::Type::list:
            for (const ano::Field& e : row.element()) {
                Json column = Json::array();
                for (const Json& point : expected) column.push_back(point[std::string{e.name}]);
                numbers(e, column, values_of(shown, prefix_ + std::string{e.name}));
            }
            return;
        case ano::Type::text:
        case ano::Type::ip: return text(expected.get<std::string>(), values_of(shown, key));
        default: return numbers(f, expected.is_array() ? expected : Json::array({expected}), values_of(shown, key));
        }
    }
    // tshark decides how it shows invalid UTF-8.
    void text(const std::string& expected, const std::vector<std::string>& shown) {
        if (expected.find("\xEF\xBF\xBD") != std::string::npos) return;
        EXPECT_EQ(shown.empty() ? "" : shown[0], expected) << name_;
        ++compared_;
    }
    // "No data" is not shown as a value.
    void numbers(const ano::Field& f, const Json& expected, const std::vector<std::string>& shown) {
        std::size_t i = 0;
        for (const Json& one : expected) {
            ++compared_;
            if (one.is_null() && f.no_data) continue;
            ASSERT_LT(i, shown.size()) << name_ << " " << f.name;
            const double value = std::strtod(shown[i++].c_str(), nullptr);
            if (one.is_null()) EXPECT_FALSE(std::isfinite(value)) << name_;
            else if (f.type == ano::Type::f32) EXPECT_EQ(static_cast<float>(value), one.get<float>()) << name_ << " " << f.name;
            else EXPECT_NEAR(value, one.get<double>(), 1e-12 * std::abs(value)) << name_ << " " << f.name;
        }
        EXPECT_EQ(i, shown.size()) << name_ << " " << f.name;
    }
    void inner(const Json& expected, const Json& shown) {
        Json found = shown.contains("ano") ? shown["ano"] : Json::array();
        if (found.is_object()) found = Json::array({found});
        ASSERT_EQ(found.size(), expected.size()) << name_;
        const std::string prefix = prefix_;
        for (std::size_t i = 0; i < expected.size(); ++i) frame(expected[i], found[i]);
        prefix_ = prefix;
    }

    std::string name_;
    std::string prefix_;
    std::size_t compared_ = 0;
};

/// The output of tshark for each datagram.
Json dissected(const support::TempDir& folder, const std::string& lua, const std::vector<support::Vector>& vectors) {
    const std::string script = folder.write("ano.lua", lua);
    const std::string capture = folder.write("frames.pcap", pcap_of(vectors));
    const std::string text = output_of("HOME=" + (folder.path() / "").string() + " tshark -r " + capture + " -X lua_script:" +
                                       script + " -T json --no-duplicate-keys 2>" + (folder.path() / "errors").string());
    std::ifstream errors{(folder.path() / "errors").string()};
    for (std::string line; std::getline(errors, line);)
        if (line.find("Lua") != std::string::npos || line.find("lua") != std::string::npos) ADD_FAILURE() << line;
    // tshark prints text that is not UTF-8 unchanged.
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(text.data());
    return text.empty() ? Json::array() : Json::parse(ano::to_utf8({bytes, text.size()}, ano::Encoding::utf8));
}

bool has_tshark() { return !output_of("tshark --version 2>/dev/null").empty(); }

TEST(Tshark, shows_every_golden_vector_as_anoctl_decodes_it) {
    if (!has_tshark()) GTEST_SKIP() << "tshark is not installed";
    const support::TempDir folder;
    const auto vectors = support::golden_vectors();
    const Json packets = dissected(folder, anoctl({"messages", "--lua"}).out, vectors);
    ASSERT_EQ(packets.size(), vectors.size());
    std::size_t compared = 0;
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const std::string raw{vectors[i].bytes.begin(), vectors[i].bytes.end()};
        const Json expected = Json::parse(anoctl({"decode", "--json", "--encoding", "utf8", "-"}, raw).out);
        const Json& layers = packets[i]["_source"]["layers"];
        ASSERT_TRUE(layers.contains("ano")) << vectors[i].name << "\n" << layers.dump(1);
        Comparison comparison{vectors[i].name};
        comparison.frame(expected, layers["ano"]);
        compared += comparison.compared();
    }
    EXPECT_GT(compared, 2 * vectors.size());
}

TEST(Tshark, shows_the_v7_vectors_as_anoctl_decodes_them) {
    if (!has_tshark()) GTEST_SKIP() << "tshark is not installed";
    const support::TempDir folder;
    std::vector<support::Vector> vectors;
    for (const auto& vector : support::v7_vectors("valid")) vectors.push_back({vector.meaning, vector.v7, {}});
    const Json packets = dissected(folder, anoctl({"messages", "--lua"}).out, vectors);
    ASSERT_EQ(packets.size(), vectors.size());
    std::size_t compared = 0;
    for (std::size_t i = 0; i < vectors.size(); ++i) {
        const std::string raw{vectors[i].bytes.begin(), vectors[i].bytes.end()};
        const Json expected = Json::parse(anoctl({"decode", "--v7", "--json", "--encoding", "utf8", "-"}, raw).out);
        const Json& layers = packets[i]["_source"]["layers"];
        ASSERT_TRUE(layers.contains("ano")) << vectors[i].name << "\n" << layers.dump(1);
        Comparison comparison{vectors[i].name};
        comparison.v7_frame(vectors[i].bytes, expected, layers["ano"]);
        compared += comparison.compared();
    }
    EXPECT_GT(compared, 2 * vectors.size());
}

TEST(Tshark, decodes_flexible_layouts_from_a_configuration) {
    if (!has_tshark()) GTEST_SKIP() << "tshark is not installed";
    const support::TempDir folder;
    const std::string config = folder.write("anogate.json", R"({"flexible": [
        {"id": "0xF1", "fields": [{"name": "Volts", "type": "i16", "scale": 0.01, "unit": "V"}, {"name": "温度", "type": "f32"}]},
        {"id": "0xF1", "source": 30, "fields": [{"name": "mine", "type": "u8"}]}]})");
    const auto frame = [](std::uint8_t source, std::vector<std::uint8_t> data) {
        std::vector<std::uint8_t> bytes(ano::overhead + data.size());
        ano::encode(bytes, source, 254, 0xF1, data);
        return support::Vector{"", bytes, {}};
    };
    const Json packets = dissected(folder, anoctl({"messages", "--lua", "--config", config}).out,
                                   {frame(5, {0xC7, 0xFF, 0, 0, 0xC0, 0x3F}), frame(30, {7})});
    ASSERT_EQ(packets.size(), 2u);
    const Json& first = packets[0]["_source"]["layers"]["ano"];
    const Json& second = packets[1]["_source"]["layers"]["ano"];
    EXPECT_EQ(values_of(first, "ano.flexible1.volts"), std::vector<std::string>{"-0.57"});
    EXPECT_EQ(values_of(first, "ano.flexible1.value2"), std::vector<std::string>{"1.5"});
    EXPECT_EQ(values_of(second, "ano.flexible1.30.mine"), std::vector<std::string>{"7"});
}

}    // namespace
}    // namespace tshark_tests
