#include <ano/fault.hpp>

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <string>
#include <vector>

namespace fault_tests {
namespace {

using ano::Fault;
using ano::FaultRow;

std::set<std::string_view> names_in(std::string_view text) {
    const ano::ArgumentNames names = ano::arguments_of(text);
    return {names.begin(), names.end()};
}

TEST(Faults, have_unique_ids_in_snake_case) {
    std::set<std::string_view> ids;
    for (const FaultRow& row : ano::fault_rows) {
        EXPECT_TRUE(ids.insert(row.id).second) << row.id;
        const auto is_allowed = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_'; };
        EXPECT_TRUE(!row.id.empty() && std::all_of(row.id.begin(), row.id.end(), is_allowed)) << row.id;
    }
}

TEST(Faults, have_the_same_placeholders_in_both_languages) {
    for (const FaultRow& row : ano::fault_rows) {
        EXPECT_EQ(names_in(row.english), names_in(row.chinese)) << row.id;
        EXPECT_EQ(row.chinese.find_first_of(":|"), row.chinese.npos) << row.id << ": the page knows no other forms";
        EXPECT_TRUE(row.status == 0 || (row.status >= 400 && row.status < 600)) << row.id;
    }
}

TEST(Faults, are_rendered_with_all_their_arguments) {
    for (const FaultRow& row : ano::fault_rows) {
        std::vector<Fault::Argument> arguments;
        for (const std::string_view name : ano::arguments_of(row.english)) arguments.emplace_back("<" + std::string{name} + ">");
        const std::string text = Fault{row, arguments}.text();
        EXPECT_EQ(text.find_first_of("{}"), text.npos) << text;
        for (const Fault::Argument& argument : arguments) EXPECT_NE(text.find(argument.text), text.npos) << text;
    }
}

TEST(Faults, inflect_a_word_by_a_number) {
    EXPECT_EQ((Fault{"silent", "0xDC", "save", 1}.text()), "0xDC does not answer: save, sent 1 time");
    EXPECT_EQ((Fault{"silent", "0xDC", "save", 2}.text()), "0xDC does not answer: save, sent 2 times");
}

TEST(Faults, contain_clauses_and_have_further_ones) {
    Fault fault{"rejected", Fault{"no_better", "3 %", "2 %"}};
    fault.add({"old_values_not_restored_why", Fault{"silent", "0xDC", Fault{"write_of", "A"}, 5u}}).add({});
    EXPECT_EQ(fault.text(),
              "rejected: the residual would be 3 %, and is 2 %; the old values could not be written back: 0xDC does not "
              "answer: write of A, sent 5 times");
    EXPECT_EQ(fault.id(), "rejected");
    EXPECT_TRUE(fault.is("rejected"));
    ASSERT_EQ(fault.remarks().size(), 1u);
    EXPECT_EQ(
        fault.converted([](std::string_view) { return "x"; }).text(),
        "rejected: the residual would be x, and is x; the old values could not be written back: x does not answer: write of x, "
        "sent x times");
}

TEST(Faults, without_an_id_are_empty_until_a_clause_is_added) {
    Fault fault;
    EXPECT_TRUE(fault.empty());
    EXPECT_EQ(fault.text() + std::string{fault.id()}, "");
    EXPECT_EQ(fault.add({"cancelled"}).id(), "cancelled");
    EXPECT_EQ((Fault{"value_unfit", "A", "1", Fault{"other", "is odd"}}.arguments()[2].text), "is odd") << "only a text";
}

}    // namespace
}    // namespace fault_tests
