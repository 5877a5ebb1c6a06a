#include <config/key_facts.hpp>
#include <mqtt/allowed_requests.hpp>

#include <algorithm>
#include <array>

namespace anogate {
namespace {

constexpr std::array<std::string_view, 4> methods{"GET", "POST", "PUT", "DELETE"};
constexpr std::array<std::string_view, 4> always{"GET /status", "GET /devices", "GET /alarms", "GET /jobs"};

std::string_view method_of(std::string_view rule) { return rule.substr(0, rule.find(' ')); }
std::string_view path_of(std::string_view rule) { return rule.substr(std::min(rule.find(' ') + 1, rule.size())); }

// An encoded '/' must not hide the end of a step.
bool is_plain(std::string_view step) { return !step.empty() && step != "." && step != ".." && step.find('%') == step.npos; }

bool covers(std::string_view rule, std::string_view method, std::string_view path) {
    if (method_of(rule) != method) return false;
    const auto wanted = split(path_of(rule).substr(1), '/'), steps = split(path.substr(1), '/');
    if (steps.size() < wanted.size()) return false;
    for (std::size_t i = 0; i < wanted.size(); ++i)
        if (wanted[i] == "*" ? !is_plain(steps[i]) : wanted[i] != steps[i]) return false;
    return true;
}

}    // namespace

std::string fault_in_rule(std::string_view rule) {
    if (std::find(methods.begin(), methods.end(), method_of(rule)) == methods.end())
        return in_quotes(rule) + " does not begin with GET, POST, PUT or DELETE";
    const std::string_view path = path_of(rule);
    if (path.size() < 2 || path.front() != '/' || path.back() == '/' || path.find_first_of(" ?#%") != path.npos)
        return in_quotes(rule) + " has no path such as /devices/*/commands";
    return {};
}

bool AllowedRequests::allows(std::string_view method, std::string_view target) const {
    const std::string_view path = target.substr(0, target.find('?'));
    if (path.size() < 2 || path.front() != '/') return false;
    const auto steps = split(path.substr(1), '/');
    if (std::any_of(steps.begin(), steps.end(), [](auto step) { return step.empty() || step == "." || step == ".."; }))
        return false;
    const auto by = [&](std::string_view rule) { return covers(rule, method, path); };
    return std::any_of(always.begin(), always.end(), by) || std::any_of(rules_.begin(), rules_.end(), by);
}

}    // namespace anogate
