#include "table.hpp"

#include <algorithm>
#include <cstdio>
#include <iostream>

namespace bench {
namespace {

// Three significant digits, with separators for thousands.
std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*f", value == 0 || value >= 100 ? 0 : value < 1 ? 3 : value < 10 ? 2 : 1, value);
    std::string result = text;
    for (std::size_t at = std::min(result.find('.'), result.size()); at > 3; at -= 3) result.insert(at - 3, ",");
    return result;
}

std::string middle_half(const std::vector<double>& values) {
    const std::string low = number(quantile(values, 0.25)), high = number(quantile(values, 0.75));
    return values.size() < 2 || low == high ? "" : " (" + low + "–" + high + ")";
}

}    // namespace

std::string Goal::text(const std::string& unit) const {
    if (kind == Kind::none) return {};
    char text[32];
    std::snprintf(text, sizeof text, "%s %g", kind == Kind::at_least ? "≥" : "≤", bound);
    return text + unit;
}

double quantile(std::vector<double> values, double share) {
    if (values.empty()) return 0;
    std::sort(values.begin(), values.end());
    return values[std::min(static_cast<std::size_t>(share * static_cast<double>(values.size())), values.size() - 1)];
}

void Table::compare(const std::string& what, const std::vector<double>& ours, const std::vector<double>& beside, Goal goal) {
    std::vector<double> ratios;
    for (std::size_t i = 0; i < std::min(ours.size(), beside.size()); ++i) ratios.push_back(ours[i] / beside[i]);
    const double ratio = quantile(ratios);
    add({what, goal.text(" ×"), number(quantile(ours)), number(quantile(beside)), number(ratio) + " ×" + middle_half(ratios),
         verdict(goal, ratio)});
}

void Table::measure(const std::string& what, const std::vector<double>& values, Goal goal) {
    const double value = quantile(values);
    add({what, goal.text(""), number(value) + middle_half(values), "", "", verdict(goal, value)});
}

void Table::skip(const std::string& what, const std::string& why) { add({what, "", "", "", "", "skipped: " + why}); }

void Table::add(Row row) {
    std::cerr << row.what << ": " << row.ours << ' ' << row.beside << ' ' << row.ratio << ' ' << row.verdict << '\n';
    rows_.push_back(std::move(row));
}

std::string Table::verdict(Goal goal, double value) {
    const bool met = goal.met(value);
    all_met_ &= met;
    return goal.kind == Goal::Kind::none ? "" : met ? "pass" : "**miss**";
}

void Table::print() const {
    std::cout << "| measured | goal | anogate | beside it | ratio | |\n|---|---:|---:|---:|---:|---|\n";
    for (const Row& row : rows_)
        std::cout << "| " << row.what << " | " << row.goal << " | " << row.ours << " | " << row.beside << " | " << row.ratio
                  << " | " << row.verdict << " |\n";
}

}    // namespace bench
