#include <config/values.hpp>
#include <log/log_line.hpp>
#include <runtime/gateway.hpp>
#include <runtime/reload.hpp>
#include <sys/lazy_memory.hpp>
#include <sys/notify.hpp>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <utility>

namespace anogate {
namespace {

void log_difference(const Difference& difference, std::string_view why = "reload") {
    for (const LinkDifference& link : difference.links) {
        if (link.change == Change::same) continue;
        std::string what;
        for (const std::string& line : link.differences) what += (what.empty() ? ": " : ", ") + line;
        log_info("{}: {} {}{}", why, link.name, text(link.change), what);
    }
    for (const std::string& line : difference.gateway) log_info("{}: {}", why, line);
    for (const std::string& line : difference.needs_restart) log_warning("{}: takes effect at the next start: {}", why, line);
}

void log_outcome(const ReloadOutcome& outcome) {
    if (!outcome.refusal.empty()) return log_error("reload: nothing was changed: {}", outcome.refusal);
    if (!outcome.faults.empty()) log_error("reload: nothing was changed, the configuration has errors:");
    for (const ConfigError& fault : outcome.faults) log_error("reload: {}", line_of(fault));
    if (!outcome.faults.empty() || outcome.dry_run) return;
    if (outcome.difference.is_none() && outcome.files.empty() && outcome.listener_fault.empty()) log_info("reload: no changes");
    for (const std::string& file : outcome.files) log_info("reload: read again: {}", file);
    log_difference(outcome.difference);
    if (outcome.confirm_within)
        log_warning("reload: the previous configuration is restored in {} unless this one is confirmed",
                    duration_text(*outcome.confirm_within));
}

std::vector<std::string> names_of_changed(const Difference& difference) {
    std::vector<std::string> names;
    for (const LinkDifference& link : difference.links)
        if (link.change != Change::same) names.push_back(link.name);
    return names;
}

constexpr const char* no_memory = "not enough memory";
constexpr std::size_t memory_of_any = 1024 * 1024;    // bytes, to read the files and compare them

/// At least as much as a change takes, most of it for the stack of a thread that a new link may have. Many links take less than the most.
std::size_t memory_for(const Difference& difference) {
    constexpr std::size_t of_one = 8 * memory_of_any, most = 64 * memory_of_any;
    const auto fresh = std::count_if(difference.links.begin(), difference.links.end(), [](const LinkDifference& link) {
        return link.change == Change::added || link.change == Change::changed;
    });
    return std::min(most, memory_of_any + of_one * static_cast<std::size_t>(fresh));
}

}    // namespace

/// The input of the thread, and its results.
struct Reload::Job {
    ReloadRequest request;
    ReadAgain read_again;
    Settings running;
    ReadConfig confirmed;
    std::string kept_path;
    WrittenValues written;

    ReadConfig wanted{};
    Settings applied{};    // includes the values that hosts wrote
    ReloadOutcome outcome{};

