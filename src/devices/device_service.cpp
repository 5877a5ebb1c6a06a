#include <ano/conversation.hpp>
#include <ano/hex.hpp>
#include <ano/typed.hpp>
#include <ano_json/frame_json.hpp>
#include <ano_json/strict_json.hpp>
#include <ano_json/text.hpp>
#include <devices/device_json.hpp>
#include <devices/device_service.hpp>
#include <devices/kept_descriptions.hpp>
#include <devices/unit_note.hpp>
#include <devices/works/calibration_work.hpp>
#include <host/parameter_info.hpp>
#include <http/response.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <new>
#include <utility>

namespace anogate {
namespace {

using ano::Duration;
using ano::TimePoint;
using ano::host::Operation;
using ano::host::Refusal;

constexpr Duration until_it_answers = std::chrono::seconds{2};
constexpr Duration between_looks = std::chrono::milliseconds{5};    // interval of checks whether a queued frame has been sent
constexpr Duration rate_over = std::chrono::seconds{2};
constexpr Duration listens_before_ground_work = std::chrono::seconds{2};    // to learn whether the device flies
constexpr Duration until_heard = std::chrono::seconds{2};                   // interval of looking whether a device is present

NotBegun not_begun(ano::Fault fault) {
    std::string what{http::what_of(fault.status())};
    return {std::move(fault), std::move(what), nullptr};
}

ano::Fault why(Refusal refusal, std::uint8_t address, const std::vector<std::string>& links) {
    const std::string device = ano::hex_byte(address);
    std::string seen;
    for (const std::string& link : links) seen += (seen.empty() ? "" : " and ") + link;
    switch (refusal) {
    case Refusal::no_device: return {"not_a_device", device};
    case Refusal::not_known: return {"not_seen", device};
    case Refusal::in_conflict:
        return seen.empty() ? ano::Fault{"address_conflict", device} : ano::Fault{"address_conflict_seen", device, seen};
    case Refusal::on_several_channels: return {"on_several_links", device};
    case Refusal::in_the_air: break;
    }
    return {"in_the_air", device};
}

// Whether a frame with this id, which changes the device, may belong to the job.
bool acts_by(const Job& job, std::uint8_t id) {
    return job.is_writing() && (job.order.kind == JobKind::command) == (id == ano::id_of<"command">);
}

// During an upgrade a device answers nothing else. A command does not wait for other jobs, except for a calibration, which would measure
// its effects: while the defaults are restored, with force even in flight, a landing must not be refused.
bool may_run_beside(const JobOrder& order, const JobOrder& other) {
    if (other.kind == JobKind::firmware) return false;
    return order.operation == Operation::read || (order.kind == JobKind::command && other.kind != JobKind::calibration);
}

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

bool DeviceService::receive(ano::FrameView frame, TimePoint now) {
    guard_.receive(frame, now);
    if (frame.id() == ano::id_of<"firmware">) forget_descriptions(frame);
    try {
        if (ano::writes(frame))
            for (const auto& job : jobs_) note_other_writer(*job, now);
        auto& known = known_[frame.source()];
        if (!known) known = std::make_unique<Known>();
        count(*known, now);
        if (frame.id() != ano::id_of<"check">) known->sends_more_than_checks = true;
        using ano::host::Taken;
        bool is_news = false, is_answer = false;
        sent_by_others(frame, now);
        if (const auto reported = ano::as<"device_info">(frame)) {
            is_answer = frame.destination() == own_;    // answers a scan, which asks all devices
            known->info = {reported->get<"dev_id">(), reported->get<"hw_ver">(), reported->get<"sw_ver">(),
                           reported->get<"bl_ver">(), reported->get<"pt_ver">(), std::string{reported->get<"name">()}};
        }
        const auto is_accepted_by = [&](const auto& one) {
            if (!one || !one->device) return false;
            const Taken taken = one->device->take(frame, now);
            if (taken == Taken::ended) learn_texts(*one, frame);
            is_news = is_news || taken == Taken::ended;
            is_answer = is_answer || taken == Taken::ended || taken == Taken::doubled || taken == Taken::late;
            return taken == Taken::ended;
        };
        // An answer belongs to one question only; the device whose own address it has is tried first.
        const bool is_over = is_accepted_by(known);
        learn_texts(*known, frame);
        confirm_info(*known, frame, now);
        report_varying_info(*known, frame.source());
        for (std::uint32_t ports = asked_ports_; ports != 0 && !is_over; ports &= ports - 1)
            if (const auto port = static_cast<std::uint8_t>(std::countr_zero(ports)); answers_at_port(frame.source(), port))
                is_accepted_by(known_[port]);
        if (!is_news && frame.destination() == own_ && frame.id() == ano::id_of<"check"> &&
            ano::address::is_port_id(frame.source()))
            if (const auto waiting = only_one_waiting(); waiting && net_.came_from(*waiting) && is_accepted_by(known_[*waiting]))
                known->acknowledged_as_port = true;
        for (std::size_t i = 0; at_work_ > 0 && i < jobs_.size(); ++i) {
            const auto& job = jobs_[i];
            if (!job->work) continue;
            const std::uint8_t at = job->order.address.value_or(frame.source());
            if (at == frame.source() || answers_at_port(frame.source(), at)) job->work->receive(frame, now);
        }
        if (is_news) net_.wake(now);
        return is_answer;
    } catch (const std::bad_alloc&) {    // the frame is ignored
        return false;
    }
}

void DeviceService::record_elsewhere(ano::FrameView frame, const std::string& place) {
    if (frame.destination() != own_ || !ano::may_answer(frame.id())) return;
    for (const auto& job : jobs_)
        if (!job->is_over() && job->order.address == frame.source() && job->conflict.empty())
            job->conflict = {"answers_elsewhere", ano::hex_byte(frame.source()), place};
}

void DeviceService::note_other_writer(Job& job, TimePoint now) {
    if (job.is_over() || !job.is_writing() || !job.order.address || !job.conflict.empty()) return;
    if (const auto writer = guard_.other_writer(*job.order.address, now))
        job.conflict = {"other_writer", ano::hex_byte(*writer), ano::hex_byte(*job.order.address)};
}

// Some devices acknowledge with the address of the port at which the request arrived.
std::optional<std::uint8_t> DeviceService::only_one_waiting() const {
    std::optional<std::uint8_t> found;
    for (const auto& known : known_) {
        if (!known || !known->device || !known->device->awaits_acknowledgement()) continue;
        if (found) return std::nullopt;
        found = known->device->address();
    }
    return found;
}

void DeviceService::sent_by_others(ano::FrameView frame, TimePoint now) {
    if (ano::host::is_question_for_info(frame)) info_is_asked(frame.destination(), now);
}

// For a port or the broadcast address any device may answer.
void DeviceService::info_is_asked(std::uint8_t address, TimePoint now) {
    const bool is_any = ano::address::is_port_id(address) || address == ano::address::broadcast;
    for (unsigned a = 0; a < known_.size(); ++a)
        if (known_[a] && known_[a]->device && (is_any || a == address)) known_[a]->device->expect_info(now);
}

void DeviceService::learn_texts(Known& known, ano::FrameView frame) noexcept {
    if (known.device && known.presence != known.device->presence()) {
        known.presence = known.device->presence();
        known.texts.forget();
        if (known.info) known.texts.learn(known.info->name);
    }
    known.texts.learn(frame);
}

const DeviceTexts& DeviceService::texts(std::uint8_t address) {
    auto& known = known_[address];
    if (!known) known = std::make_unique<Known>();
    const DeviceLimits device_limits = net_.device_limits(address);
    known->texts.configure(device_limits.encoding, device_limits.expects_gbk);
    if (!known->texts.contradicts()) known->has_logged_encoding = false;
    else if (!std::exchange(known->has_logged_encoding, true))
        net_.report(ano::hex_byte(address) + ": " + std::string{encoding_hint}, true);
    return known->texts;
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
    if (!known->device) {
        known->device = std::make_unique<ano::host::Device>(address, own_);
        if (known->info) known->device->know_as(*known->info);
        known->device->know_pace(paces_[address]);
        known->device->on_maybe_deaf([this](ano::FrameView next) { return net_.flush_parser(next); });
    }
    if (ano::address::is_port_id(address)) asked_ports_ |= std::uint32_t{1} << address;
    return *known->device;
}

WorkPlace DeviceService::place_of(std::uint8_t address) {
    return {device(address), cache_, commands_, net_, journal_, texts(address)};
}

void DeviceService::keep_descriptions() {
    using Key = ano::host::DescriptionKey;
    using All = std::vector<ano::host::ParameterInfo>;
    const auto recall = [this](const Key& key) -> std::optional<All> {
        const WorkPlace place = place_of(key.address);
        const std::string text = net_.cached(descriptions_name(place));
        auto all = text.empty() ? std::nullopt : descriptions_in(text, place, key.count);
        if (!all) return std::nullopt;
        for (const ano::host::ParameterInfo& info : *all) {    // finds out its encoding from the same texts as when they were
                                                               // read
            known_[key.address]->texts.learn(info.name);
            known_[key.address]->texts.learn(info.info);
        }
        return all;
    };
    const auto keep = [this](const Key& key, const All& all) {
        const WorkPlace place = place_of(key.address);
        net_.cache(descriptions_name(place), descriptions_text(place, all));
    };
    cache_.use({recall, keep});
}

WorkPlace DeviceService::place(const Job& job) {
    if (job.order.address) {
        const auto refused = [this,
                              order = JobOrder{job.order.kind, job.order.operation, job.order.address, job.order.force, {}, {}}] {
            const auto refused_now = refusal(order, net_.now());
            return refused_now ? refused_now->fault : ano::Fault{};
        };
        return {device(*job.order.address),     cache_, commands_, net_, journal_, texts(*job.order.address), refused,
                !job.order.requester.controls()};
    }
    if (!everybody_) everybody_ = std::make_unique<ano::host::Device>(ano::address::broadcast, own_);
    return {*everybody_, cache_, commands_, net_, journal_, default_texts_};
}

std::shared_ptr<Job> DeviceService::holder(std::uint8_t address) const {
    const auto found = std::find_if(jobs_.begin(), jobs_.end(), [&](const auto& job) {
        return !job->is_over() && job->is_writing() && job->order.address &&
               (*job->order.address == address || net_.is_same_device(*job->order.address, address));
    });
    return found != jobs_.end() ? *found : nullptr;
}

// Never returns a job that began before the device was changed: it may have read old values.
std::shared_ptr<Job> DeviceService::shared(const JobOrder& order) const {
    if (order.shared_as.empty() || !order.address) return nullptr;
    const unsigned from = known_[*order.address] ? known_[*order.address]->acted_before : 0;
    const auto found = std::find_if(jobs_.begin(), jobs_.end(), [&](const auto& job) {
        return !job->is_over() && job->order.address == order.address && job->order.shared_as == order.shared_as &&
               job->order.requester.access >= order.requester.access &&    // otherwise it yields to others
               job->id >= from && job->refused.empty() && !job->is_cancelled;
    });
    return found != jobs_.end() ? *found : nullptr;
}

// A device that is not heard any more may still receive. A command, which may be LAND, is sent to it at once; anoctl first asks
// for the description of the command. The router decides which links may carry a command to a device that was never heard.
bool DeviceService::may_go_unheard(const JobOrder& order, bool was_heard) const {
    if (order.is_first_frame || !was_heard) return order.is_first_frame;
    return order.kind == JobKind::command || (order.kind == JobKind::commands && commands_.has(*order.address));
}

std::optional<NotBegun> DeviceService::refusal(const JobOrder& order, TimePoint now) {
    if (!order.address) return std::nullopt;
    const std::uint8_t address = *order.address;
    const auto where = net_.route_info(address, now);
    auto refused = guard_.refusal(order.operation, address, where, order.force);
    if (!refused && !where.is_known && !may_go_unheard(order, where.was_heard)) refused = Refusal::not_known;
    if (!refused) return std::nullopt;
    NotBegun told = not_begun(why(*refused, address, net_.links_in_conflict(address, now)));
    if (told.status() == 409) told.what = "refused";
    return told;
}

bool DeviceService::may_run_one_more(const Requester& requester) const {
    std::vector<Requester> running;
    for (const auto& job : jobs_)
        if (!job->is_over()) running.push_back(job->order.requester);
    return has_place_for(requester, running_places, running);
}

std::shared_ptr<void> DeviceService::waiting_client(const Requester& requester) {
    const auto at = waiting_clients_->insert(waiting_clients_->end(), requester);
    return {&*at, [all = waiting_clients_, at](const void*) { all->erase(at); }};
}

std::size_t DeviceService::upgrades() const {
    return static_cast<std::size_t>(std::count_if(
        jobs_.begin(), jobs_.end(), [](const auto& job) { return !job->is_over() && job->order.kind == JobKind::firmware; }));
}

// Removes ended jobs that are old and, if needed, the oldest ended one: first viewing jobs, then reading jobs. False: all jobs
// are running.
bool DeviceService::make_room(TimePoint now) {
    const auto is_old = [&](const auto& job) { return job->is_over() && now - job->ended_at >= kept_for; };
    jobs_.erase(std::remove_if(jobs_.begin(), jobs_.end(), is_old), jobs_.end());
    if (jobs_.size() < max_jobs) return true;
    const auto rank = [](const auto& job) {
        if (!job->is_over()) return 3;
        return !job->order.requester.controls() ? 0 : job->is_writing() ? 2 : 1;
    };
    const auto first = std::min_element(jobs_.begin(), jobs_.end(),
                                        [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
    if (first == jobs_.end() || !(*first)->is_over()) return false;
    jobs_.erase(first);
    return true;
}

std::variant<std::shared_ptr<Job>, NotBegun> DeviceService::begin(JobOrder order, TimePoint now) {
    if (stopped_) return not_begun({"stopping"});
    use(now);
    auto refused = refusal(order, now);
    const bool is_unheard = refused && refused->fault.is("not_seen");
    if (refused && !is_unheard) return *std::move(refused);
    if (order.address)
        if (auto has_it = holder(*order.address); has_it && !may_run_beside(order, has_it->order))
            return NotBegun{{"used_by_job", ano::hex_byte(*order.address), name_of(*has_it)}, "busy", has_it};
    if (auto same = shared(order)) return same;
    if (order.kind == JobKind::firmware && upgrades() >= max_upgrades) return not_begun({"upgrades_running"});
    if (!may_run_one_more(order.requester) || !make_room(now)) return not_begun({"jobs_running"});
    auto job = std::make_shared<Job>();
    job->id = next_id_++;
    job->order = std::move(order);
    job->begins_at = now;
    if (job->order.operation == Operation::ground) {
        job->begins_at = std::max(now, *listens_since_ + listens_before_ground_work);
        job->message = "checking that it is not flying";
    }
    note_other_writer(*job, now);
    if (is_unheard) {
        ask_whether_it_is_there(*job->order.address, now);
        job->heard_by = now + until_it_answers;
    }
    jobs_.push_back(job);
    net_.wake(now);
    return job;
}

void DeviceService::ask_whether_it_is_there(std::uint8_t address, TimePoint now) { ask_who_it_is(address, now, nobody_); }

void DeviceService::link_was_down(std::uint8_t address) {
    const auto& known = known_[address];
    if (!known) return;
    known->in_doubt = true;
    if (known->device) known->device->link_was_down();
}

// Called after a sign that it may be another device.
void DeviceService::confirm_info(Known& known, ano::FrameView frame, TimePoint now) {
    const std::uint32_t signs = known.device ? known.device->signs() : known.signs;
    const bool is_in_doubt = std::exchange(known.in_doubt, false) || signs != known.signs;
    known.signs = signs;
    if (known.device && known.device->is_identified()) return;
    if (!is_in_doubt || !known.info || frame.id() == ano::id_of<"device_info">) return;
    known.in_doubt = holder(frame.source()) != nullptr;    // a job measures its own silence: later
    if (known.in_doubt) return;
    ask_who_it_is(frame.source(), now, curious_);
    net_.wake(now);
}

void DeviceService::report_varying_info(Known& known, std::uint8_t address) {
    if (!known.device || !known.device->has_varying_info() || std::exchange(known.told_varying, true)) return;
    net_.report(ano::hex_byte(address) +
                    ": its device info differs in each answer, so another device with this address is only "
                    "noticed by what does not differ; its firmware should send constant device info",
                true);
}

void DeviceService::ask_who_it_is(std::uint8_t address, TimePoint now, Nobody& asker) {
    ano::host::Device& asked = device(address);
    auto& until = known_[address]->asked_until;
    if (now < until) return;
    until = now + until_it_answers;
    constexpr unsigned sends = 4;
    ano::host::Request question = ano::host::question::device_info(0);
    question.patience = {.sends = sends, .wait = until_it_answers / sends};
    static_cast<void>(asked.ask(question, asker));
}

// Returns false if the device is not heard yet; if it was not heard in time, the job has ended as well.
bool DeviceService::is_heard(Job& job, TimePoint now) {
    if (!job.heard_by) return true;
    const auto refused = refusal(job.order, now);
    if (refused && refused->fault.is("not_seen") && now < *job.heard_by) return false;
    if (!refused) job.heard_by.reset();
    else finish(job, {refused->status(), {}, refused->fault, refused->what, {}, false}, now);
    return !refused;
}

bool DeviceService::cancel(Job& job, TimePoint now) {
    if (job.is_over()) return false;
    job.is_cancelled = true;
    if (job.work) job.work->cancel(now);
    else finish(job, {409, {}, {"cancelled_before"}, "refused", {}, true}, now);
    net_.wake(now);
    return true;
}

void DeviceService::left(Job& job) {
    if (job.needed_by > 0 && --job.needed_by == 0 && !job.goes_on) cancel(job, net_.now());
}

std::optional<NotBegun> DeviceService::go_on(Job& job, TimePoint now) {
    const NotBegun does_not_wait = not_begun({"job_not_waiting"});
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
    ano::Fault state{"nothing_started"};
    std::string result;
    ano::host::Evidence evidence{};
    if (job.work) {
        if (!job.work->end()) job.work->cancel(now);
        if (!job.work->end()) job.work->run(now);
        if (const auto& end = job.work->end(); end && end->status < 300) return finish(job, *end, now);
        state = job.work->end() ? job.work->end()->fault : job.work->half_done();
        if (job.work->end()) result = job.work->end()->result, evidence = job.work->end()->evidence;
    }
    finish(job, {503, std::move(result), {"stopping_at", std::move(state)}, "refused", evidence, true}, now);
}

// A client may start the next job while an ended one is being answered, so this repeats until nothing changes.
void DeviceService::run(TimePoint now) {
    if (stopped_ || std::exchange(runs_, true)) return;
    run_feeds(now);
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
        if (!is_heard(*job, now) || now < job->begins_at) return;
        if (const auto refused = refusal(job->order, now); refused && job->order.operation == Operation::ground)
            return finish(*job, {refused->status(), {}, refused->fault, refused->what, {}, false}, now);
        job->work = job->order.work(place(*job));
        ++at_work_;
        job->message.clear();
        job->work->start(now);
    }
    const auto due = job->work->due();
    job->work->run(now);
    const bool asks_all = job->order.kind == JobKind::scan && job->work->due() != due;    // with each send
    if (asks_all) info_is_asked(ano::address::broadcast, now);
    if (job->work->end()) finish(*job, *job->work->end(), now);
}

void DeviceService::send_all(TimePoint now) {
    for (unsigned a = 0; a < known_.size(); ++a) {
        if (!known_[a] || !known_[a]->device) continue;
        const auto address = static_cast<std::uint8_t>(a);
        for (;;) {
            if (!known_[a]->device->has_command() && is_queued(address, now)) {
                known_[a]->device->wait_to_leave(now);
                break;
            }
            const auto frame = known_[a]->device->next_frame(now);
            if (!frame) break;
            const std::uint8_t id = frame->id();
            const bool acts = ano::intent_of(*frame) == ano::Intent::acts;
            const ano::Checks checks = frame->checks();
            if (ano::address::is_port_id(address)) sent_by_others(*frame, now);    // for any device behind it
            const Unsent unsent = net_.send(*frame);
            if (unsent.is_down) fail_calls(address, unsent.why, now);
            else if (!unsent.why.empty()) fail(address, id, acts, unsent.why, now);
            else if (acts) acted(address, id);
            if (!unsent.why.empty()) known_[address]->device->was_not_sent(checks);
        }
    }
}

// Whether a frame to the device waits to be sent.
bool DeviceService::is_queued(std::uint8_t address, TimePoint now) {
    const ano::host::Device& device = *known_[address]->device;
    return device.on_their_way() > 0 && now - device.last_sent() < ano::host::Device::max_queued && net_.is_waiting(address);
}

void DeviceService::acted(std::uint8_t address, std::uint8_t id) {
    known_[address]->acted_before = next_id_;
    for (const auto& job : jobs_)
        if (!job->is_over() && job->order.address == address && acts_by(*job, id)) ++job->acted;
}

bool DeviceService::remember(std::string name, std::string text) {
    if (!damage_of_note(name, text).empty()) return false;
    if (sensor_of_note(name)) {
        write_back_at_ = net_.now();
        net_.wake(*write_back_at_);
    }
    journal_.remember(std::move(name), std::move(text));
    return true;
}

void DeviceService::keep_limits(std::uint8_t address, AlarmLimits::List list, std::function<void(std::string fault)> done) {
    limits_.set(address, std::move(list));
    const auto& kept = limits_.of(address);
    alarms_.set(address, kept, net_.now());
    await_feeds();
    net_.keep(limits_file(address), kept.empty() ? std::string{} : AlarmLimits::json(kept).dump() + "\n", std::move(done));
}

std::string DeviceService::remember_limits(std::uint8_t address, const std::string& text) {
    auto json = ano::json_body(text, "it");
    if (auto* wrong = std::get_if<std::string>(&json)) return std::move(*wrong);
    auto list = AlarmLimits::parse(std::get<nlohmann::ordered_json>(json));
    if (const auto* wrong = std::get_if<std::string>(&list)) return *wrong;
    limits_.set(address, std::get<AlarmLimits::List>(std::move(list)));
    alarms_.set(address, limits_.of(address), net_.now());
    return {};
}

void DeviceService::record_log(ano::FrameView frame, std::string_view link, std::uint64_t time_ns, DeviceLog::Origin origin) {
    if (!log_.receive(frame, link, time_ns, origin) || log_clients_.empty() || log_due_) return;
    log_due_ = net_.now() + between_log_lines;
    await_feeds();
}

void DeviceService::record_value(std::uint8_t source, const ano::Reading& reading, TimePoint now, bool raises_only) {
    alarms_.receive(source, reading, now, raises_only);
    await_feeds();
}

void DeviceService::record_mode(ano::FrameView frame, TimePoint now) {
    const auto mode = ano::as<"mode">(frame);
    if (!mode) return;
    losses_.record_mode(frame.source(), mode->get<"sflag">(), now);
    note_pace(frame.source(), now);
    report_returned(frame.source(), now);
}

void DeviceService::record_telemetry(std::uint8_t source, std::uint8_t id, TimePoint now) {
    losses_.receive(source, id, now);
    if (!LossWatch::is_telemetry(id)) return;
    note_pace(source, now);
    report_returned(source, now);
}

// A Device measures the pace itself.
void DeviceService::note_pace(std::uint8_t source, TimePoint now) noexcept {
    if (!known_[source] || !known_[source]->device) static_cast<void>(paces_[source].came(now, {}));
}

void DeviceService::report_returned(std::uint8_t source, TimePoint now) {
    if (!alarms_.awaits(source) || ano::address::is_host(source)) return;
    alarms_.look_soon(now);
    await_feeds();
}

void DeviceService::record_elsewhere(std::uint8_t source, const std::string& place, TimePoint now) {
    losses_.record_elsewhere(source, place);
    alarms_.look_soon(now);
    await_feeds();
}

std::vector<WatchedDevice> DeviceService::watched(TimePoint now) {
    std::vector<WatchedDevice> all;
    for (unsigned a = 1; a < ano::address::broadcast; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        if (ano::address::is_host(address)) continue;
        if (auto device = losses_.device(address, now)) all.push_back(*std::move(device));
    }
    return all;
}

std::vector<WatchedDevice> DeviceService::lost(TimePoint now) {
    std::vector<WatchedDevice> all = watched(now);
    std::erase_if(all, [now](const WatchedDevice& one) {
        return !one.is_lost || (one.was_locked() && now - one.heard_at >= AlarmFeed::locked_reported_for);
    });
    return all;
}

void DeviceService::look_for_alarms(TimePoint now) {
    alarms_.look(watched(now), now);
    await_feeds();
}

bool DeviceService::forget_values(std::uint8_t address) {
    const bool was_watched = losses_.device(address, net_.now()).has_value();
    losses_.forget(address);
    alarms_.forget(address, net_.now());
    await_feeds();
    return was_watched;
}

void DeviceService::run_feeds(TimePoint now) {
    if (alarms_.due() && now >= *alarms_.due()) look_for_alarms(now);
    if (!log_due_ || now < *log_due_) return;
    log_due_.reset();
    log_clients_.wake();
}

void DeviceService::await_feeds() {
    if (alarms_.due()) net_.wake(*alarms_.due());
    if (log_due_) net_.wake(*log_due_);
}

void DeviceService::write_back_soon(TimePoint now) {
    if (write_back_at_ || stopped_) return;
    write_back_at_ = now + until_heard;
    net_.wake(*write_back_at_);
}

// Uses ordinary jobs, so a device that flies or is busy gets its values later. Each note has its own time, so that a note that
// can't be written back does not delay the others.
void DeviceService::write_back(TimePoint now) {
    write_back_at_.reset();
    const auto all = journal_.all();
    for (const auto& [name, text] : all) {
        const auto address = address_of_note(name);
        if (!address || !sensor_of_note(name)) continue;
        TimePoint& due = write_back_due_[name];
        bool may_write = true;
        if (now >= due) {
            const bool may_be_there = net_.route_info(*address, now).is_known && !holder(*address);
            due = now + (may_be_there ? between_write_backs : until_heard);
            if (const std::string misfit = misfit_of_place(text, net_.unit_place(*address, now), may_be_there); !misfit.empty()) {
                report_note(name, name + " is not used: it is " + misfit, true);
                due = now + between_write_backs;
                may_write = false;
            }
            const auto work = [name = name](const WorkPlace& place) { return write_old_values_back(place, name); };
            if (may_be_there && may_write) {
                const auto begun = begin({JobKind::calibration, Operation::ground, *address, false, "the gateway", work}, now);
                if (const auto* job = std::get_if<std::shared_ptr<Job>>(&begun))
                    (*job)->on_end.push_back([this, name = name](const Job& ended) {
                        const bool is_done = ended.state == JobState::done;
                        report_note(name, is_done ? ended.message : name + " is not written back: " + ended.message, !is_done);
                    });
            }
        }
        write_back_at_ = std::min(write_back_at_.value_or(due), due);
    }
}

// Reports a text about a note only once, since it is tried every minute.
void DeviceService::report_note(const std::string& name, const std::string& text, bool is_warning) {
    if (std::exchange(last_reports_[name], text) != text) net_.report(text, is_warning);
}

// A refusal of one frame applies to all frames of its kind; a frame that changes the device belongs to the commands, or to the
// one other job that may change it. The job does not end at once: its work restores what it can and reports the rest.
void DeviceService::fail(std::uint8_t address, std::uint8_t id, bool acts, const ano::Fault& why, TimePoint now) {
    const auto all = jobs_;
    for (const auto& job : all) {
        if (job->is_over() || job->order.address != address) continue;
        if (acts ? acts_by(*job, id) : asks_by(job->order.kind, id)) end_refused(job, 403, why, now);
    }
}

// A command that was not sent must not be sent late, to a device that has replaced this one.
void DeviceService::fail_calls(std::uint8_t address, const ano::Fault& why, TimePoint now) {
    const auto all = jobs_;
    for (const auto& job : all)
        if (!job->is_over() && job->order.address == address && job->order.kind == JobKind::command && job->acted == 0)
            end_refused(job, 503, why, now);
}

void DeviceService::not_sent(ano::FrameView frame, const Unsent& unsent, TimePoint now) {
    const std::uint8_t address = frame.destination();
    const std::uint8_t id = frame.id();
    const bool acts = ano::intent_of(frame) == ano::Intent::acts;
    for (const auto& job : jobs_)
        if (acts && !job->is_over() && job->order.address == address && acts_by(*job, id) && job->acted > 0) --job->acted;
    if (!unsent.is_down) fail(address, id, acts, unsent.why, now);
    else if (id == ano::id_of<"command">) fail_calls(address, unsent.why, now);
    if (known_[address] && known_[address]->device) known_[address]->device->was_not_sent(frame.checks());
}

void DeviceService::end_refused(const std::shared_ptr<Job>& job, unsigned status, const ano::Fault& why, TimePoint now) {
    if (!job->work || !job->refused.empty()) return;
    job->refused = why;
    job->refused_status = status;
    job->work->cancel(now);
    if (job->work->end()) finish(*job, *job->work->end(), now);
}

void DeviceService::refuse(std::uint8_t address, const ano::Fault& why, TimePoint now) {
    const auto job = holder(address);
    if (!job || job->order.kind != JobKind::action) return;
    job->acted = 0;
    fail(address, 0, true, why, now);
    net_.wake(now);
}

void DeviceService::finish(Job& job, WorkEnd end, TimePoint now) {
    if (job.work) {
        job.progress = job.work->progress();
        job.step = job.work->step();
    }
    if (!job.refused.empty() && end.status >= 300) {
        const ano::Fault state = job.acted > 0 ? std::move(end.fault) : ano::Fault{};
        end = {job.refused_status, std::move(end.result), job.refused, "refused", end.evidence, false};
        end.fault.add(state);
    }
    job.state = end.status < 300 ? JobState::done : end.is_cancelled ? JobState::cancelled : JobState::failed;
    if (end.status >= 300) end.fault.add(std::exchange(job.stopped, {})).add(job.conflict);
    job.stopped = {};
    job.message = (end.fault.empty() ? job.conflict : end.fault).text();
    if (end.status < 300) job.progress.done = job.progress.total;
    if (end.status < 300 && job.order.result) end.result = job.order.result();
    if (!end.result.empty() && !end.is_exact) end.result = exact_json(end.result);
    if (!end.result.empty()) job.result = std::make_shared<const std::string>(std::move(end.result.append("\n")));
    end.result.clear();
    // A device that answered this is no longer in its loader, which has neither parameters nor commands.
    if (end.status < 300 && job.order.address && job.order.kind != JobKind::firmware)
        forget_loader_notes(journal_, *job.order.address, net_.unit_place(*job.order.address, now));
    job.end = std::move(end);
    job.ended_at = now;
    if (std::exchange(job.work, nullptr)) --at_work_;
    job.order.work = nullptr;
    job.order.result = nullptr;
    // The question for its device info waited behind the one without an answer.
    if (job.state == JobState::failed && job.order.kind == JobKind::commands && !info(*job.order.address))
        ask_who_it_is(*job.order.address, now, curious_);
    if (job.order.kind == JobKind::calibration && !journal_.all().empty()) write_back_soon(now);
    used_at_ = now;
    if (on_end_) on_end_(job);
    for (const auto& told : std::exchange(job.on_end, {})) told(job);
    changed(job);
    forget_results();
}

// A client that still waits for a result keeps it.
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
    if (state == job.state && now - job.reported_at < between_progress) return;
    std::string message = job.work->message(), step = job.work->step();
    if (job.order.address) job.stopped = net_.accepts_nothing(*job.order.address);
    if (!job.stopped.empty()) message += "; " + job.stopped.text();
    const ano::host::Progress progress = job.work->progress();
    const bool is_news = state != job.state || message != job.message || step != job.step || progress.done != job.progress.done ||
                         progress.total != job.progress.total;
    if (!is_news) return;
    job.state = state;
    job.message = std::move(message);
    job.step = std::move(step);
    job.progress = progress;
    job.reported_at = now;
    changed(job);
}

void DeviceService::await(TimePoint now) {
    std::optional<TimePoint> at;
    const auto no_later = [&](std::optional<TimePoint> time) {
        if (time && (!at || *time < *at)) at = time;
    };
    for (const auto& job : jobs_) {
        if (job->is_over()) continue;
        if (!job->work) no_later(std::max(job->begins_at, job->heard_by.value_or(job->begins_at)));
        else if (job->work->end() || job->work->is_ready()) no_later(now);
        else {
            no_later(job->work->due());
            no_later(now + between_progress);
        }
    }
    for (unsigned a = 0; a < known_.size(); ++a) {
        if (!known_[a] || !known_[a]->device) continue;
        const bool queued = is_queued(static_cast<std::uint8_t>(a), now);
        no_later(queued ? now + between_looks : known_[a]->device->due());
    }
    if (write_back_at_) net_.wake(*write_back_at_);
    await_feeds();
    if (at) return net_.wake(std::max(*at, now));
    if (!listens_since_) return;
    if (now - used_at_ < idle_after) return net_.wake(used_at_ + idle_after);
    if (const auto until = known_until(now)) return net_.wake(*until);
    listens_since_.reset();
    guard_ = {};    // devices may land unheard meanwhile: listens again before ground work
    net_.listen(false);
}

// How long a device with known descriptions counts as present; std::nullopt: there is none.
std::optional<TimePoint> DeviceService::known_until(TimePoint now) const {
    std::optional<TimePoint> until;
    for (const auto& known : known_) {
        if (!known || !known->device || !known->device->is_present(now)) continue;
        const std::uint8_t address = known->device->address();
        if (!cache_.has(address) && !commands_.has(address)) continue;
        const TimePoint away_at = *known->device->heard_at() + ano::host::Device::away_after;
        until = std::max(until.value_or(away_at), away_at);
    }
    return until;
}

// With new firmware the device has other parameters and commands. The device behind a port is not known here.
void DeviceService::forget_descriptions(ano::FrameView upgrade) {
    const auto forget = [this](std::uint8_t address) {
        cache_.forget(address);
        commands_.forget(address);
    };
    forget(upgrade.source());
    forget(upgrade.destination());
    for (std::uint8_t port = 1; port <= ano::address::last_port_id; ++port) forget(port);
}

std::optional<ano::host::DeviceInfo> DeviceService::info(std::uint8_t address) const {
    return known_[address] ? known_[address]->info : std::nullopt;
}

// An address has priority over a device with that name.
std::variant<std::uint8_t, NotBegun> DeviceService::address_of(std::string_view word, TimePoint now) {
    const auto called = ano::address_called(word);
    if (const auto* address = std::get_if<std::uint8_t>(&called)) return *address;
    std::optional<std::uint8_t> named;
    for (const HeardAddress& one : heard(now)) {
        const auto reported = info(one.address);
        if (!reported || !texts(one.address).is(reported->name, word)) continue;
        if (named) return not_begun({"several_named", ano::in_quotes(word)});
        named = one.address;
    }
    if (named) return *named;
    return not_begun({"unknown_device", ano::in_quotes(word)});
}

// The addresses known to `net_`, and those heard here: `net_` does not learn an address that is pinned to a link or a group.
std::vector<HeardAddress> DeviceService::heard(TimePoint now) {
    std::vector<HeardAddress> all = net_.heard(now);
    for (unsigned a = 1; a < ano::address::broadcast; ++a) {
        const auto address = static_cast<std::uint8_t>(a);
        const auto is_it = [&](const HeardAddress& one) { return one.address == address; };
        if (!known_[a] || !known_[a]->heard_at || now - *known_[a]->heard_at >= ano::host::Device::away_after) continue;
        if (ano::address::is_host(address) || address == own_ || std::any_of(all.begin(), all.end(), is_it)) continue;
        all.push_back({address, net_.unit_place(address, now).link, {}, known_[a]->heard_at});
    }
    std::erase_if(all, [this](const HeardAddress& one) {
        const auto& known = known_[one.address];
        return known && known->acknowledged_as_port && !known->sends_more_than_checks;
    });
    return all;
}

// Leaves out notes about another device in its loader.
std::vector<std::string> DeviceService::notes_to_show(std::uint8_t address, TimePoint now) {
    std::vector<std::string> names = journal_.names(address);
    std::erase_if(names, [&](const std::string& name) {
        return is_type_7_note(name) ||
               (is_loader_note(name) && !misfit_of_place(*journal_.find(name), net_.unit_place(address, now), true).empty());
    });
    for (std::string& dropped : journal_.dropped(address)) names.push_back(std::move(dropped));
    return names;
}

std::vector<DeviceReport> DeviceService::devices(TimePoint now) {
    if (!stopped_) use(now);
    std::vector<DeviceReport> all;
    for (HeardAddress& one : heard(now)) {
        DeviceReport report{std::move(one), {}, {}, {}, {}, {}, {}, {}, {}};
        const std::uint8_t address = report.heard.address;
        report.texts = texts(address);
        if (const auto& known = known_[address]) {
            report.info = known->info;
            if (known->heard_at && now - *known->heard_at < 2 * rate_over) report.rate = known->rate;
            if (known->heard_at && (!report.heard.heard_at || *known->heard_at > *report.heard.heard_at))
                report.heard.heard_at = known->heard_at;
            if (known->device) report.parameters = known->device->parameter_count();
        }
        if (const auto job = holder(address)) report.job = job->id;
        report.notes = notes_to_show(address, now);
        report.limits = limits_.version(address);
        report.red_lines = log_.red(address);
        all.push_back(std::move(report));
    }
    return all;
}

}    // namespace anogate
