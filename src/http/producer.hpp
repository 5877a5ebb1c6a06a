// A response body that is produced while it is sent.
#pragma once
#include <functional>
#include <string>

namespace anogate::http {

/// Called for the next part when the client can receive it, so that only one part is in memory however slow the client is.
/// Destroyed when everything is sent, when the client is gone or accepts nothing for SessionLimits::patience, and when the server
/// stops.
class Producer {
public:
    enum class Next {
        part,     // the next part may be ready at once. If this one is empty, making it takes more turns of the loop
        later,    // no more until `wake` is called; a part may be returned with it
        end,      // no more at all; a part may be returned with it
    };
    virtual ~Producer() = default;

    /// Called before the first next(). `wake` is cheap and may be called at any time, even after the producer is destroyed.
    virtual void start(std::function<void()> /*wake*/) {}    // NOLINT(performance-unnecessary-value-param): who keeps it moves it
    /// Writes the next part to the empty `into`. A part should have about 16 KB, since each turn of the loop sends one,
    /// and should be made within about a millisecond.
    virtual Next next(std::string& into) = 0;
};

}    // namespace anogate::http
