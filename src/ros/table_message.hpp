// A message of the table as a message of ROS 2, ano_msgs/msg/NAME: the fields of all of its layouts, one behind the other.
//
// A number without scale has the type that it has on the wire; with a scale it is a float64, in its unit. An address is text, bytes are
// uint8[], a list is a sequence of messages. What is not in a frame is never shown as a value: a number that some layout lacks, or
// that has a value for "no data", is a floating-point number, and NaN then; anything else is empty. A field that layouts give in
// different units is one field a unit, with the name of the layout behind its own.
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
    /// Of the message with this id, which is listed and not flexible.
    explicit TableMessage(std::uint8_t id);
    /// Outlived by the layout.
    explicit TableMessage(const ano::FlexibleLayout& layout);

    const RosMessage& type() const noexcept { return type_; }

    /// Appends the values of a frame that can be read as this message.
    void append_values(const ano::Reading& reading, ValueList& out) const;

private:
    struct Column {
        std::vector<const ano::Field*> fields;    // a layout each; null: it has none
        const ano::Field& sample() const noexcept;
        bool is_everywhere() const noexcept;
    };
    struct Layout {
        const ano::Message* row = nullptr;    // null: flexible
        std::span<const ano::Field> fields;
    };
    void build(const std::string& name);
    void add_column(std::size_t layout, const ano::Field& field);
    RosField field_of(const Column& column, const std::string& name);
    const RosMessage* element_of(const Column& column);
    void append_value(const ano::Field& field, const RosField& as, const ano::Reading& reading, ValueList& out) const;

    std::vector<Layout> layouts_;
    std::vector<Column> columns_;    // of type_.fields
    RosMessage type_;
    std::unique_ptr<RosMessage> element_;
};

}    // namespace anogate
