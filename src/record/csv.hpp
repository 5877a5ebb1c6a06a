// The frames of one message as a table: a line a frame, a column a field. No I/O.
//
//   time [s],link,peer,frame_direction,frame_cause,from,to,rol [°],pit [°],…,frame_extra,frame_data
//
// Values are as in the frame's JSON, in the units of the table; what the layout of a frame does not have, and "no data", is empty. A field of
// several numbers has as many columns: name.0, name.1… What the fields don't tell is in the last columns, as hex: the bytes behind
// the layout, and all of DATA where the fields can't give it back.
#pragma once
#include <ano_json/frame_json.hpp>
#include <record/recording.hpp>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class CsvWriter {
public:
    /// Of message `id`, listed or not. What `options` refers to outlives it.
    CsvWriter(std::uint8_t id, const ano::JsonOptions& options);

    /// Appends the names of the columns.
    void write_heading(std::string& out) const;
    /// Appends a line; `frame` is of this message.
    void write(const RecordedFrame& frame, std::string& out) const;

private:
    struct Column {
        std::string field;
        int element = -1;    // of an array; -1: it is none
        std::string unit;
    };
    void add_columns(std::span<const ano::Field> fields);
    bool has_column(std::string_view field) const;

    ano::JsonOptions options_;
    std::vector<Column> columns_;
};

/// A frame as one line of JSON, as `anoctl monitor --json` shows it; "lost" for a loss.
std::string recorded_json(const Recorded& item, const ano::JsonOptions& options);

}    // namespace anogate
