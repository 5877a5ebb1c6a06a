#include <ano/conversation.hpp>
#include <device/reply.hpp>

#include <algorithm>
#include <span>

namespace ano::device {

// The message table defines which ids may be acknowledged.
Outcome Reply::acknowledge() noexcept {
    if (!may_be_acknowledged(request_.id())) return Outcome::unanswered;
    const Checks checks = request_.checks();
    Draft<"check"> check;
    const bool fits = check.set<"id_get">(request_.id()) && check.set<"sc_get">(checks.sum) && check.set<"ac_get">(checks.add);
    return fits ? send(check) : Outcome::unanswered;    // a byte always fits
}

std::size_t Reply::lengthen(std::uint8_t* frame, std::size_t size, std::size_t zeros) noexcept {
    if (zeros == 0 || size == 0 || size + zeros > Outgoing::room) return size;
    const std::span whole{frame, size + zeros};
    write_header(whole, frame[1], frame[2], frame[3], whole.size() - overhead);
    std::fill_n(frame + size - 2, zeros, std::uint8_t{0});    // overwrites the old checks
    seal(whole);
    return whole.size();
}

}    // namespace ano::device
