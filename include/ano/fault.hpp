// Why something failed or was refused: an id with arguments for programs, and the text for people.
//
// Flow:    Fault fault{"no_parameter", "0xDC", 7};    // a row of `fault_rows`; its arguments in the order of its English text
//          fault.add({"old_values_restored"});        // a further clause
//          fault.text();                              // "0xDC has no parameter 7; the old values are restored"
#pragma once
#include <ano/faults.hpp>

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <functional>
#include <iterator>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace ano {

/// {name}, or {name:one|many}: the first word if the argument is 1, otherwise the second; without the argument itself.
struct Placeholder {
    std::string_view name, one, many;
    std::size_t begin = 0, end = 0;    // of it in the text
};
/// The first placeholder from `at` on; without a name: there is none.
constexpr Placeholder placeholder_in(std::string_view text, std::size_t at) noexcept {
    const std::size_t begin = text.find('{', at), end = text.find('}', at);
    if (begin == text.npos || end == text.npos) return {};
    const std::string_view inside = text.substr(begin + 1, end - begin - 1);
    const std::size_t colon = inside.find(':'), bar = inside.find('|');
    if (colon == text.npos) return {inside, {}, {}, begin, end + 1};
    return {inside.substr(0, colon), inside.substr(colon + 1, bar - colon - 1), inside.substr(bar + 1), begin, end + 1};
}
/// The names of its arguments, in the order of the English text.
struct ArgumentNames {
    static constexpr std::size_t most = 6;
    std::array<std::string_view, most> all{};
    std::size_t number = 0;

    constexpr auto begin() const noexcept { return all.begin(); }
    constexpr auto end() const noexcept { return all.begin() + number; }
    constexpr std::size_t index(std::string_view name) const noexcept {
        return static_cast<std::size_t>(std::find(begin(), end(), name) - begin());
    }
};
constexpr ArgumentNames arguments_of(std::string_view text) {
    ArgumentNames names;
    for (Placeholder next = placeholder_in(text, 0); !next.name.empty(); next = placeholder_in(text, next.end))
        if (names.index(next.name) == names.number) names.all.at(names.number++) = next.name;
    return names;
}

/// The id of a row; the compiler refuses any other.
struct FaultName {
    consteval FaultName(const char* id)
        : row{std::find_if(std::begin(fault_rows), std::end(fault_rows), [id](const FaultRow& one) { return one.id == id; })} {
        if (row == std::end(fault_rows)) throw "no row of `fault_rows` has this id";
    }
    const FaultRow* row;
};
/// The same of a row with this number of arguments.
template <class... Arguments>
struct FaultId : FaultName {
    consteval FaultId(const char* id) : FaultName{id} {
        if (arguments_of(row->english).number != sizeof...(Arguments)) throw "the text has another number of arguments";
    }
};

class Fault {
public:
    /// A text or a number, or a clause with an id of its own.
    struct Argument {
        Argument(std::string its_text) : text{std::move(its_text)} {}
        Argument(std::string_view its_text) : text{its_text} {}
        Argument(const char* its_text) : text{its_text} {}
        Argument(std::integral auto number) : text{std::to_string(number)} {}
        Argument(Fault its_fault);    // a text that is nothing else becomes the text of the argument
        std::string to_string() const { return fault.empty() ? text : fault.front().text(); }

        std::string text{};
        std::vector<Fault> fault{};    // one, instead of the text; or none
    };

    /// There is none.
    Fault() = default;
    template <class... Arguments>
    Fault(FaultId<std::type_identity_t<Arguments>...> id, Arguments... arguments)
        : Fault{*id.row, {Argument{std::move(arguments)}...}} {}
    /// With as many arguments as the text of `row` has.
    Fault(const FaultRow& row, std::vector<Argument> arguments) : row_{&row}, arguments_{std::move(arguments)} {}

    bool empty() const noexcept { return row_ == nullptr; }
    /// Empty without a fault.
    std::string_view id() const noexcept { return row_ != nullptr ? row_->id : std::string_view{}; }
    bool is(FaultName name) const noexcept { return row_ == name.row; }
    /// Of the HTTP response; 0: another rule decides it (FaultRow).
    unsigned status() const noexcept { return row_ != nullptr ? row_->status : 0; }
    /// In English: a clause, and further clauses after "; ".
    std::string text() const;
    /// In the order of arguments_of().
    const std::vector<Argument>& arguments() const noexcept { return arguments_; }
    ArgumentNames names() const { return row_ != nullptr ? arguments_of(row_->english) : ArgumentNames{}; }
    const std::vector<Fault>& remarks() const noexcept { return remarks_; }

    /// Adds a further clause; without a fault so far, `remark` becomes it.
    Fault& add(Fault remark);
    /// The same with `convert` of each text among the arguments.
    Fault converted(const std::function<std::string(std::string_view text)>& convert) const;

private:
    const FaultRow* row_ = nullptr;
    std::vector<Argument> arguments_{};
    std::vector<Fault> remarks_{};
};

}    // namespace ano
