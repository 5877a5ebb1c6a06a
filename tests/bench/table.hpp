// The table of results, each with its comparison and whether the goal is met.
#pragma once
#include <string>
#include <vector>

namespace bench {

struct Goal {
    enum class Kind { at_least, at_most, none } kind;
    double bound;

    bool met(double value) const noexcept {
        return kind == Kind::none || (kind == Kind::at_least ? value >= bound : value <= bound);
    }
    /// Followed by `unit`.
    std::string text(const std::string& unit) const;
};
constexpr Goal at_least(double bound) { return {Goal::Kind::at_least, bound}; }
constexpr Goal at_most(double bound) { return {Goal::Kind::at_most, bound}; }
constexpr Goal no_goal{Goal::Kind::none, 0};

/// The median, or the value at another share of the order from the lowest to the highest.
double quantile(std::vector<double> values, double share = 0.5);

class Table {
public:
    /// Both sides round by round: the goal applies to the median of their ratios.
    void compare(const std::string& what, const std::vector<double>& ours, const std::vector<double>& beside, Goal goal);
    /// One value per round: the goal applies to their median.
    void measure(const std::string& what, const std::vector<double>& values, Goal goal);
    void skip(const std::string& what, const std::string& why);

    bool all_met() const noexcept { return all_met_; }
    /// Prints it as Markdown to standard output.
    void print() const;

private:
    struct Row {
        std::string what, goal, ours, beside, ratio, verdict;
    };
    void add(Row row);
    std::string verdict(Goal goal, double value);

    std::vector<Row> rows_;
    bool all_met_ = true;
};

}    // namespace bench
