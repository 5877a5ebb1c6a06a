#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/text.hpp>
#include <devices/calibration_work.hpp>
#include <devices/device_service.hpp>
#include <http/response.hpp>

#include <algorithm>
#include <bit>
#include <new>
#include <utility>

namespace anogate {
namespace {

using ano::Duration;
using ano::TimePoint;
using ano::host::Deed;
using ano::host::Refusal;

constexpr Duration rate_over = std::chrono::seconds{2};
constexpr Duration until_heard = std::chrono::seconds{2};    // interval of looking whether a device is present

NotBegun not_begun(unsigned status, std::string error) {
    return {status, std::move(error), std::string{http::what_of(status)}, nullptr};
}

std::string words_of_conflict(std::uint8_t address, const std::vector<std::string>& links) {
    const std::string device = ano::hex_byte(address);
    std::string heard;
    for (const std::string& link : links) heard += (heard.empty() ? " (heard by " : " and ") + link;
    return "several devices have the address " + device + heard + (heard.empty() ? "" : ")") +
           ": which of them is meant is not known; when only one is left, anoctl routes --forget " + device;
}

std::string why(Refusal refusal, std::uint8_t address, std::optional<std::uint8_t> writer,
                const std::vector<std::string>& links) {
    const std::string device = ano::hex_byte(address);
    switch (refusal) {
    case Refusal::no_device: return device + " is no address of a device";
    case Refusal::not_known: return device + " was not heard";
    case Refusal::in_conflict: return words_of_conflict(address, links);
    case Refusal::on_several_channels:
        return device + " is heard by several links that are no group: a frame to it would go by all of them";
    case Refusal::in_the_air: return device + " is unlocked or flies: this is for the ground";
    case Refusal::busy: break;
    }
    return "the host " + ano::hex_byte(writer.value_or(0)) + " is writing to " + device + " just now";
}

unsigned status_of(Refusal refusal) {
    if (refusal == Refusal::no_device) return 400;
    return refusal == Refusal::not_known ? 404 : 409;
}

// A frame that changes the device, or makes it do something.
bool is_act(ano::FrameView frame) {
    const auto query = ano::as<"parameter_command">(frame);
    return (query && query->get<"cmd">() == 0x10) || frame.id() == ano::id_of<"parameter_value"> ||
           frame.id() == ano::id_of<"command"> || frame.id() == ano::id_of<"waypoint"> || frame.id() == ano::id_of<"firmware">;
}

// During an upgrade a device answers nothing else.
bool has_it_alone(JobKind kind) { return kind == JobKind::firmware; }

}    // namespace

DeviceService::~DeviceService() {
    if (listens_since_) net_.listen(false);
}

void DeviceService::use(TimePoint now) {
    used_at_ = now;
    if (!listens_since_) {
        listens_since_ = now;
        net_.listen(true);
    }
    net_.wake(now + idle_after);
}

bool DeviceService::hear(ano::FrameView frame, TimePoint now) {
    guard_.hear(frame, now);
    try {
        auto& known = known_[frame.source()];
        if (!known) known = std::make_unique<Known>();
        count(*known, now);
        using ano::host::Taken;
        bool is_news = false, is_answer = false;
        if (const auto said = ano::as<"device_info">(frame)) {
            is_answer = frame.destination() == own_;    // of a scan, which asks all devices
            known->info = {said->get<"dev_id">(), said->get<"hw_ver">(), said->get<"sw_ver">(),
                           said->get<"bl_ver">(), said->get<"pt_ver">(), std::string{said->get<"name">()}};
        }
        const auto is_taken_by = [&](const auto& one) {
            if (!one || !one->device) return false;
            const Taken taken = one->device->take(frame, now);
            is_news = is_news || taken == Taken::ended;
            is_answer = is_answer || taken == Taken::ended || taken == Taken::doubled || taken == Taken::late;
            return taken == Taken::ended;
        };
        // An answer belongs to one question only; one sent to the device's own address goes first.
        const bool is_over = is_taken_by(known);
        for (std::uint32_t ports = asked_ports_; ports != 0 && !is_over; ports &= ports - 1)
            if (const auto port = static_cast<std::uint8_t>(std::countr_zero(ports)); answers_at_port(frame.source(), port))
                is_taken_by(known_[port]);
        for (std::size_t i = 0; at_work_ > 0 && i < jobs_.size(); ++i) {
            const auto& job = jobs_[i];
            if (!job->work) continue;
            const std::uint8_t at = job->order.address.value_or(frame.source());
            if (at == frame.source() || answers_at_port(frame.source(), at)) job->work->hear(frame, now);
        }
        if (is_news) net_.wake(now);
        return is_answer;
    } catch (const std::bad_alloc&) {    // ignores the frame
        return false;
    }
}

bool DeviceService::answers_at_port(std::uint8_t source, std::uint8_t port) {
    return ano::address::is_port_id(port) && source != port && net_.may_answer_for(source, port);
}

void DeviceService::count(Known& known, TimePoint now) {
    known.heard_at = now;
    ++known.frames;
    const Duration passed = now - known.counted_since;
    if (passed < rate_over) return;
    if (passed < 2 * rate_over) known.rate = known.frames / std::chrono::duration<double>(passed).count();
    known.frames = 0;
    known.counted_since = now;
}

ano::host::Device& DeviceService::device(std::uint8_t address) {
    auto& known = known_[address];
    if (!known) known = std::make_unique<Known>();
    if (!known->device) known->device = std::make_unique<ano::host::Device>(address, own_);
    if (ano::address::is_port_id(address)) asked_ports_ |= std::uint32_t{1} << address;
    return *known->device;
}

WorkPlace DeviceService::place(const Job& job) {
    if (job.order.address) {
        const auto refused = [this,
                              order = JobOrder{job.order.kind, job.order.deed, job.order.address, job.order.force, {}, {}}] {
            const auto why = refusal(order, net_.now());
            return why ? why->error : std::string{};
        };
        return {device(*job.order.address), cache_, net_, notes_, refused};
    }
    if (!everybody_) everybody_ = std::make_unique<ano::host::Device>(ano::address::broadcast, own_);
    return {*everybody_, cache_, net_, notes_};
}

std::shared_ptr<Job> DeviceService::holder(std::uint8_t address) const {
    const auto found = std::find_if(jobs_.begin(), jobs_.end(), [&](const auto& job) {
        return !job->is_over() && job->is_writing() && job->order.address &&
               (*job->order.address == address || net_.is_same_device(*job->order.address, address));
    });
    return found != jobs_.end() ? *found : nullptr;
}

// Never a job that began before the device was changed: it may have read old values.
std::shared_ptr<Job> DeviceService::shared(const JobOrder& order) const {
    if (order.shared_as.empty() || !order.address) return nullptr;
    const unsigned from = known_[*order.address] ? known_[*order.address]->acted_before : 0;
    const auto found = std::find_if(jobs_.begin(), jobs_.end(), [&](const auto& job) {
        return !job->is_over() && job->order.address == order.address && job->order.shared_as == order.shared_as &&
               job->id >= from && job->refused.empty() && !job->is_cancelled;
    });
    return found != jobs_.end() ? *found : nullptr;
}

std::optional<NotBegun> DeviceService::refusal(const JobOrder& order, TimePoint now) {
    if (!order.address) return std::nullopt;
    const std::uint8_t address = *order.address;
    const auto where = net_.whereabouts(address, now);
    auto refused = guard_.refusal(order.deed, address, where, now, order.force);
    if (!refused && !where.is_known) refused = Refusal::not_known;
    if (!refused) return std::nullopt;
    NotBegun told = not_begun(status_of(*refused),
                              why(*refused, address, guard_.busy_with(address, now), net_.links_in_conflict(address, now)));
    if (told.status == 409 && *refused != Refusal::busy) told.what = "refused";
    return told;
}

std::size_t DeviceService::running() const {
    return static_cast<std::size_t>(std::count_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return !job->is_over(); }));
}