    void work();
    bool prepare_restart();
};

void Reload::Job::work() {
    outcome.dry_run = request.dry_run;
    auto read = read_again();
    if (auto* faults = std::get_if<ConfigErrors>(&read)) {
        outcome.faults = std::move(*faults);
        return;
    }
    wanted = std::get<ReadConfig>(std::move(read));
    applied = written.applied(wanted.settings);
    outcome.difference = difference(running, applied);
    applied = without_restart(running, std::move(applied));
    wanted.settings = without_restart(running, std::move(wanted.settings));
    if (request.confirm_within && !difference(confirmed.settings, wanted.settings).is_none())
        outcome.confirm_within = request.confirm_within;
    if (!memory_is_left(memory_for(outcome.difference))) outcome.refusal = no_memory;
    else if (!request.dry_run) prepare_restart();
}

// Runs before any change, because the power may fail.
bool Reload::Job::prepare_restart() {
    std::string fault;
    if (!outcome.confirm_within) fault = forget_config(kept_path);
    else fault = keep_config(kept_path, {wanted.files, confirmed.files});
    if (!fault.empty()) outcome.refusal = "cannot save the configuration for the next start: " + fault;
    return fault.empty();
}

Reload::Reload(asio::io_context& io, Gateway& gateway, ReadConfig running, ReadAgain read_again, std::string kept_path,
               WrittenValues written)
    : gateway_{gateway},
      confirmed_{std::move(running)},
      read_again_{std::move(read_again)},
      kept_path_{std::move(kept_path)},
      background_task_{io},
      confirm_by_{io,
                  [this] {
                      if (may_still_be_confirmed()) return;
                      confirm_by_.stop();
                      enqueue_first([this] { roll_back(); });
                  }},
      written_{std::move(written)} {}

void Reload::reload(const ReloadRequest& request, Done done) {
    enqueue([this, request, done = std::move(done)] { begin(request, done); });
}

void Reload::reload_soon() {
    if (std::exchange(soon_, true)) return;
    enqueue([this] {
        soon_ = false;
        begin({}, [](const ReloadOutcome&) {});
    });
}

void Reload::confirm(std::function<void(std::string)> done) {
    enqueue_first([this, done = std::move(done)] { begin_confirm(done); });
}

void Reload::stop() {
    stopped_ = true;
    first_.clear();
    tasks_.clear();
    confirm_by_.stop();
    background_task_.stop();
}

void Reload::enqueue(Task task) { enqueue(tasks_, std::move(task)); }

void Reload::enqueue_first(Task task) { enqueue(first_, std::move(task)); }

void Reload::enqueue(std::deque<Task>& tasks, Task task) {
    if (stopped_) return;
    tasks.push_back(std::move(task));
    if (!busy_) next();
}

void Reload::next() {
    std::deque<Task>& tasks = first_.empty() ? tasks_ : first_;
    busy_ = !tasks.empty();
    if (!busy_) return;
    const Task task = std::move(tasks.front());
    tasks.pop_front();
    task();
}

void Reload::begin(const ReloadRequest& request, const Done& done) {
    if (!memory_is_left(memory_of_any)) {
        ReloadOutcome outcome;
        outcome.dry_run = request.dry_run;
        outcome.refusal = no_memory;
        return finish(outcome, done);
    }
    const auto job = std::make_shared<Job>(Job{request, read_again_, gateway_.settings(), confirmed_, kept_path_, written_});
    if (!request.dry_run) {
        const auto now = std::chrono::duration_cast<std::chrono::microseconds>(ano::Clock::now().time_since_epoch());
        notify_systemd("RELOADING=1\nMONOTONIC_USEC=" + std::to_string(now.count()));
    }
    const bool goes = background_task_.run([job] { job->work(); },
                                           [this, job, done](std::string fault) {
                                               if (!fault.empty()) job->outcome.refusal = std::move(fault);
                                               carry_out(job, done);
                                           });
    if (goes) return;
    job->outcome.dry_run = request.dry_run;
    job->outcome.refusal = std::string{background_task_.why_not()} + " to read the files";
    finish(job->outcome, done);
}

void Reload::carry_out(const std::shared_ptr<Job>& job, const Done& done) {
    const ReloadOutcome& outcome = job->outcome;
    if (!outcome.faults.empty() || !outcome.refusal.empty()) return finish(outcome, done);
    if (outcome.dry_run) return reread(job, done);
    change_gateway(job->applied, outcome.difference, [this, job, done] { changed(job, done); });
}

void Reload::change_gateway(const Settings& settings, const Difference& difference, std::function<void()> done) {
    if (difference.is_none()) return done();
    gateway_.change(settings, difference, patience, [this, names = names_of_changed(difference), done = std::move(done)] {
        set_log_level(gateway_.settings().log.level);
        if (on_links_changed_) on_links_changed_(names);
        done();
    });
}

void Reload::changed(const std::shared_ptr<Job>& job, const Done& done) {
    const ReloadOutcome& outcome = job->outcome;
    ConfigState state = gateway_.config_state();
    state.needs_restart = outcome.difference.needs_restart;
    confirm_by_.stop();
    if (outcome.confirm_within) {
        unconfirmed_ = std::move(job->wanted);
        state.runs = ConfigState::Runs::unconfirmed;
        state.confirm_by = ano::Clock::now() + *outcome.confirm_within;
        confirm_by_.start(*outcome.confirm_within);
    } else {
        confirmed_ = std::move(job->wanted);
        unconfirmed_.reset();
        state.runs = ConfigState::Runs::file;
        state.confirm_by.reset();
        forget_stale();
        gateway_.layouts().settle();
    }
    gateway_.set_config_state(std::move(state));
    settle();
    reread(job, done);
}

void Reload::reread(const std::shared_ptr<Job>& job, const Done& done) {
    if (!on_reloaded_) return finish(job->outcome, done);
    on_reloaded_(job->outcome.dry_run, [this, job, done](std::string fault, std::vector<std::string> changed) {
        job->outcome.listener_fault = std::move(fault);
        job->outcome.files = std::move(changed);
        finish(job->outcome, done);
    });
}

void Reload::finish(const ReloadOutcome& outcome, const Done& done) {
    log_outcome(outcome);
    if (!outcome.dry_run) notify_systemd("READY=1");
    done(outcome);
    next();
}

// Removes the kept configuration first: the new one is confirmed only when that has succeeded.
void Reload::begin_confirm(const std::function<void(std::string)>& done) {
    const auto refuse = [this, &done](std::string why) {
        done(std::move(why));
        next();
    };
    if (!unconfirmed_) return refuse("no configuration is waiting for confirmation");
    const auto why = std::make_shared<std::string>();
    const auto confirmed = [this, done, why](std::string fault) {
        if (fault.empty()) fault = *why;
        if (fault.empty()) {
            confirm_by_.stop();
            confirmed_ = *std::exchange(unconfirmed_, std::nullopt);
            ConfigState state = gateway_.config_state();
            state.runs = ConfigState::Runs::file;
            state.confirm_by.reset();
            gateway_.set_config_state(std::move(state));
            log_info("reload: confirmed");
            forget_stale();
            gateway_.layouts().settle();
            settle();
        }
        done(std::move(fault));
        next();
    };
    if (!background_task_.run([why, path = kept_path_] { *why = forget_config(path); }, confirmed))
        refuse(std::string{background_task_.why_not()});
}

// The deadline may have been extended after its timer expired, but before roll_back() was called.
bool Reload::may_still_be_confirmed() const {
    const auto& by = gateway_.config_state().confirm_by;
    return by && ano::Clock::now() < *by;
}

void Reload::roll_back() {
    if (!unconfirmed_ || may_still_be_confirmed()) return next();
    unconfirmed_.reset();
    log_warning("reload: not confirmed in time; the previous configuration is restored, the file is unchanged");
    const Settings before = without_restart(gateway_.settings(), written_.applied(confirmed_.settings));
    const Difference back = difference(gateway_.settings(), before);
    change_gateway(before, back, [this, back] { rolled_back(back); });
}

void Reload::rolled_back(const Difference& difference) {
    log_difference(difference);
    gateway_.layouts().restore();
    ConfigState state = gateway_.config_state();
    state.runs = ConfigState::Runs::not_the_file;
    state.confirm_by.reset();
    state.needs_restart.clear();
    gateway_.set_config_state(std::move(state));
    settle();
    next();
}

void Reload::write(WrittenValues written) {
    written_ = std::move(written);
    if (std::exchange(applies_, true)) return;
    enqueue([this] {
        applies_ = false;
        apply_written();
    });
}

// Compares in a thread, because comparing large configurations takes long.
void Reload::apply_written() {
    struct Comparison {
        Settings running, wanted;
        Difference difference{};
    };
    const auto both = std::make_shared<Comparison>(
        Comparison{gateway_.settings(), without_restart(gateway_.settings(), written_.applied(of_files()))});
    const auto compare = [both] { both->difference = difference(both->running, both->wanted); };
    const auto carry_out = [this, both](const std::string&) {
        change_gateway(both->wanted, both->difference, [this, both] {
            log_difference(both->difference, "parameters");
            settle();
            next();
        });
    };
    if (background_task_.run(compare, carry_out)) return;
    compare();
    carry_out({});
}

void Reload::restart(const std::string& link) {
    if (!restarts_.insert(link).second) return;
    enqueue([this, link] {
        restarts_.erase(link);
        const auto& links = gateway_.settings().links;
        if (std::none_of(links.begin(), links.end(), [&](const LinkSettings& l) { return l.name == link; })) return next();
        Difference again;
        again.links.push_back({link, Change::changed, {"restarted"}});
        change_gateway(Settings{gateway_.settings()}, again, [this, again] {
            log_difference(again, "restart");
            next();
        });
    });
}

// If a key was changed in the file after a host wrote its value, the file takes precedence.
void Reload::forget_stale() {
    for (const std::string& key : written_.forget_stale(confirmed_.settings))
        log_info("discarded the stored gateway parameter {}: the configuration changed after it was written", key);
}

void Reload::settle() {
    if (on_settled_) on_settled_();
}

}    // namespace anogate
