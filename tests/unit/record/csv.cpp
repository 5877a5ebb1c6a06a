#include <gtest/gtest.h>
#include <record/csv.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include <support/bytes.hpp>
#include <support/vectors.hpp>

namespace csv_tests {
namespace {

using namespace anogate;
using support::Bytes;

RecordedFrame recorded(const Bytes& frame) {
    return {.time_ns = 1'763'898'044'123'456'789, .link = "fc", .frame = ano::FrameView{frame}};
}

std::string heading_of(std::uint8_t id) {
    std::string out;
    CsvWriter{id, {}}.write_heading(out);
    return out;
}

std::string line_of(const Bytes& frame) {
    std::string out;
    CsvWriter{ano::FrameView{frame}.id(), {}}.write(recorded(frame), out);
    return out;
}

/// The text after the last quotation mark or comma.
std::vector<std::string> cells_of(std::string line) {
    line.pop_back();
    return support::split_csv_line(line);
}

const std::string first_columns = "time [s],link,peer,frame_direction,frame_cause,from,to,";

TEST(Csv, has_one_column_per_field_with_its_unit) {
    EXPECT_EQ(heading_of(0x03), first_columns + "rol [°],pit [°],yaw [°],fusion_sta,mode,frame_extra,frame_data\n");
    EXPECT_EQ(line_of(support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1})),
              "1763898044.123456789,fc,,in,,220,254,1.23,0,0,1,,,\n");
}

TEST(Csv, names_the_link_peer_and_drop_cause_of_a_frame) {
    const Bytes frame = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
    RecordedFrame dropped = recorded(frame);
    dropped.direction = Direction::dropped;
    dropped.cause = "limited";
    dropped.peer = "a, \"b\"";
    std::string out;
    CsvWriter{0x03, {}}.write(dropped, out);
    EXPECT_EQ(out, "1763898044.123456789,fc,\"a, \"\"b\"\"\",dropped,limited,220,254,1.23,0,0,1,,,\n");
}

TEST(Csv, contains_the_bytes_of_frames_that_it_cannot_read) {
    EXPECT_EQ(heading_of(0x77), first_columns + "frame_extra,frame_data\n");
    EXPECT_EQ(line_of(support::frame(1, 2, 0x77, {0xAB, 0xCD})), "1763898044.123456789,fc,,in,,1,2,,abcd\n");
    EXPECT_EQ(line_of(support::frame(1, 2, 0x03, {0xAB})), "1763898044.123456789,fc,,in,,1,2,,,,,,,ab\n");
    EXPECT_EQ(line_of(support::frame(1, 2, 0x03, Bytes(9))), "1763898044.123456789,fc,,in,,1,2,,,,,,,000000000000000000\n");
    EXPECT_EQ(line_of(support::frame(1, 2, 0x09, {1, 0, 2, 0, 9})), "1763898044.123456789,fc,,in,,1,2,,,,0100020009\n");
    EXPECT_EQ(line_of(support::frame(1, 2, 0x09, {1, 0, 2, 0, 9, 8})), "1763898044.123456789,fc,,in,,1,2,,,,010002000908\n");
}

TEST(Csv, every_value_of_every_message_has_a_cell) {
    for (const support::Vector& vector : support::golden_vectors()) {
        const ano::FrameView frame{vector.bytes};
        const auto names = cells_of(heading_of(frame.id()));
        const auto cells = cells_of(line_of(vector.bytes));
        ASSERT_EQ(cells.size(), names.size()) << vector.name;
        const ano::Json json = ano::frame_to_json(frame);
        if (!json.contains("fields")) {
            EXPECT_EQ(cells.back(), json["data"].get<std::string>()) << vector.name;
            continue;
        }
        for (const auto& [key, value] : json["fields"].items()) {
            const auto begins = [&, name = key](const std::string& column) {
                return column == name || column.starts_with(name + " [") || column.starts_with(name + ".");
            };
            // Of layouts that differ in the unit, one has the value.
            std::string cell;
            bool known = key == "data";
            std::size_t filled = 0;
            for (std::size_t i = 7; i < names.size(); ++i) {
                if (!begins(names[i])) continue;
                known = true;
                if (cell.empty()) cell = cells[i];
                filled += !cells[i].empty();
            }
            ASSERT_TRUE(known) << vector.name << " " << key;
            if (!value.is_array()) {
                EXPECT_LE(filled, 1u) << vector.name << " " << key;
            }
            if (key == "data" && cell.empty()) {
                EXPECT_EQ(cells.back().empty(), value.get<std::string>().empty()) << vector.name;
            } else if (value.is_string()) {
                EXPECT_EQ(cell, value.get<std::string>()) << vector.name << " " << key;
            } else if (value.is_number()) {
                EXPECT_EQ(std::stod(cell), value.get<double>()) << vector.name << " " << key;
            } else if (value.is_null()) {
                EXPECT_EQ(cell, "") << vector.name << " " << key;
            } else {
                EXPECT_EQ(cell.empty(), value.empty() || value[0].is_null()) << vector.name << " " << key << " " << cell;
            }
        }
    }
}