std::size_t DeviceService::upgrades() const {
    return static_cast<std::size_t>(std::count_if(
        jobs_.begin(), jobs_.end(), [](const auto& job) { return !job->is_over() && job->order.kind == JobKind::firmware; }));
}

// Removes ended jobs that are old, and if needed the oldest ended one. False: all jobs are running.
bool DeviceService::make_room(TimePoint now) {
    const auto is_old = [&](const auto& job) { return job->is_over() && now - job->ended_at >= kept_for; };
    jobs_.erase(std::remove_if(jobs_.begin(), jobs_.end(), is_old), jobs_.end());
    if (jobs_.size() < max_jobs) return true;
    const auto oldest = std::find_if(jobs_.begin(), jobs_.end(), [](const auto& job) { return job->is_over(); });
    if (oldest == jobs_.end()) return false;
    jobs_.erase(oldest);
    return true;
}

std::variant<std::shared_ptr<Job>, NotBegun> DeviceService::begin(JobOrder order, TimePoint now) {
    if (stopped_) return not_begun(503, "the gateway ends");
    use(now);
    if (auto refused = refusal(order, now)) return *std::move(refused);
    if (order.address)
        if (auto has_it = holder(*order.address); has_it && (order.deed != Deed::read || has_it_alone(has_it->order.kind)))
            return NotBegun{409, words_of(*has_it) + " has " + ano::hex_byte(*order.address), "busy", has_it};
    if (auto same = shared(order)) return same;
    if (order.kind == JobKind::firmware && upgrades() >= max_upgrades)
        return not_begun(503, "other devices are upgraded just now: ask again when one has ended");
    if (running() >= max_running || !make_room(now)) return not_begun(503, "too many jobs run: ask again when one has ended");
    auto job = std::make_shared<Job>();
    job->id = next_id_++;
    job->order = std::move(order);
    job->begins_at = now;
    if (job->order.deed == Deed::ground) {
        job->begins_at = std::max(now, *listens_since_ + ano::host::AirGuard::busy_for);
        job->message = "listening whether it flies, or another host writes to it";
    }
    jobs_.push_back(job);
    net_.wake(now);
    return job;
}

