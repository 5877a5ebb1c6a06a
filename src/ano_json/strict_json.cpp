#include <ano_json/json_pointer.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/syntax_fault.hpp>
#include <ano_json/text.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>
#include <utility>

namespace ano {
namespace {

struct Limits {
    std::size_t faults;    // reading ends at this number of faults
    std::size_t values = SIZE_MAX;
};

/// Builds the document in approximately linear time. With the library's own parser, each key of an ordered object is compared
/// with all keys before it, and its callback examines all elements of an array at the end of each.
template <class Document>
class StrictReader final : public nlohmann::json_sax<Document> {
public:
    /// Reading ends at fault number `limits.faults`.
    StrictReader(std::string_view text, const Limits& limits, std::vector<JsonFault>& faults)
        : text_{text}, limits_{limits}, faults_{faults} {}

    bool null() override { return add(nullptr); }
    bool boolean(bool value) override { return add(value); }
    bool number_integer(typename Document::number_integer_t value) override { return add(value); }
    bool number_unsigned(typename Document::number_unsigned_t value) override { return add(value); }
    bool number_float(typename Document::number_float_t value, const std::string&) override { return add(value); }
    bool string(std::string& value) override { return add(std::move(value)); }
    bool binary(typename Document::binary_t&) override { return false; }
    bool start_object(std::size_t) override { return enter(Document::object()); }
    bool start_array(std::size_t) override { return enter(Document::array()); }
    bool end_object() override { return leave(); }
    bool end_array() override { return leave(); }
    bool key(std::string& name) override {
        places_.back().key = name;
        return places_.back().keys.insert(name).second || fault(in_quotes(name) + " is given twice");
    }
    bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception& error) override {
        faults_.push_back({"", syntax_fault(text_, error)});
        return false;
    }

    Document root{};

private:
    struct Place {
        Document* at;    // does not move while it is the last element of its parent
        std::string key{};
        std::set<std::string> keys{};
    };

    bool fault(std::string what) {
        faults_.push_back({pointer(), std::move(what)});
        return faults_.size() < limits_.faults;
    }

    /// Returns the new place of the value; nullptr: there are too many.
    Document* put(Document&& value) {
        if (++values_ > limits_.values) {
            fault("more than " + std::to_string(limits_.values) + " values");
            return nullptr;
        }
        if (places_.empty()) return &(root = std::move(value));
        Place& place = places_.back();
        if (place.at->is_array()) {
            place.at->push_back(std::move(value));
            return &place.at->back();
        }
        auto& object = place.at->template get_ref<typename Document::object_t&>();
        if constexpr (requires { typename Document::object_t::Container; }) {
            typename Document::object_t::Container& members = object;
            return &members.emplace_back(place.key, std::move(value)).second;
        } else {
            return &object.insert_or_assign(place.key, std::move(value)).first->second;
        }
    }

    bool add(Document&& value) { return put(std::move(value)) != nullptr; }

    bool enter(Document&& value) {
        if (places_.size() == max_json_depth) {
            fault("nested deeper than " + std::to_string(max_json_depth) + " levels");
            return false;
        }
        Document* const at = put(std::move(value));
        if (at != nullptr) places_.push_back({at});
        return at != nullptr;
    }

    bool leave() {
        places_.pop_back();
        return true;
    }

    // The pointer of the next value, which the innermost array does not contain yet.
    std::string pointer() const {
        std::string text;
        for (const Place& place : places_) {
            const bool is_innermost = &place == &places_.back();
            text += place.at->is_array() ? "/" + std::to_string(place.at->size() - (is_innermost ? 0 : 1))
                                         : pointer_step(place.key);
        }
        return text;
    }

    std::string_view text_;
    Limits limits_;
    std::vector<JsonFault>& faults_;
    std::size_t values_ = 0;
    std::vector<Place> places_;
};

}    // namespace

template <class Document>
std::optional<Document> strict_json(std::string_view text, bool with_comments, std::vector<JsonFault>& faults,
                                    const Limits& limits) {
    if (const std::size_t nul = text.find('\0'); nul != text.npos) {    // the parser would stop there
        const auto line = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n') + 1;
        faults.push_back({"", "line " + std::to_string(line) + ": contains a NUL byte"});
        return std::nullopt;
    }
    StrictReader<Document> reader{text, limits, faults};
    const bool is_whole = Document::sax_parse(text, &reader, nlohmann::json::input_format_t::json, true, with_comments);
    return is_whole ? std::optional{std::move(reader.root)} : std::nullopt;
}

template <class Document>
std::optional<Document> strict_json(std::string_view text, bool with_comments, std::vector<JsonFault>& faults) {
    return strict_json<Document>(text, with_comments, faults, Limits{.faults = 20});
}

template <class Document>
std::optional<Document> strict_json(std::string_view text) {
    std::vector<JsonFault> faults;
    auto document = strict_json<Document>(text, false, faults, Limits{.faults = 1});
    return faults.empty() ? std::move(document) : std::nullopt;
}

template std::optional<nlohmann::json> strict_json(std::string_view);
template std::optional<nlohmann::ordered_json> strict_json(std::string_view);
template std::optional<nlohmann::json> strict_json(std::string_view, bool, std::vector<JsonFault>&);
template std::optional<nlohmann::ordered_json> strict_json(std::string_view, bool, std::vector<JsonFault>&);

std::variant<nlohmann::ordered_json, std::string> json_body(std::string_view text, std::string_view what,
                                                            std::size_t most_values) {
    std::vector<JsonFault> faults;
    auto document = strict_json<nlohmann::ordered_json>(text, false, faults, Limits{.faults = 1, .values = most_values});
    if (document && faults.empty()) return *std::move(document);
    const JsonFault& first = faults.front();
    return first.pointer.empty() ? std::string{what} + " is not JSON: " + first.what : first.pointer + ": " + first.what;
}

}    // namespace ano
