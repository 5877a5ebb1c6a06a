// Decides which requests from the broker are executed, each at most once, and what is published as their response. No I/O, no clock.
#pragma once
#include <mqtt/allowed_requests.hpp>
#include <mqtt/topics.hpp>

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace anogate {

/// A message on `request/CLIENT`.
struct RequestMessage {
    std::string topic, payload, correlation, response_topic;
    bool is_retained = false;
    std::optional<std::uint32_t> expiry_s{};    // what the broker left of it
    std::uint64_t received_ns = 0;              // by the boot-time clock of this computer, as all times here
};

struct Response {
    std::string topic, correlation, payload;
};

/// To be executed; its end is reported by finish().
struct AdmittedRequest {
    std::string key;    // identifies it
    std::string method, target, body;
    std::uint64_t until_ns = 0;    // not to be started later
};

class RequestAdmission {
public:
    static constexpr std::uint64_t default_expiry_ns = 10'000'000'000, kept_ns = 3600'000'000'000;
    static constexpr std::size_t max_keys = 1024;

    RequestAdmission(Topics topics, std::vector<std::string> allow) : topics_{std::move(topics)}, allowed_{std::move(allow)} {}

    /// A request of an earlier run, which is not executed again. `response` empty: its outcome is not known.
    void restore(const std::string& key, std::string response, std::uint64_t now_ns);
    /// std::monostate: the request runs already, or has no place for a response.
    using Decision = std::variant<std::monostate, AdmittedRequest, Response>;
    Decision admit(const RequestMessage& message, std::uint64_t now_ns);
    /// `status`: of HTTP; 0: there was no response, `body` is the reason.
    Response finish(const std::string& key, unsigned status, std::string_view body);
    /// Whether `key` is stored for a later run of the program: that of a request which changes something.
    static bool is_kept(std::string_view key) noexcept { return key.find("//") == key.npos; }
    /// It waited until `until_ns` and was not started.
    Response expire(const std::string& key);

private:
    struct Draft;
    struct Known {
        bool is_running = true;
        std::string topic, correlation, payload;
        std::uint64_t since_ns = 0;
    };
    Decision refuse(const RequestMessage& message, std::string_view client, unsigned status, std::string_view why,
                    std::string_view key = {}) const;
    Decision repeat(const RequestMessage& message, std::string_view client, Known& known);
    std::string response_topic(const RequestMessage& message, std::string_view client) const;
    bool make_room(std::uint64_t now_ns);

    Topics topics_;
    AllowedRequests allowed_;
    std::map<std::string, Known, std::less<>> known_;    // by client and key
    std::deque<std::string> order_;                      // of known_, the oldest first
    std::uint64_t unnamed_ = 0;                          // reading requests without a key
};

}    // namespace anogate