bool DeviceService::cancel(Job& job, TimePoint now) {
    if (job.is_over()) return false;
    job.is_cancelled = true;
    if (job.work) job.work->cancel(now);
    else finish(job, {409, {}, "cancelled before it began", "refused", {}, true}, now);
    net_.wake(now);
    return true;
}

void DeviceService::left(Job& job) {
    if (job.needed_by > 0 && --job.needed_by == 0 && !job.goes_on) cancel(job, net_.now());
}

std::optional<NotBegun> DeviceService::go_on(Job& job, TimePoint now) {
    const NotBegun does_not_wait = not_begun(409, "the job does not wait for anybody");
    if (job.is_over() || !job.work || !job.work->is_waiting()) return does_not_wait;
    if (auto refused = refusal(job.order, now)) return refused;    // it may have taken off since the job began
    if (!job.work->go_on(now)) return does_not_wait;
    look(job, now);
    net_.wake(now);
    return std::nullopt;
}

std::shared_ptr<Job> DeviceService::job(unsigned id) const {
    const auto found = std::find_if(jobs_.begin(), jobs_.end(), [&](const auto& job) { return job->id == id; });
    return found != jobs_.end() ? *found : nullptr;
}

void DeviceService::stop(TimePoint now) {
    stopped_ = true;
    const auto all = jobs_;
    for (const auto& job : all)
        if (!job->is_over()) cut_off(*job, now);
    if (std::exchange(listens_since_, std::nullopt)) net_.listen(false);
}

void DeviceService::cut_off(Job& job, TimePoint now) {
    std::string words = "nothing was begun";
    std::string result;
    ano::host::Evidence evidence{};
    if (job.work) {
        if (!job.work->end()) job.work->cancel(now);
        if (!job.work->end()) job.work->run(now);
        if (const auto& end = job.work->end(); end && end->status < 300) return finish(job, *end, now);
        words = job.work->end() ? job.work->end()->error : job.work->half_done();
        if (job.work->end()) result = job.work->end()->result, evidence = job.work->end()->evidence;
    }
    finish(job, {503, std::move(result), "the gateway ends: " + words, "refused", evidence, true}, now);
}

// A client may begin the next job from within the answer to an ended one, so this repeats until nothing changes.
void DeviceService::run(TimePoint now) {
    if (stopped_ || std::exchange(runs_, true)) return;
    if (write_back_at_ && now >= *write_back_at_) write_back(now);
    const auto all = jobs_;
    for (const auto& job : all)
        if (!job->is_over()) advance(job, now);
    send_all(now);
    for (const auto& job : all)
        if (!job->is_over()) look(*job, now);
    runs_ = false;
    await(now);
}

void DeviceService::advance(const std::shared_ptr<Job>& job, TimePoint now) {
    if (!job->work) {
        if (now < job->begins_at) return;
        if (const auto refused = refusal(job->order, now); refused && job->order.deed == Deed::ground)
            return finish(*job, {refused->status, {}, refused->error, refused->what, {}, false}, now);
        job->work = job->order.work(place(*job));
        ++at_work_;
        job->message.clear();
        job->work->start(now);
    }
    job->work->run(now);
    if (job->work->end()) finish(*job, *job->work->end(), now);
}

