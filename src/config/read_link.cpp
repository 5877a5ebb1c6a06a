#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <config/config.hpp>
#include <config/config_error.hpp>
#include <config/link_kind.hpp>
#include <config/read_link.hpp>
#include <config/values.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

/// The error for a text that is not KIND:ADDRESS.
std::string no_kind(LinkKinds kinds, std::string_view text) {
    if (const LinkKind* kind = find_link_kind(kinds, text.substr(0, text.find(','))))
        return "the address is missing, for example " + std::string{kind->name} + ":" + std::string{kind->example};
    for (const LinkKind* kind : kinds)
        if (const std::string meant = kind->meant_by ? kind->meant_by(text) : ""; !meant.empty())
            return "the kind is missing (did you mean " + meant + "?)";
    return "a LINK is KIND:ADDRESS[,KEY=VALUE...], for example serial:/dev/ttyUSB0,baud=500000";
}

/// The hint for a full-width separator of a Chinese input method; empty: there is none.
std::string full_width(std::string_view text) {
    for (const auto& [wide, narrow] : {std::pair{"\uFF0C", ","}, {"\uFF1A", ":"}, {"\uFF1D", "="}})
        if (text.find(wide) != text.npos) return std::string{"full-width '"} + wide + "': write '" + narrow + "'";
    return {};
}

/// The hint for a KEY=VALUE in the place of a LINK, after a space instead of a comma; empty: it is none.
std::string key_apart(LinkKinds kinds, std::string_view text) {
    const std::size_t equals = text.find('=');
    const std::string_view name = text.substr(0, equals);
    if (equals == text.npos || (!name.starts_with("limit.") && find_key_of_any(kinds, name) == nullptr)) return {};
    return in_quotes(name) + " is a key: append it to its LINK with a comma and no space: KIND:ADDRESS," +
           printable(std::string{text});
}

/// Reads one LINK text, part by part.
class LinkText {
public:
    LinkText(std::string where, Draft& draft) : where_{std::move(where)}, draft_{draft} {}

    void read(std::string_view text) {
        const std::size_t before = draft_.errors.size();
        const std::size_t colon = text.find(':');
        const LinkKind* kind = colon != text.npos ? find_link_kind(draft_.kinds, text.substr(0, colon)) : nullptr;
        if (!ano::is_utf8(text)) {
            error("not UTF-8 text");
        } else if (std::string wide = full_width(text); !wide.empty()) {
            error(std::move(wide));
        } else if (std::string apart = key_apart(draft_.kinds, text); !apart.empty()) {
            error(std::move(apart));
        } else if (colon == text.npos || text.starts_with('/') || EndpointSpec::parse(text)) {
            error(no_kind(draft_.kinds, text));
        } else if (kind == nullptr) {
            error(unknown_kind(draft_.kinds, text.substr(0, colon)));
        } else {
            link_ = new_link(*kind);
            keys_ = keys_of(*kind, draft_.kinds);
            read_values(*kind, text.substr(colon + 1));
        }
        draft_.add(std::move(link_), {where_, false, draft_.errors.size() > before});
    }

private:
    void error(std::string what) { draft_.errors.push_back({where_, std::move(what)}); }

    void read_values(const LinkKind& kind, std::string_view rest) {
        const auto pieces = split(rest, ',');
        if (pieces[0].empty())
            error("the address is missing, for example " + std::string{kind.name} + ":" + std::string{kind.example});
        else set(kind.address, pieces[0]);
        for (const std::string_view piece : std::span{pieces}.subspan(1)) {
            const std::size_t equals = piece.find('=');
            if (equals == piece.npos) read_alone(piece);
            else set(piece.substr(0, equals), piece.substr(equals + 1));
        }
    }

    void read_alone(std::string_view name) {
        const Key<LinkSettings>* key = keys_.find(name);
        if (name.empty()) error("a comma without a key after it");
        else if (std::string joined = joined_to_last(name); key == nullptr && !joined.empty()) several(name, joined);
        else if (const std::string_view meant = link_.kind->number_means; !meant.empty() && parse_number(name))
            error("unknown key " + in_quotes(name) + " (did you mean '" + std::string{meant} + "=" + std::string{name} + "'?)");
        else if (key != nullptr && !row_of(key->form).may_be_alone)
            error(in_quotes(name) + " needs a value: " + std::string{name} + "=" + placeholder(*key));
        else set(name, "true");
    }