TEST(Csv, a_field_that_two_layouts_have_in_two_units_has_two_columns) {
    std::size_t found = 0;
    const std::string heading = heading_of(0x34);
    for (const char* name : {",dist [cm]", ",dist [mm]"}) found += heading.find(name) != std::string::npos;
    EXPECT_EQ(found, 2u) << heading;
}

TEST(Csv, a_flexible_message_has_the_columns_of_its_layouts) {
    ano::FlexibleLayouts layouts;
    std::string out;
    CsvWriter{0xF1, {&layouts}}.write_heading(out);
    EXPECT_EQ(out, first_columns + "frame_extra,frame_data\n");
}

TEST(Csv, every_number_of_an_array_has_a_cell) {
    ano::FlexibleLayouts layouts;
    ASSERT_FALSE(layouts.add({.id = 0xF1, .fields = {{"a", ano::Type::i16, 0.1, "V", 3}, {"b", ano::Type::f32, 1, ""}}}));
    const Bytes frame = support::frame(5, 0xFE, 0xF1, {1, 0, 0xFE, 0xFF, 100, 0, 0xCD, 0xCC, 0xCC, 0x3D});
    std::string out;
    CsvWriter{0xF1, {&layouts}}.write(recorded(frame), out);
    EXPECT_TRUE(out.ends_with(",5,254,0.1,-0.2,10,0.1,,\n")) << out;
}

TEST(Csv, times_have_nine_digits_after_the_point) {
    const Bytes frame = support::frame(1, 2, 0x77);
    RecordedFrame early = recorded(frame);
    early.time_ns = 1'000'000'007;
    std::string out;
    CsvWriter{0x77, {}}.write(early, out);
    EXPECT_EQ(out, "1.000000007,fc,,in,,1,2,,\n");
}

TEST(Csv, fields_without_a_column_are_in_the_data_of_the_frame) {
    ano::FlexibleLayouts first, then;
    ASSERT_FALSE(first.add({.id = 0xF1, .fields = {{"a", ano::Type::u8, 1, ""}}}));
    ASSERT_FALSE(then.add({.id = 0xF1, .fields = {{"a", ano::Type::u8, 1, ""}, {"cells", ano::Type::u8, 1, "V", 2}}}));
    CsvWriter csv{0xF1, {&first}};
    EXPECT_TRUE(csv.has_columns_for(first));
    EXPECT_FALSE(csv.has_columns_for(then));
    EXPECT_TRUE((CsvWriter{0xF1, {&then}}.has_columns_for(first)));
    EXPECT_TRUE((CsvWriter{0xF2, {&first}}.has_columns_for(then))) << "of another message";
    std::string out;
    csv.write(recorded(support::frame(5, 0xFE, 0xF1, {7})), out);
    EXPECT_TRUE(out.ends_with(",7,,\n")) << out;
    csv.use(then);
    csv.write(recorded(support::frame(5, 0xFE, 0xF1, {7, 8, 9})), out);
    EXPECT_TRUE(out.ends_with(",7,,070809\n")) << out;
    out.clear();
    CsvWriter{0xF1, {&then}}.write_heading(out);
    EXPECT_NE(out.find(",a,cells.0 [V],cells.1 [V],"), std::string::npos) << out;
}

TEST(RecordedJson, has_the_format_that_monitor_shows) {
    const Bytes frame = support::frame(0xDC, 0xFE, 0x03, {0x7B, 0, 0, 0, 0, 0, 1});
    const auto json = ano::Json::parse(recorded_json(Recorded{recorded(frame)}, {}));
    EXPECT_EQ(json["fields"]["rol"], 1.23);
    EXPECT_EQ(json["time"], 1763898044.123456);
    EXPECT_EQ(json["direction"], "in");
    EXPECT_FALSE(json.contains("cause"));
    EXPECT_EQ(recorded_json(Recorded{RecordedLoss{7, "euler 7"}}, {}), R"({"lost":7,"messages":"euler 7"})");
}

}    // namespace
}    // namespace csv_tests