void DeviceService::send_all(TimePoint now) {
    for (unsigned a = 0; a < known_.size(); ++a) {
        if (!known_[a] || !known_[a]->device) continue;
        while (const auto frame = known_[a]->device->next_frame(now)) {
            const std::uint8_t id = frame->id();
            const bool acts = is_act(*frame);
            const auto address = static_cast<std::uint8_t>(a);
            if (const std::string never = net_.send(*frame); !never.empty()) fail(address, id, acts, never, now);
            else if (acts) acted(address);
        }
    }
}

void DeviceService::acted(std::uint8_t address) {
    known_[address]->acted_before = next_id_;
    if (const auto job = holder(address)) job->has_acted = true;
}

bool DeviceService::remember(std::string name, std::string text) {
    if (!is_whole_note(name, text)) return false;
    if (sensor_of_note(name)) {
        write_back_at_ = net_.now();
        net_.wake(*write_back_at_);
    }
    notes_.remember(std::move(name), std::move(text));
    return true;
}

// By ordinary jobs, so a device that flies or is busy gets its values later. Each note has its own time, so that one that can't be written
// does not delay the others.
void DeviceService::write_back(TimePoint now) {
    write_back_at_.reset();
    const auto all = notes_.all();
    for (const auto& [name, text] : all) {
        const auto address = address_of_note(name);
        if (!address || !sensor_of_note(name)) continue;
        TimePoint& due = write_back_due_[name];
        if (now >= due) {
            const bool may_be_there = net_.whereabouts(*address, now).is_known && !holder(*address);
            due = now + (may_be_there ? between_write_backs : until_heard);
            const auto work = [name = name](const WorkPlace& place) { return write_old_values_back(place, name); };
            if (may_be_there) (void)begin({JobKind::calibration, Deed::ground, *address, false, "the gateway", work}, now);
        }
        write_back_at_ = std::min(write_back_at_.value_or(due), due);
    }
}

// A refusal of one frame applies to all of its kind; a frame that changes the device belongs to the one job that may do so. The job is not
// ended at once: its work restores what it can and reports what it could not.
void DeviceService::fail(std::uint8_t address, std::uint8_t id, bool acts, const std::string& why, TimePoint now) {
    const auto all = jobs_;
    for (const auto& job : all) {
        if (job->is_over() || job->order.address != address) continue;
        if (!job->work || !(acts ? job->is_writing() : asks_by(job->order.kind, id)) || !job->refused.empty()) continue;
        job->refused = why;
        job->work->cancel(now);
        if (job->work->end()) finish(*job, *job->work->end(), now);
    }
}

void DeviceService::finish(Job& job, WorkEnd end, TimePoint now) {
    if (job.work) {
        job.progress = job.work->progress();
        job.step = job.work->step();
    }
    if (!job.refused.empty() && end.status >= 300) {
        end = {403,       std::move(end.result), job.refused + (job.has_acted ? "; " + end.error : std::string{}),
               "refused", end.evidence,          false};
    }
    job.state = end.status < 300 ? JobState::done : end.is_cancelled ? JobState::cancelled : JobState::failed;
    job.message = end.error;
    if (end.status < 300) job.progress.done = job.progress.total;
    if (end.status < 300 && job.order.result) end.result = job.order.result();
    if (!end.result.empty() && !end.is_exact) end.result = exact_json(end.result);
    if (!end.result.empty()) job.result = std::make_shared<const std::string>(std::move(end.result.append("\n")));
    end.result.clear();
    // A device that answered this is not in its loader any more, which has neither parameters nor commands.
    if (end.status < 300 && job.order.address && job.order.kind != JobKind::firmware &&
        notes_.find(loader_note(*job.order.address)) != nullptr)
        notes_.forget(loader_note(*job.order.address));
    job.end = std::move(end);
    job.ended_at = now;
    if (std::exchange(job.work, nullptr)) --at_work_;
    job.order.work = nullptr;
    job.order.result = nullptr;
    used_at_ = now;
    if (tells_end_) tells_end_(job);
    for (const auto& told : std::exchange(job.on_end, {})) told(job);
    changed(job);
    forget_results();
}

// A client that waits for one of them keeps its result.
void DeviceService::forget_results() {
    std::size_t kept = 0;
    for (const auto& job : jobs_) kept += job->result ? job->result->size() : 0;
    for (auto at = jobs_.begin(); at != jobs_.end() && kept > max_results;) {
        const std::size_t size = (*at)->result ? (*at)->result->size() : 0;
        kept -= size;
        at = size > 0 ? jobs_.erase(at) : at + 1;
    }
}

