// Reads the configuration again while the gateway runs, and brings the old one back when nobody confirms the new one.
#pragma once
#include <config/config_error.hpp>
#include <config/difference.hpp>
#include <daemon/errand.hpp>
#include <daemon/kept_config.hpp>
#include <daemon/ticker.hpp>
#include <gateway/settings.hpp>
#include <managed/managed_parameters.hpp>

#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace anogate {

class Gateway;

/// What the configuration files and the command line say now.
struct ReadConfig {
    Settings settings;
    std::vector<ConfigText> files;
};
/// Reads them whole. Called in a thread, where it may block.
using ReadAgain = std::function<std::variant<ReadConfig, ConfigErrors>()>;

struct ReloadRequest {
    bool dry_run = false;
    std::optional<ano::Duration> confirm_within{};    // nothing: it holds
};

struct ReloadOutcome {
    ConfigErrors faults{};    // of the configuration; with any, or with a refusal, nothing was changed
    std::string refusal{};    // why, otherwise
    Difference difference{};
    bool dry_run = false;
    std::optional<ano::Duration> confirm_within{};    // nothing: there is nothing to confirm
};

/// What is asked is done in its order, one after the other; that a configuration is confirmed, or not in time, goes first. The
/// files are read, judged and compared in a thread; the gateway is changed in the loop.
class Reload {
public:
    /// `running`: the configuration of the gateway, which is its last confirmed one; `written`: what hosts wrote behind it, the gateway
    /// was made of both. `kept_path`: kept_config_path(). The gateway outlives this.
    Reload(asio::io_context& io, Gateway& gateway, ReadConfig running, ReadAgain read_again, std::string kept_path,
           WrittenValues written = {});

    /// For which frames that wait in a link that goes it is waited so long.
    static constexpr ano::Duration patience = std::chrono::milliseconds{300};

    using Done = std::function<void(const ReloadOutcome&)>;
    void reload(const ReloadRequest& request, Done done);
    /// The same for SIGHUP: those that come while one waits to begin are one.
    void reload_soon();
    /// What runs is to stay. `done`: empty, or why it was not confirmed.
    void confirm(std::function<void(std::string refusal)> done);
    /// What hosts wrote as parameters of the gateway: takes effect as a reload does, and behind each of them.
    void write(WrittenValues written);
    /// The link is closed, and made anew. Once for all who ask while one waits to begin.
    void restart(const std::string& link);
    /// What the files say of what runs, and what was written behind that.
    const Settings& of_files() const noexcept { return unconfirmed_ ? unconfirmed_->settings : confirmed_.settings; }
    const WrittenValues& written() const noexcept { return written_; }
    /// What runs may be something else now, or what it comes from.
    void on_settled(std::function<void()> call) { on_settled_ = std::move(call); }
    /// The names of links that were changed, added or removed.
    void on_links_changed(std::function<void(const std::vector<std::string>&)> call) { on_links_changed_ = std::move(call); }
    /// Nothing is done or answered any more.
    void stop();

private:
    struct Job;
    using Task = std::function<void()>;
    void enqueue(Task task);
    void enqueue_first(Task task);
    void enqueue(std::deque<Task>& tasks, Task task);
    void next();
    void begin(const ReloadRequest& request, const Done& done);
    void carry_out(const std::shared_ptr<Job>& job, const Done& done);
    void changed(const std::shared_ptr<Job>& job, const Done& done);
    void finish(const ReloadOutcome& outcome, const Done& done);
    void begin_confirm(const std::function<void(std::string)>& done);
    bool may_still_be_confirmed() const;
    void roll_back();
    void rolled_back(const Difference& difference);
    void apply_written();
    void settle();
    void forget_stale();
    void change_gateway(const Settings& settings, const Difference& difference, std::function<void()> done);

    Gateway& gateway_;
    ReadConfig confirmed_;
    ReadAgain read_again_;
    std::string kept_path_;
    Errand errand_;
    Ticker confirm_by_;
    std::deque<Task> first_, tasks_;
    std::function<void(const std::vector<std::string>&)> on_links_changed_;
    std::function<void()> on_settled_;
    WrittenValues written_;
    std::optional<ReadConfig> unconfirmed_;    // it runs, and waits to be confirmed
    bool busy_ = false;
    bool soon_ = false;                 // reload_soon() was called, and waits to begin
    bool applies_ = false;              // write() was called, and waits to begin
    std::set<std::string> restarts_;    // links whose restart waits to begin
    bool stopped_ = false;
};

}    // namespace anogate
