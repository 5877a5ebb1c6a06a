#include <ano_json/text.hpp>
#include <http/listeners/accept.hpp>
#include <status/metrics_text.hpp>

#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

namespace anogate {
namespace {

constexpr char openmetrics_type[] = "application/openmetrics-text";

std::string_view suffix_of(MetricType type) {
    switch (type) {
    case MetricType::counter: return "_total";
    case MetricType::info: return "_info";
    case MetricType::gauge: break;
    }
    return {};
}

std::string_view type_word(MetricType type, MetricsForm form) {
    if (type == MetricType::counter) return "counter";
    return type == MetricType::info && form == MetricsForm::openmetrics ? "info" : "gauge";
}

// The unit at the end of a name, with its '_'.
std::string_view unit_of(std::string_view name) {
    for (const std::string_view unit : {"_seconds", "_bytes"})
        if (name.ends_with(unit)) return unit;
    return {};
}

void append_escaped(std::string& text, std::string_view value) {
    for (const char c : value) {
        if (c == '\\' || c == '"') text += '\\';
        if (c == '\n') text += "\\n";
        else text += c;
    }
}

template <class Number>
void append_number(std::string& text, Number value) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value).ptr;
    text.append(digits.data(), end);
}

}    // namespace

MetricsForm metrics_form(std::string_view accept) {
    const unsigned open = http::quality(accept, openmetrics_type, "1.0.0").value_or(0);
    return open > 0 && open >= http::quality(accept, "text/plain").value_or(0) ? MetricsForm::openmetrics
                                                                               : MetricsForm::prometheus;
}

std::string_view content_type(MetricsForm form) noexcept {
    return form == MetricsForm::openmetrics ? "application/openmetrics-text; version=1.0.0; charset=utf-8"
                                            : "text/plain; version=0.0.4; charset=utf-8";
}

void MetricsText::family(std::string_view name, MetricType type, std::string_view help) {
    name_.assign(name).append(suffix_of(type));
    const std::string_view heading = form_ == MetricsForm::openmetrics ? name : std::string_view{name_};
    text_.append("# HELP ").append(heading).append(" ").append(help).append("\n");
    text_.append("# TYPE ").append(heading).append(" ").append(type_word(type, form_)).append("\n");
    if (const std::string_view unit = unit_of(name); form_ == MetricsForm::openmetrics && !unit.empty())
        text_.append("# UNIT ").append(heading).append(" ").append(unit.substr(1)).append("\n");
}

void MetricsText::sample(std::initializer_list<Label> labels, std::uint64_t value) {
    series(labels);
    append_number(text_, value);
    text_ += '\n';
}

void MetricsText::sample(std::initializer_list<Label> labels, double value) {
    series(labels);
    if (std::isfinite(value)) append_number(text_, value);
    else text_ += std::isnan(value) ? "NaN" : value > 0 ? "+Inf" : "-Inf";
    text_ += '\n';
}

void MetricsText::series(std::initializer_list<Label> labels) {
    text_ += name_;
    if (labels.size() != 0) {
        text_ += '{';
        for (const Label& one : labels) label(one);
        text_.back() = '}';
    }
    text_ += ' ';
}

void MetricsText::label(const Label& label) {
    text_.append(label.name).append("=\"");
    if (ano::is_utf8(label.value)) append_escaped(text_, label.value);
    else {
        const std::string value{label.value};
        append_escaped(text_,
                       ano::to_utf8({reinterpret_cast<const std::uint8_t*>(value.data()), value.size()}, ano::Encoding::utf8));
    }
    text_ += "\",";
}

std::string MetricsText::finish() {
    if (form_ == MetricsForm::openmetrics) text_ += "# EOF\n";
    return std::exchange(text_, {});
}

}    // namespace anogate