void DeviceService::changed(Job& job) {
    ++job.version;
    const auto watchers = job.on_change;
    for (const auto* told : watchers) (*told)();
}

// Reports changes of a running job.
void DeviceService::look(Job& job, TimePoint now) {
    if (!job.work) return;
    const JobState state = job.work->is_waiting() ? JobState::waiting : JobState::running;
    if (state == job.state && now - job.told_at < between_progress) return;
    std::string message = job.work->message(), step = job.work->step();
    const ano::host::Progress progress = job.work->progress();
    const bool is_news = state != job.state || message != job.message || step != job.step || progress.done != job.progress.done ||
                         progress.total != job.progress.total;
    if (!is_news) return;
    job.state = state;
    job.message = std::move(message);
    job.step = std::move(step);
    job.progress = progress;
    job.told_at = now;
    changed(job);
}

void DeviceService::await(TimePoint now) {
    std::optional<TimePoint> at;
    const auto no_later = [&](std::optional<TimePoint> time) {
        if (time && (!at || *time < *at)) at = time;
    };
    for (const auto& job : jobs_) {
        if (job->is_over()) continue;
        if (!job->work) no_later(job->begins_at);
        else if (job->work->end()) no_later(now);
        else {
            no_later(job->work->due());
            no_later(now + between_progress);
        }
    }
    for (const auto& known : known_)
        if (known && known->device) no_later(known->device->due());
    if (write_back_at_) net_.wake(*write_back_at_);
    if (at) return net_.wake(std::max(*at, now));
    if (!listens_since_) return;
    if (now - used_at_ < idle_after) return net_.wake(used_at_ + idle_after);
    listens_since_.reset();
    guard_ = {};    // devices may land unheard meanwhile: listens again before ground work
    net_.listen(false);
}

std::optional<ano::host::DeviceInfo> DeviceService::info(std::uint8_t address) const {
    return known_[address] ? known_[address]->info : std::nullopt;
}

// An address goes before a device with that name.
std::variant<std::uint8_t, NotBegun> DeviceService::address_of(std::string_view word, TimePoint now) {
    const auto called = ano::address_called(word);
    if (const auto* address = std::get_if<std::uint8_t>(&called)) return *address;
    std::optional<std::uint8_t> named;
    for (const HeardAddress& one : heard(now)) {
        const auto said = info(one.address);
        if (!said || said->name != word) continue;
        if (named) return not_begun(409, "several devices are called " + ano::in_quotes(word) + ": say which by its address");
        named = one.address;
    }
    if (named) return *named;
    return not_begun(404, "no device is called " + ano::in_quotes(word) + ", and it is no address");
}

// The addresses known to `net_`, and those heard here: `net_` does not learn an address that is pinned to a link.
std::vector<HeardAddress> DeviceService::heard(TimePoint now) {
    std::vector<HeardAddress> all = net_.heard(now);
    for (unsigned a = 1; a < ano::address::broadcast; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        const auto is_it = [&](const HeardAddress& one) { return one.address == address; };
        if (!known_[a] || !known_[a]->heard_at || now - *known_[a]->heard_at >= ano::host::Device::away_after) continue;
        if (ano::address::is_host(address) || address == own_ || std::any_of(all.begin(), all.end(), is_it)) continue;
        all.push_back({address, {}, {}, known_[a]->heard_at});
    }
    return all;
}

std::vector<DeviceReport> DeviceService::devices(TimePoint now) {
    if (!stopped_) use(now);
    std::vector<DeviceReport> all;
    for (HeardAddress& one : heard(now)) {
        DeviceReport report{std::move(one), {}, {}, {}, {}, {}};
        const std::uint8_t address = report.heard.address;
        if (const auto& known = known_[address]) {
            report.info = known->info;
            if (known->heard_at && now - *known->heard_at < 2 * rate_over) report.rate = known->rate;
            if (known->heard_at && (!report.heard.heard_at || *known->heard_at > *report.heard.heard_at))
                report.heard.heard_at = known->heard_at;
            if (known->device) report.parameters = known->device->parameter_count();
        }
        if (const auto job = holder(address)) report.job = job->id;
        report.notes = notes_.names(address);
        all.push_back(std::move(report));
    }
    return all;
}

}    // namespace anogate