    void several(std::string_view value, const std::string& joined) {
        error("unknown key " + in_quotes(value) + ": join several values of " + in_quotes(last_name_) + " with +: " + joined);
        last_value_.append("+").append(value);
    }

    /// "allow=A+B", if `value` is valid as a further value of the last key; else empty.
    std::string joined_to_last(std::string_view value) const {
        const Key<LinkSettings>* key = last_name_.empty() ? nullptr : keys_.find(last_name_);
        if (key == nullptr || !row_of(key->form).is_joined) return {};
        const std::string all = last_value_ + "+" + std::string{value};
        LinkSettings trial = link_;
        return key->set(all, trial).empty() ? std::string{last_name_} + "=" + printable(all) : std::string{};
    }

    void set(std::string_view name, std::string_view value) {
        last_name_ = name;
        last_value_ = value;
        if (name.starts_with(one_limit)) return set_limit(name, value);
        const Key<LinkSettings>* key = keys_.find(name);
        if (key == nullptr) return error(keys_.unknown(name));
        if (key->form == Form::limits) return error("write " + std::string{one_limit} + "0x01=50: " + std::string{key->help});
        if (std::find(given_.begin(), given_.end(), name) != given_.end()) return error(in_quotes(name) + " is given twice");
        given_.push_back(name);
        if (std::string wrong = key->set(value, link_); !wrong.empty()) error(std::move(wrong));
    }

    void set_limit(std::string_view name, std::string_view value) {
        const std::string_view message = name.substr(one_limit.size());
        const Key<LinkSettings>* key = keys_.find("limit");
        if (std::string wrong = key->set_limit(message, value, link_); !wrong.empty()) error(std::move(wrong));
    }

    static constexpr std::string_view one_limit = "limit.";
    std::string where_;
    Draft& draft_;
    LinkSettings link_;
    KeyList<LinkSettings> keys_;
    std::vector<std::string_view> given_;
    std::string_view last_name_;
    std::string last_value_;
};

}    // namespace

std::string unknown_kind(LinkKinds kinds, std::string_view kind) {
    std::vector<std::string_view> names;
    std::string listed;
    for (const LinkKind* row : kinds) {
        names.push_back(row->name);
        listed += (listed.empty() ? "" : ", ") + std::string{row->name};
    }
    return "unknown kind " + in_quotes(kind) + ano::did_you_mean(kind, names) + "; the kinds are " + listed;
}

void read_link(std::string_view text, const std::string& where, Draft& draft) {
    constexpr std::size_t max_shown = 900;    // bytes; every error contains the text
    const std::string link = "LINK '" + (text.size() <= max_shown ? std::string{text} : printable(std::string{text}, max_shown)) +
                             "'";
    LinkText{where.empty() ? link : where + ": " + link, draft}.read(text);
}

void read_route(std::string_view text, const std::string& where, Draft& draft) {
    const std::size_t equals = text.find('=');
    if (equals == text.npos) {
        draft.errors.push_back({where, "must be ADDR=LINK such as 0xDC=fc"});
        return;
    }
    if (const std::size_t comma = text.find(',', equals); comma != text.npos && text.find('=', comma) != text.npos) {
        draft.errors.push_back({where, "must be one ADDR=LINK; repeat --route for more"});
        return;
    }
    const std::size_t before = draft.errors.size();
    RouteSettings route;
    for (const auto& [name, value] : {std::pair{"address", text.substr(0, equals)}, {"link", text.substr(equals + 1)}})
        if (std::string wrong = find_key(route_keys(), name)->set(value, route); !wrong.empty())
            draft.errors.push_back({where, std::move(wrong)});
    if (draft.errors.size() == before) draft.add(std::move(route), {where});
}

}    // namespace anogate
