// The keys for the rules of a link; the tunnel is a link as well.
#pragma once
#include <config/frame_words.hpp>
#include <config/key_rows.hpp>

namespace anogate::key_rows {

template <class Section, RuleSettings Section::*rules>
Value limits_in(const KeyFacts&, const Section& section) {
    return (section.*rules).limit;
}

/// Adds to the limits set so far.
template <class Section, RuleSettings Section::*rules>
std::string add_limits(const KeyFacts&, Value value, Section& section) {
    std::vector<LimitRule> limit = (section.*rules).limit;
    for (const LimitRule& rule : std::get<std::vector<LimitRule>>(value))
        if (std::string wrong = add_limit(rule, limit); !wrong.empty()) return wrong;
    (section.*rules).limit = std::move(limit);
    return {};
}

inline constexpr std::size_t rule_rows = 13;
template <class Section, RuleSettings Section::*rules>
constexpr std::array<Key<Section>, rule_rows> rules_of() {
    using Rule = RuleSettings;
    using F = FilterSettings;
    return {frames<rules, &Rule::receive, &F::allow>("receive.allow", "accept only these received frames"),
            frames<rules, &Rule::receive, &F::deny>("receive.deny", "refuse these received frames"),
            senders<rules, &Rule::receive, &F::allow_sources>("receive.allow_sources", "only from these addresses"),
            senders<rules, &Rule::receive, &F::deny_sources>("receive.deny_sources", "not from these addresses"),
            senders<rules, &Rule::receive, &F::allow_destinations>("receive.allow_destinations", "only to these addresses"),
            senders<rules, &Rule::receive, &F::deny_destinations>("receive.deny_destinations", "not to these addresses"),
            frames<rules, &Rule::send, &F::allow>("send.allow", "send only these frames"),
            frames<rules, &Rule::send, &F::deny>("send.deny", "don't send these frames"),
            senders<rules, &Rule::send, &F::allow_sources>("send.allow_sources", "only from these addresses"),
            senders<rules, &Rule::send, &F::deny_sources>("send.deny_sources", "not from these addresses"),
            senders<rules, &Rule::send, &F::allow_destinations>("send.allow_destinations", "only to these addresses"),
            senders<rules, &Rule::send, &F::deny_destinations>("send.deny_destinations", "not to these addresses"),
            Key<Section>{{.name = "limit",
                          .form = Form::limits,
                          .help = "maximum frames per second, evenly spaced, of an id or message: limit.0x01=50"},
                         limits_in<Section, rules>,
                         add_limits<Section, rules>}};
}

template <class Section, std::size_t N, std::size_t M>
constexpr std::array<Key<Section>, N + M> operator+(const Key<Section> (&a)[N], const std::array<Key<Section>, M>& b) {
    std::array<Key<Section>, N + M> all;
    std::copy(std::begin(a), std::end(a), all.begin());
    std::copy(b.begin(), b.end(), all.begin() + N);
    return all;
}

}    // namespace anogate::key_rows
