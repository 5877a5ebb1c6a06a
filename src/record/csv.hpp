// The frames of one message as a CSV table: a line for each frame, a column for each field. No I/O.
//
//   time [s],link,peer,frame_direction,frame_cause,from,to,rol [°],pit [°],…,frame_extra,frame_data
//
// Values are as in the frame's JSON, in the units of the message table. A cell is empty for "no data" and for a field that the layout of
// the frame lacks. A field of several numbers has several columns: name.0, name.1… The last columns have, as hex, the bytes after the
// layout, and all of DATA if the fields can't restore it.
#pragma once
#include <ano_json/frame_json.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace anogate {

class CsvWriter {
public:
    /// For message `id`, which need not be in the table of messages. What `options` refers to must outlive the writer.
    CsvWriter(std::uint8_t id, const ano::JsonOptions& options);

    /// Layouts of the frames that follow. The columns stay: a line whose layout has a field without a column has all of DATA.
    void use(const ano::FlexibleLayouts& flexible);
    /// Whether each field that this message has in `flexible` has a column.
    bool has_columns_for(const ano::FlexibleLayouts& flexible) const;

    /// The encoding of the texts in the lines that follow.
    void read_as(ano::Encoding encoding) noexcept { options_.encoding = encoding; }

    /// Appends the names of the columns.
    void write_heading(std::string& out) const;
    /// Appends a line; `frame` must be of this message.
    void write(const RecordedFrame& frame, std::string& out);

private:
    struct Column {
        std::string_view field;
        int element = -1;    // index in an array; -1: not an array
        std::string_view unit;

        bool is_of(const ano::Field& f) const { return field == f.name && unit == f.unit; }
        friend bool operator==(const Column&, const Column&) = default;
    };
    /// The fields of a layout, by the column that each fills.
    struct Cells {
        std::vector<const ano::Field*> fields;    // by column; nullptr: the layout lacks it
        bool are_all = true;                      // every field has a column
    };
    void add_columns(std::span<const ano::Field> fields);
    const Cells& cells_of(std::span<const ano::Field> layout);
    void write_cell(const ano::Reading& reading, const ano::Field& field, int element, std::string& out);

    std::uint8_t id_;
    ano::JsonOptions options_;
    std::vector<Column> columns_;
    std::unordered_map<const ano::Field*, Cells> cells_;    // by the first field of a layout
    std::string json_;
};

/// A frame as one line of JSON, as `anoctl monitor --json` shows it; "lost" for a loss.
std::string recorded_json(const Recorded& item, const ano::JsonOptions& options);

}    // namespace anogate
