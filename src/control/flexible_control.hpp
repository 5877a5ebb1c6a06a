// The layouts of flexible messages that clients set while the gateway runs. They take precedence over the configuration file,
// also after a restart, until the layouts in the file change.
#pragma once
#include <ano/flexible.hpp>
#include <http/response.hpp>
#include <http/routes.hpp>
#include <runtime/gateway_parts.hpp>
#include <sys/background_task.hpp>

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace anogate {

class Gateway;

/// The set layouts, and those of the configuration file at that time.
struct KeptFlexible {
    std::vector<ano::FlexibleSpec> flexible, of_file;

    /// As JSON, for a file.
    std::string text() const;
    /// std::nullopt: `text` was not made by text().
    static std::optional<KeptFlexible> parse(std::string_view text);
};

/// flexible.json in $STATE_DIRECTORY of the unit; else one for each configuration file, as kept_parameters_path().
std::string kept_flexible_path(const std::string& config_file);
/// Reads the disk and may block. A file that can't be read is logged and ignored.
std::optional<KeptFlexible> kept_flexible(const std::string& path);

class FlexibleControl final : private GatewayEvents {
public:
    /// `path`: kept_flexible_path(), the file with `kept`. The gateway must outlive this object.
    FlexibleControl(Gateway& gateway, std::string path, std::optional<KeptFlexible> kept);
    ~FlexibleControl();
    FlexibleControl(const FlexibleControl&) = delete;
    FlexibleControl& operator=(const FlexibleControl&) = delete;

    /// `call` is called before layouts are replaced: earlier frames must be decoded with the old ones.
    void before_change(std::function<void()> call) { before_change_ = std::move(call); }
    /// Adds GET and PUT /flexible.
    void add_routes(http::Routes& routes);

private:
    void stopping() override;
    void layouts_overruled() override;
    using Respond = std::function<void(http::Response)>;
    http::Response set(const http::Request& request);
    void keep(Respond respond);
    void write();

    Gateway& gateway_;
    std::string path_;
    std::function<void()> before_change_ = [] {};
    BackgroundTask background_task_;
    bool is_stopped_ = false;
    std::vector<Respond> waiting_;    // requests to answer once the file contains the current layouts
};

}    // namespace anogate
