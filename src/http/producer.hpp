// An answer that is produced while it is sent.
#pragma once
#include <functional>
#include <string>

namespace anogate::http {

/// Called for the next part when the client can take it, so that only one part is in memory however slow the client is. Destroyed when
/// everything is sent, when the client is gone or takes nothing for too long, and when the server stops.
class Producer {
public:
    enum class Next {
        part,     // the next part may be ready at once. Empty: it takes more turns of the loop to make one
        later,    // no more until `wake` is called; may come with a part
        end,      // no more at all; may come with a part
    };
    virtual ~Producer() = default;

    /// Called before the first next(). `wake` is cheap and may be called at any time, even after the producer is destroyed.
    virtual void start(std::function<void()> /*wake*/) {}    // NOLINT(performance-unnecessary-value-param): who keeps it moves it
    /// Writes the next part to the empty `into`. A part should have about 16 KB, since each turn of the loop sends one,
    /// and should be made within about a millisecond.
    virtual Next next(std::string& into) = 0;
};

}    // namespace anogate::http
