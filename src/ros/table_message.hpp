// A message of the table as a ROS 2 message, ano_msgs/msg/NAME, with the fields of all its layouts.
//
// A number without a scale keeps its type on the wire; with a scale it becomes a float64 in its unit. An address is text, bytes are
// uint8[], a list is a sequence of messages. Missing values are never shown as a value: a number that some layout lacks, or that has a
// value for "no data", has a floating-point type and is NaN if missing; other types are empty. A field whose unit differs between
// layouts becomes one field for each unit, with the name of the layout appended.
#pragma once
#include <ano/flexible.hpp>
#include <ano/reading.hpp>
#include <ros/ros_message.hpp>
#include <ros/value_list.hpp>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace anogate {

class TableMessage {
public:
    /// For the message `id`, which must be in the table and not flexible.
    explicit TableMessage(std::uint8_t id);
    /// `layout` must outlive this object.
    explicit TableMessage(const ano::FlexibleLayout& layout);

    const RosMessage& type() const noexcept { return type_; }

    /// Appends the values of a frame that this message describes.
    void append_values(const ano::Reading& reading, ValueList& out) const;

private:
    struct Column {
        std::vector<const ano::Field*> fields;    // one per layout; nullptr: the layout lacks the field
        const ano::Field& sample() const noexcept;
        bool is_everywhere() const noexcept;
    };
    struct Layout {
        const ano::Message* row = nullptr;    // nullptr: flexible
        std::span<const ano::Field> fields;
    };
    void build(const std::string& name);
    void add_column(std::size_t layout, const ano::Field& field);
    RosField field_of(const Column& column, const std::string& name);
    const RosMessage* element_of(const Column& column);
    void append_value(const ano::Field& field, const RosField& as, const ano::Reading& reading, ValueList& out) const;

    std::vector<Layout> layouts_;
    std::vector<Column> columns_;    // in the order of type_.fields
    RosMessage type_;
    std::unique_ptr<RosMessage> element_;
};

}    // namespace anogate
