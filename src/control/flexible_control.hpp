// The layouts of flexible messages that clients set while the gateway runs. They take precedence over the configuration file until its
// layouts are changed, also after a restart.
#pragma once
#include <ano/flexible.hpp>
#include <http/response.hpp>
#include <http/routes.hpp>
#include <sys/errand.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class Gateway;

/// Layouts, and those of the configuration file when they were set.
struct KeptFlexible {
    std::vector<ano::FlexibleSpec> flexible, of_file;

    /// As JSON, for a file.
    std::string text() const;
    /// std::nullopt: `text` was not made by text().
    static std::optional<KeptFlexible> parse(std::string_view text);
};

/// flexible.json in $STATE_DIRECTORY of the unit; else one for each configuration file, as kept_parameters_path().
std::string kept_flexible_path(const std::string& config_file);
/// Reads a disk, and may block. A file that can't be read is logged, and ignored.
std::optional<KeptFlexible> kept_flexible(const std::string& path);

class FlexibleControl {
public:
    /// `path`: kept_flexible_path(), the file with `kept`. The gateway outlives this object.
    FlexibleControl(Gateway& gateway, std::string path, std::optional<KeptFlexible> kept);
    ~FlexibleControl() { stop(); }
    FlexibleControl(const FlexibleControl&) = delete;
    FlexibleControl& operator=(const FlexibleControl&) = delete;

    /// `call` is called before layouts are replaced: what decodes the frames that passed until now must have them.
    void before_change(std::function<void()> call) { before_change_ = std::move(call); }
    /// Adds GET and PUT /flexible.
    void add_routes(http::Routes& routes);
    /// Answers no more.
    void stop();

private:
    using Say = std::function<void(http::Response)>;
    http::Response set(const http::Request& request);
    void keep(Say say);
    void write();

    Gateway& gateway_;
    std::string path_;
    std::function<void()> before_change_ = [] {};
    Errand errand_;
    std::vector<Say> waiting_;    // until the file has the layouts of now
};

}    // namespace anogate
