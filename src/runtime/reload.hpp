// Reloads the configuration while the gateway runs, and restores the previous one if the new one is not confirmed in time.
#pragma once
#include <config/config_error.hpp>
#include <config/difference.hpp>
#include <gateway/settings.hpp>
#include <managed/managed_parameters.hpp>
#include <runtime/kept_config.hpp>
#include <sys/background_task.hpp>
#include <sys/ticker.hpp>

#include <deque>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>

namespace anogate {

class Gateway;

/// The present content of the configuration files and the command line.
struct ReadConfig {
    Settings settings;
    std::vector<ConfigText> files;
};
/// Reads all of it. Called in a thread, where it may block.
using ReadAgain = std::function<std::variant<ReadConfig, ConfigErrors>()>;

struct ReloadRequest {
    bool dry_run = false;
    std::optional<ano::Duration> confirm_within{};    // std::nullopt: no confirmation is needed
};

struct ReloadOutcome {
    ConfigErrors faults{};    // in the configuration; with faults or a refusal, nothing was changed
    std::string refusal{};    // another reason why nothing was changed; empty: none
    Difference difference{};
    bool dry_run = false;
    std::optional<ano::Duration> confirm_within{};    // std::nullopt: no confirmation is needed
    std::string listener_fault{};        // why control.http is off: a fault of its tokens or certificate; empty: it is on
    std::vector<std::string> files{};    // its files whose content has changed
};

/// Requests are processed one after the other, in order. A confirmation and the expiry of its time are processed before waiting
/// requests. The files are read, checked and compared in a thread; the gateway is changed in the loop.
class Reload {
public:
    /// `running`: the last confirmed configuration; `written`: the values that hosts wrote in addition. The gateway was created
    /// from both. `kept_path`: kept_config_path(). The gateway must outlive this object.
    Reload(asio::io_context& io, Gateway& gateway, ReadConfig running, ReadAgain read_again, std::string kept_path,
           WrittenValues written = {});

    /// How long a link that is removed may still send its waiting frames.
    static constexpr ano::Duration patience = std::chrono::milliseconds{300};

    using Done = std::function<void(const ReloadOutcome&)>;
    void reload(const ReloadRequest& request, Done done);
    /// The same for SIGHUP: further calls before the reload begins have no effect.
    void reload_soon();
    /// Confirms the running configuration. `done` receives empty, or the reason why it was not confirmed.
    void confirm(std::function<void(std::string refusal)> done);
    /// The values that hosts wrote as parameters of the gateway: they take effect like a reload, and are applied again after each reload.
    void write(WrittenValues written);
    /// Closes the link and creates it again. Further calls before the restart begins have no effect.
    void restart(const std::string& link);
    /// The part of the running settings that is from the files, and the values that were written in addition.
    const Settings& of_files() const noexcept { return unconfirmed_ ? unconfirmed_->settings : confirmed_.settings; }
    const WrittenValues& written() const noexcept { return written_; }
    /// `call` is called when the running configuration or its source may have changed.
    void on_settled(std::function<void()> call) { on_settled_ = std::move(call); }
    using Reread = std::function<void(std::string fault, std::vector<std::string> changed)>;
    /// `call` is called after each change by a reload, to read other files again, and in a dry run, where it only compares them.
    /// It must call `done` with their fault, or empty, and those whose content has changed.
    void on_reloaded(std::function<void(bool dry_run, Reread done)> call) { on_reloaded_ = std::move(call); }
    /// `call` receives the names of links that were changed, added or removed.
    void on_links_changed(std::function<void(const std::vector<std::string>&)> call) { on_links_changed_ = std::move(call); }
    /// Stops processing and answering requests.
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
    void reread(const std::shared_ptr<Job>& job, const Done& done);
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
    BackgroundTask background_task_;
    Ticker confirm_by_;
    std::deque<Task> first_, tasks_;
    std::function<void(const std::vector<std::string>&)> on_links_changed_;
    std::function<void()> on_settled_;
    std::function<void(bool, Reread)> on_reloaded_;
    WrittenValues written_;
    std::optional<ReadConfig> unconfirmed_;    // the running configuration while it is not confirmed
    bool busy_ = false;
    bool soon_ = false;                 // a reload_soon() is waiting to begin
    bool applies_ = false;              // a write() is waiting to begin
    std::set<std::string> restarts_;    // links whose restart is waiting to begin
    bool stopped_ = false;
};

}    // namespace anogate
