#include <ano_json/json_pointer.hpp>
#include <ano_json/syntax_fault.hpp>
#include <config/json_text.hpp>
#include <config/key_facts.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using nlohmann::json;

constexpr std::size_t max_depth = 32;

/// The parser's callback: finds keys given twice and too deep nesting.
class Watch {
public:
    Watch(const std::string& file, ConfigErrors& errors) : file_{file}, errors_{errors} {}

    /// Returns false: the parser drops the value that follows.
    bool operator()(json::parse_event_t event, const json& value) {
        if (too_deep_) return false;
        switch (event) {
        case json::parse_event_t::object_start:
        case json::parse_event_t::array_start: enter(event == json::parse_event_t::array_start); return !too_deep_;
        case json::parse_event_t::object_end:
        case json::parse_event_t::array_end: places_.pop_back(); break;
        case json::parse_event_t::key: key(value.get_ref<const std::string&>()); break;
        case json::parse_event_t::value: count(); break;
        }
        return true;
    }

    bool too_deep() const { return too_deep_; }

private:
    struct Place {
        bool array;
        std::size_t count = 0;    // of an array: elements begun so far
        std::string key{};
        std::set<std::string> keys{};
    };

    void count() {
        if (!places_.empty()) ++places_.back().count;
    }

    void enter(bool array) {
        count();
        if (places_.size() == max_depth) {
            errors_.push_back({at(file_, pointer()), "nested deeper than " + std::to_string(max_depth) + " levels"});
            too_deep_ = true;
            return;
        }
        places_.push_back({array});
    }

    void key(const std::string& name) {
        places_.back().key = name;
        if (!places_.back().keys.insert(name).second)
            errors_.push_back({at(file_, pointer()), in_quotes(name) + " is given twice"});
    }

    std::string pointer() const {
        std::string text;
        for (const Place& place : places_)
            text += place.array ? "/" + std::to_string(place.count - 1) : ano::pointer_step(place.key);
        return text;
    }

    const std::string& file_;
    ConfigErrors& errors_;
    std::vector<Place> places_;
    bool too_deep_ = false;
};

}    // namespace

std::optional<json> parse_json(std::string_view text, const std::string& file, ConfigErrors& errors) {
    if (const std::size_t nul = text.find('\0'); nul != text.npos) {    // the parser would stop there
        const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n') + 1;
        errors.push_back({file, "line " + std::to_string(line) + ": a byte 0, which no text has"});
        return std::nullopt;
    }
    Watch watch{file, errors};
    const auto follow = [&watch](int, json::parse_event_t event, json& value) { return watch(event, value); };
    try {
        json document = json::parse(text, follow, true, true);
        if (!watch.too_deep()) return document;
    } catch (const json::exception& error) {
        if (!watch.too_deep()) errors.push_back({file, ano::syntax_fault(text, error)});
    }
    return std::nullopt;
}

std::string at(const std::string& file, const std::string& pointer) {
    return file.empty() || pointer.empty() ? file + pointer : file + ": " + pointer;
}

}    // namespace anogate
