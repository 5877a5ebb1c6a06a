#include <gateway/peers/listener_check.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

using namespace std::chrono_literals;

constexpr Duration between_questions_back = 1s;

// The minimum time from the last of `asks` questions to the next.
Duration pause_after(std::uint32_t asks) { return asks == 1 ? 1s : asks == 2 ? 3s : 60s; }

}    // namespace

std::optional<ListeningNotice> ListenerCheck::question(const Endpoint& suspect, TimePoint now) {
    Suspect& s = row(suspect, now);
    if (s.asks > 0 && now - s.asked_at < pause_after(s.asks)) return std::nullopt;
    return ask(s, now);
}

std::optional<ListeningNotice> ListenerCheck::question_back(const Endpoint& there, TimePoint now) {
    if (!find(there) && !may_ask_stranger(now)) return std::nullopt;
    Suspect& s = row(there, now);
    if (s.asks > 0 && now - s.asked_at < between_questions_back) return std::nullopt;
    if (s.refused && ++s.unanswered > unanswered_enough) {
        s = {};
        return std::nullopt;
    }
    return ask(s, now);
}

bool ListenerCheck::may_ask_stranger(TimePoint now) noexcept {
    if (now - asked_since_ >= 1s) {
        asked_since_ = now;
        asked_strangers_ = 0;
    }
    return asked_strangers_++ < max_strangers_a_second;
}

ListeningNotice ListenerCheck::ask(Suspect& s, TimePoint now) {
    while (s.number == 0) s.number = random_();
    ++s.asks;
    s.asked_at = now;
    return {ListeningNotice::Kind::question, s.number};
}

std::optional<ListeningNotice> ListenerCheck::asked(const Endpoint& from, std::uint64_t number, TimePoint now) {
    if (const Suspect* s = find(from); s && s->number != 0 && s->number == number)
        return std::nullopt;    // our own question, returned by the peer
    suspend(from, now);
    return ListeningNotice{ListeningNotice::Kind::answer, number};
}

bool ListenerCheck::answered(const Endpoint& from, std::uint64_t number, TimePoint now) {
    Suspect* s = find(from);
    if (!s || s->number == 0 || s->number != number) return false;
    s->seen_at = now;
    s->refused = true;
    s->unanswered = 0;
    s->number = 0;    // each number counts once
    return true;
}

void ListenerCheck::suspend(const Endpoint& endpoint, TimePoint now) noexcept {
    Suspension* free = nullptr;
    for (Suspension& s : suspensions_) {
        const bool is_over = s.endpoint.port == 0 || now - s.at >= between_suspensions;
        if (s.endpoint == endpoint && !is_over) return;
        if (is_over && (!free || s.endpoint == endpoint)) free = &s;
    }
    if (free) *free = {endpoint, now};
}

TimePoint ListenerCheck::suspended_until(const Endpoint& endpoint, TimePoint now) const noexcept {
    for (const Suspension& s : suspensions_)
        if (s.endpoint == endpoint && s.endpoint.port != 0 && now - s.at < suspended_for) return s.at + suspended_for;
    return now;
}

bool ListenerCheck::is_refused(const Endpoint& endpoint) const noexcept {
    const Suspect* s = find(endpoint);
    return s && s->refused;
}

void ListenerCheck::forget(const Endpoint& endpoint) noexcept {
    if (Suspect* s = find(endpoint); s && !s->refused) *s = {};
}

const ListenerCheck::Suspect* ListenerCheck::find(const Endpoint& endpoint) const noexcept {
    const auto found = std::find_if(suspects_.begin(), suspects_.end(), [&](const Suspect& s) { return s.endpoint == endpoint; });
    return found == suspects_.end() || endpoint.port == 0 ? nullptr : &*found;
}

ListenerCheck::Suspect* ListenerCheck::find(const Endpoint& endpoint) noexcept {
    return const_cast<Suspect*>(std::as_const(*this).find(endpoint));
}

// If all rows are used, the one seen longest ago is reused, preferably one that is not refused.
ListenerCheck::Suspect& ListenerCheck::row(const Endpoint& endpoint, TimePoint now) noexcept {
    Suspect* s = find(endpoint);
    if (!s) {
        s = &*std::min_element(suspects_.begin(), suspects_.end(), [](const Suspect& a, const Suspect& b) {
            return a.refused != b.refused ? b.refused : a.seen_at < b.seen_at;
        });
        *s = {};
        s->endpoint = endpoint;
    }
    s->seen_at = now;
    return *s;
}

}    // namespace anogate
