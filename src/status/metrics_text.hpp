// The text that Prometheus reads: https://prometheus.io/docs/instrumenting/exposition_formats and OpenMetrics 1.0.0.
#pragma once
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>

namespace anogate {

enum class MetricsForm : std::uint8_t { prometheus, openmetrics };
/// The form that the Accept header of a request selects; without one, the older form (prometheus).
MetricsForm metrics_form(std::string_view accept);
std::string_view content_type(MetricsForm form) noexcept;

enum class MetricType : std::uint8_t { counter, gauge, info };

/// Flow: family(), then its samples; the next family; take().
class MetricsText {
public:
    struct Label {
        std::string_view name, value;    // a value may hold any bytes
    };

    explicit MetricsText(MetricsForm form) : form_{form} {}

    /// `name` without the suffix of its type: "_total", "_info".
    void family(std::string_view name, MetricType type, std::string_view help);
    void sample(std::initializer_list<Label> labels, std::uint64_t value);
    void sample(std::initializer_list<Label> labels, double value);
    std::string finish();

private:
    void series(std::initializer_list<Label> labels);
    void label(const Label& label);

    MetricsForm form_;
    std::string name_;    // of the current family, with the suffix
    std::string text_;
};

}    // namespace anogate
