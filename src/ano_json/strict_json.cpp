#include <ano_json/json_pointer.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/syntax_fault.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <utility>

namespace ano {

/// Finds keys given twice and too deep nesting. The library's own callback would do, but looks through all elements of an array at the
/// end of each: a short body of many small objects would take seconds.
template <class Document>
class StrictWatch final : public nlohmann::json_sax<Document> {
public:
    explicit StrictWatch(std::vector<JsonFault>& faults) : faults_{faults} {}

    bool null() override { return count(); }
    bool boolean(bool) override { return count(); }
    bool number_integer(typename Document::number_integer_t) override { return count(); }
    bool number_unsigned(typename Document::number_unsigned_t) override { return count(); }
    bool number_float(typename Document::number_float_t, const std::string&) override { return count(); }
    bool string(std::string&) override { return count(); }
    bool binary(typename Document::binary_t&) override { return count(); }
    bool start_object(std::size_t) override { return enter(false); }
    bool start_array(std::size_t) override { return enter(true); }
    bool end_object() override { return leave(); }
    bool end_array() override { return leave(); }
    bool key(std::string& name) override {
        places_.back().key = name;
        if (!places_.back().keys.insert(name).second) faults_.push_back({pointer(), in_quotes(name) + " is given twice"});
        return true;
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override { return false; }

    bool too_deep() const { return too_deep_; }

private:
    struct Place {
        bool array;
        std::size_t count = 0;    // of an array: elements begun so far
        std::string key{};
        std::set<std::string> keys{};
    };

    bool count() {
        if (!places_.empty()) ++places_.back().count;
        return true;
    }

    bool enter(bool array) {
        count();
        if (places_.size() == max_json_depth) {
            faults_.push_back({pointer(), "nested deeper than " + std::to_string(max_json_depth) + " levels"});
            too_deep_ = true;
            return false;
        }
        places_.push_back({array});
        return true;
    }

    bool leave() {
        places_.pop_back();
        return true;
    }

    std::string pointer() const {
        std::string text;
        for (const Place& place : places_) text += place.array ? "/" + std::to_string(place.count - 1) : pointer_step(place.key);
        return text;
    }

    std::vector<JsonFault>& faults_;
    std::vector<Place> places_;
    bool too_deep_ = false;
};

template <class Document>
std::optional<Document> strict_json(std::string_view text, bool with_comments, std::vector<JsonFault>& faults) {
    if (const std::size_t nul = text.find('\0'); nul != text.npos) {    // the parser would stop there
        const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n') + 1;
        faults.push_back({"", "line " + std::to_string(line) + ": a byte 0, which no text has"});
        return std::nullopt;
    }
    StrictWatch<Document> watch{faults};
    Document::sax_parse(text, &watch, nlohmann::json::input_format_t::json, true, with_comments);
    if (watch.too_deep()) return std::nullopt;
    try {
        return Document::parse(text, nullptr, true, with_comments);
    } catch (const typename Document::exception& error) {
        faults.push_back({"", syntax_fault(text, error)});
    }
    return std::nullopt;
}

template <class Document>
std::optional<Document> strict_json(std::string_view text) {
    std::vector<JsonFault> faults;
    auto document = strict_json<Document>(text, false, faults);
    return faults.empty() ? std::move(document) : std::nullopt;
}

template std::optional<nlohmann::json> strict_json(std::string_view);
template std::optional<nlohmann::ordered_json> strict_json(std::string_view);
template std::optional<nlohmann::json> strict_json(std::string_view, bool, std::vector<JsonFault>&);
template std::optional<nlohmann::ordered_json> strict_json(std::string_view, bool, std::vector<JsonFault>&);

std::variant<nlohmann::ordered_json, std::string> json_body(std::string_view text, std::string_view what) {
    std::vector<JsonFault> faults;
    auto document = strict_json<nlohmann::ordered_json>(text, false, faults);
    if (document && faults.empty()) return *std::move(document);
    const JsonFault& first = faults.front();
    return first.pointer.empty() ? std::string{what} + " is no JSON: " + first.what : first.pointer + ": " + first.what;
}

}    // namespace ano
