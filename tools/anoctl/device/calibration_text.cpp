#include "calibration_text.hpp"

#include "parameter_file.hpp"

#include <ano_json/text.hpp>
#include <anoctl/text/gateway_json.hpp>
#include <anoctl/text/table.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <sstream>
#include <string_view>

namespace anoctl {

using ano::Json;

namespace {

constexpr std::array<std::string_view, 6> faces{"+x", "-x", "+y", "-y", "+z", "-z"};
constexpr std::size_t bands = 6, sectors = 12;    // of the sphere, as in GET /jobs: band 0 is at the bottom

bool lists(const Json& array, std::string_view word) {
    return std::any_of(array.begin(), array.end(), [&](const Json& one) { return one.is_string() && one == word; });
}

std::string in_the_middle(const std::string& word, std::size_t cells) {
    const std::size_t room = cells - std::min(cells, word.size());
    return std::string(room / 2, ' ') + word + std::string(room - room / 2, ' ');
}

std::string percent(double share) { return ano::number_text(std::round(std::clamp(share, 0.0, 1.0) * 100)) + " %"; }

std::vector<std::string> box_with(const std::string& up) {
    return {
        R"(     __________ )",  "    /" + in_the_middle(up, 10) + "/|",
        R"(   /__________/ |)", R"(   |          | |)",
        R"(   |          | /)", R"(   |__________|/ )",
    };
}

std::vector<std::string> faces_drawn(const Json& step) {
    const std::string up = text_at(step, "face");
    std::vector<std::string> lines = box_with(up.empty() ? "?" : up + " up");
    for (std::size_t i = 0; i < faces.size(); ++i) {
        const std::string face{faces[i]};
        const bool is_done = lists(at(step, "done"), face), is_up = face == up;
        lines[i].resize(20, ' ');
        lines[i] += (is_done ? "[x] " : is_up ? "[>] " : "[ ] ") + face;
        if (is_up && !is_done)
            lines[i] += ", " + percent(number_at(at(step, "faces"), face)) + ", still " + percent(number_at(step, "still"));
        if (is_up && is_done) lines[i] += ", done: turn it to the next face";
    }
    return lines;
}

// One line per band, from top to bottom; the sectors of a band begin at the x axis.
std::vector<std::string> sphere_drawn(const Json& step) {
    const Json& covered = at(step, "coverage");
    std::vector<std::string> lines;
    for (std::size_t band = bands; band-- > 0;) {
        std::string line = band == bands - 1 ? "   +z   " : band == 0 ? "   -z   " : "        ";
        for (std::size_t sector = 0; sector < sectors; ++sector) {
            const std::size_t cell = band * sectors + sector;
            const bool is_covered = cell < covered.size() && covered[cell].is_number() && covered[cell] > 0;
            line += is_covered ? " #" : " .";
        }
        lines.push_back(line);
    }
    lines.push_back("   " + percent(number_at(step, "filled")) + " of all directions (80 % required); turn it toward the dots");
    return lines;
}

std::string residual_text(double residual, bool is_share) {
    std::array<char, 40> text{};
    if (is_share) std::snprintf(text.data(), text.size(), "%.2g %%", residual * 100);
    else std::snprintf(text.data(), text.size(), "%.3g cm/s\u00B2", residual);
    return text.data();
}

}    // namespace

std::vector<std::string> calibration_lines(const Json& job) {
    const Json& step = at(job, "step");
    if (step.contains("coverage")) return sphere_drawn(step);
    return step.contains("done") ? faces_drawn(step) : std::vector<std::string>{};
}

std::vector<std::string> broken_lines(const std::vector<std::string>& lines, std::size_t width) {
    std::vector<std::string> all;
    for (const std::string& line : lines) {
        std::istringstream parts{wrapped(line, width - std::min<std::size_t>(width, 1), 4)};
        for (std::string part; std::getline(parts, part);) all.push_back(part);
    }
    return all;
}

std::string calibration_step(const Json& job) {
    const Json& step = at(job, "step");
    if (step.contains("coverage")) {
        const double tenths = std::floor(std::clamp(number_at(step, "filled"), 0.0, 1.0) * 10);
        return percent(tenths / 10) + " of all directions";
    }
    const Json& done = at(step, "done");
    if (!step.contains("done")) return {};
    std::string words = std::to_string(done.size()) + " of 6 faces";
    for (const std::string_view face : faces)
        if (lists(done, face)) words += (words.ends_with("faces") ? ": " : ", ") + std::string{face};
    return words;
}

std::vector<std::string> calibration_result(const Json& result, const std::string& what) {
    const bool is_share = what == "compass";
    std::vector<std::string> lines{"residual " + residual_text(number_at(result, "before"), is_share) + " before, " +
                                   residual_text(number_at(result, "after"), is_share) + " now"};
    if (result.contains("verified"))
        lines.push_back("measured with the new values: " + residual_text(number_at(result, "verified"), is_share));
    if (result.contains("error_matrix"))
        lines.emplace_back("the error matrix (CAL_AEM) is unchanged: to measure it, lay each face level to 0.2\u00B0");
    if (const double restarts = number_at(result, "restarts"); restarts > 0)
        lines.push_back("the device restarted " + ano::number_text(restarts) + (restarts > 1 ? " times" : " time") +
                        " during the calibration; only samples after that were used");
    for (const auto& [name, value] : at(result, "values").items())
        lines.push_back(without_controls(name) + "=" + plain_at(at(result, "values"), name.c_str()));
    lines.emplace_back("saved permanently in the device");
    return lines;
}

}    // namespace anoctl
