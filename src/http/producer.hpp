// An answer that is made while it is sent.
#pragma once
#include <functional>
#include <string>

namespace anogate::http {

/// Asked for the next part when the client can take it: what waits to be sent is one part, however slow the client is. It is destroyed
/// when all was sent, when the client is gone or takes nothing for too long, and when the server stops.
class Producer {
public:
    enum class Next {
        part,     // one that is not empty; there may be more at once
        later,    // no more for now: `wake` says when; a part may come with it
        end,      // that was all; a part may come with it
    };
    virtual ~Producer() = default;

    /// Before the first next(). `wake` does little itself, and may be called at any time, also when the producer is gone.
    virtual void start(std::function<void()> /*wake*/) {}    // NOLINT(performance-unnecessary-value-param): who keeps it moves it
    /// Appends the next part to `into`, which is empty. A part should be some 16 KB: one goes between two turns of the loop.
    virtual Next next(std::string& into) = 0;
};

}    // namespace anogate::http
