#include <ano_json/compact_json.hpp>
#include <ano_json/nearest.hpp>
#include <ano_json/text.hpp>
#include <devices/device_json.hpp>
#include <devices/rows_text.hpp>
#include <devices/works/calibration_work.hpp>
#include <devices/works/parameter_works.hpp>
#include <host/parameter_apply.hpp>
#include <host/parameters.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;
using ano::TimePoint;
using ano::host::Ending;
using ano::host::ParameterApply;
using ano::host::Parameters;
using ano::host::ParameterWrite;
using ano::host::Task;

// Whether `marked` is `name` with a '?' in place of each control character, as in files of older versions.
bool is_marked(std::string_view name, std::string_view marked) {
    while (!name.empty() && !marked.empty()) {
        const std::size_t control = ano::control_size(name, 0);
        if (marked.front() != (control > 0 ? '?' : name.front())) return false;
        name.remove_prefix(std::max(control, std::size_t{1}));
        marked.remove_prefix(1);
    }
    return name.empty() && marked.empty();
}

WorkEnd with_result(WorkEnd end, const Json& result) {
    end.result = ano::compact_json(result);
    return end;
}

// Reads the descriptions of all parameters, then continues.
class ParameterWork : public TaskWork {
public:
    using TaskWork::TaskWork;

protected:
    void read(Parameters::Values values, TimePoint now) {
        parameters_ = &next(std::make_unique<Parameters>(place().device, &place().cache));
        parameters_->read(values, now);
    }
    /// Reads the values of the parameters with these names or numbers.
    void read_called(const std::vector<std::string>& words, bool to_write, TimePoint now) {
        place().device.ask_by_number(place().net.device_limits(place().device.address()).by_number);
        parameters_ = &next(std::make_unique<Parameters>(place().device, &place().cache));
        if (to_write) parameters_->compare_anyway();
        parameters_->accept_unlisted(numbers_in(words));
        parameters_->read_where([this, words](const ano::host::ParameterInfo& one) { return is_called(one, words); }, now,
                                words.size());
    }
    static std::vector<std::uint16_t> numbers_in(const std::vector<std::string>& words) {
        std::vector<std::uint16_t> numbers;
        for (const std::string& word : words) {
            std::uint16_t number = 0;
            const auto [rest, fault] = std::from_chars(word.data(), word.data() + word.size(), number);
            if (fault == std::errc{} && rest == word.data() + word.size()) numbers.push_back(number);
        }
        return numbers;
    }
    bool is_called(const ano::host::ParameterInfo& one, const std::vector<std::string>& words) const {
        const std::string display_text = texts().display_text(one.name), id = std::to_string(one.id);
        return std::any_of(words.begin(), words.end(), [&](const std::string& word) {
            return word == display_text || word == id || DeviceTexts::is_once_exported(one.name, word);
        });
    }
    /// The descriptions as read before, if the device was not away since; nullptr: they are not known.
    const std::vector<ano::host::ParameterInfo>* known(TimePoint now) {
        const auto key = key_of(place().device, place().device.parameter_count(), now);
        return key ? place().cache.find(*key) : nullptr;
    }
    const Parameters& parameters() const { return *parameters_; }
    /// The parameter of `all` that has the name `name` for clients.
    ano::host::Found named(const std::vector<ano::host::ParameterInfo>& all, std::string_view name) {
        if (std::exchange(display_names_of_, all.data()) != all.data() || display_names_.size() != all.size()) {
            display_names_.clear();
            for (const ano::host::ParameterInfo& one : all) display_names_.push_back(texts().display_text(one.name));
        }
        ano::host::Found found;
        for (std::size_t id = 0; id < all.size(); ++id) {
            if (name.empty() || all[id].name.empty()) continue;
            if (display_names_[id] != name && !DeviceTexts::is_once_exported(all[id].name, name)) continue;
            if (found.parameter != nullptr) return {nullptr, true};
            found.parameter = &all[id];
        }
        if (found.parameter == nullptr) found.parameter = numbered(all, name);
        return found;
    }
    /// "NAME#3", as in a file in which the name alone is ambiguous: the parameter 3, if that is its name.
    const ano::host::ParameterInfo* numbered(const std::vector<ano::host::ParameterInfo>& all, std::string_view word) const {
        const std::size_t end = word.rfind('#');
        if (end == std::string_view::npos) return nullptr;
        std::uint16_t id = 0;
        const auto [rest, fault] = std::from_chars(word.data() + end + 1, word.data() + word.size(), id);
        if (fault != std::errc{} || rest != word.data() + word.size() || id >= all.size()) return nullptr;
        const std::string_view name = word.substr(0, end);
        return display_names_[id] == name || is_marked(display_names_[id], name) ? &all[id] : nullptr;
    }
    /// nullptr if there is no parameter with this name or number; the work has then ended.
    const ano::host::ParameterInfo* parameter(const std::string& word) {
        const auto& all = parameters_->descriptions();
        ano::host::Found found = named(all, word);
        if (found.parameter == nullptr && !found.several)
            for (const ano::host::ParameterInfo& one : all)
                if ((one.type || !one.name.empty()) && std::to_string(one.id) == word) found.parameter = &one;
        if (found.several) finish(ambiguous(word, all));
        else if (found.parameter == nullptr) finish(unknown(word, all));
        return found.parameter;
    }
    WorkEnd unknown(const std::string& word, const std::vector<ano::host::ParameterInfo>& all) const {
        std::vector<std::string> names;
        for (const ano::host::ParameterInfo& one : all)
            if (!one.name.empty()) names.push_back(texts().display_text(one.name));
        const std::string meant = ano::did_you_mean(word, std::vector<std::string_view>{names.begin(), names.end()});
        return work_fault({"parameter_not_found", ano::in_quotes(word) + meant});
    }

    /// A value that is not as long as its type is not shown: its low bytes are not the value, and writing it is refused as well.
    Json row(const ano::host::ParameterInfo& info, const std::optional<ano::host::AnyValue>& value, bool with_value) const {
        const std::string unreadable = value ? ano::host::unreadable_value(parameters_->bytes(info.id), info) : std::string{};
        if (unreadable.empty()) return parameter_json(info, value, with_value, texts());
        Json json = parameter_json(info, std::nullopt, false, texts());
        json["unreadable"] = unreadable;
        return json;
    }

    WorkEnd ambiguous(const std::string& name, const std::vector<ano::host::ParameterInfo>& all) const {
        std::string ids;
        for (const ano::host::ParameterInfo& one : all)
            if (texts().is(one.name, name)) ids += (ids.empty() ? "" : ", ") + std::to_string(one.id);
        return {409, {}, {"ambiguous_parameter", ano::in_quotes(name), ids}, "ambiguous"};
    }

private:
    Parameters* parameters_ = nullptr;
    std::vector<std::string> display_names_;                        // names for clients
    const ano::host::ParameterInfo* display_names_of_ = nullptr;    // the descriptions that they belong to
};

class ReadAll final : public ParameterWork {
public:
    ReadAll(const WorkPlace& place, ParameterOrder order) : ParameterWork{place}, order_{std::move(order)} {}
    void start(TimePoint now) override {
        const auto* const before = order_.known && !order_.values ? known(now) : nullptr;
        if (before == nullptr && order_.words) return read_called(*order_.words, false, now);
        if (before == nullptr) return read(order_.values ? Parameters::Values::all : Parameters::Values::none, now);
        known_ = *before;
        end_ = WorkEnd{};
    }
    std::string message() const override { return "reading parameters"; }
    std::optional<TimePoint> due() const override { return end_ ? std::optional{TimePoint{}} : std::nullopt; }

private:
    void done(const Task& task, TimePoint) override { end_ = end_of(*task.end(), texts()); }
    // Returns the parameters that were received, even if some are missing.
    void failed(const Task& task, TimePoint) override {
        end_ = end_of(*task.end(), texts());
        if (task.end()->ending != Ending::incomplete) return finish(std::move(*end_));
        end_->status = 200;
    }
    void look(TimePoint) override {
        if (end_ && !end()) report();
    }
    const std::vector<ano::host::ParameterInfo>& rows() const { return known_ ? *known_ : parameters().descriptions(); }
    std::optional<ano::host::AnyValue> value(std::uint16_t id) const { return known_ ? std::nullopt : parameters().value(id); }
    // Adds a few rows per call: called again until the work has ended.
    void report() {
        const auto& all = rows();
        const auto& device = place().device;
        if (!text_) {
            Json head{{"device", identity_json(device.address(), device.info(), texts())}};
            if (known_) head["known"] = true;
            text_.emplace(head, "parameters");
            end_of_rows_ = rows_that_came();
        }
        for (std::size_t n = 0; n < RowsText::rows_a_turn && listed_ < end_of_rows_; ++n, ++listed_) {
            ano::host::ParameterInfo row = all[listed_];
            row.id = static_cast<std::uint16_t>(listed_);
            if (!is_wanted(row)) continue;
            text_->add(ParameterWork::row(row, value(row.id), order_.values));
            has_wanted_ = true;
        }
        if (text_->size() > RowsText::max_bytes) return finish(too_many_bytes(device.address()));
        if (listed_ < end_of_rows_) return;
        if (order_.words && !has_wanted_ && end_->fault.empty()) return finish(unknown(order_.words->front(), all));
        Json tail = Json::object();
        if (end_of_rows_ < all.size()) tail["missing_from"] = end_of_rows_;
        if (!end_->fault.empty()) tail["incomplete"] = end_->fault.text();
        finish(text_->ended(std::move(*end_), tail));
    }
    bool is_wanted(const ano::host::ParameterInfo& row) const {
        return !order_.words || (is_called(row, *order_.words) && (row.type || !row.name.empty()));
    }
    // Ends with the last parameter received: a device may report thousands that do not exist.
    std::size_t rows_that_came() const {
        const auto& all = rows();
        const auto came = [&](std::size_t i) {
            return known_ || all[i].type || !all[i].name.empty() || !parameters().bytes(static_cast<std::uint16_t>(i)).empty();
        };
        std::size_t end = all.size();
        while (end > 0 && !came(end - 1)) --end;
        return end;
    }

    ParameterOrder order_;
    std::optional<std::vector<ano::host::ParameterInfo>> known_;    // read before
    std::optional<WorkEnd> end_;
    std::optional<RowsText> text_;
    std::size_t listed_ = 0, end_of_rows_ = 0;
    bool has_wanted_ = false;
};

class ReadOne final : public ParameterWork {
public:
    ReadOne(const WorkPlace& place, std::string name) : ParameterWork{place}, name_{std::move(name)} {}
    void start(TimePoint now) override { read_called({name_}, false, now); }
    std::string message() const override { return "reading " + name_; }

private:
    void done(const Task& task, TimePoint) override {
        const ano::host::ParameterInfo* const info = parameter(name_);
        if (info == nullptr) return;
        finish(with_result(end_of(*task.end(), texts()), row(*info, parameters().value(info->id), true)));
    }

    std::string name_;
};

class WriteOne final : public ParameterWork {
public:
    WriteOne(const WorkPlace& place, std::string name, const Json& value, ano::host::WriteLimits limits)
        : ParameterWork{place}, name_{std::move(name)}, json_{value.dump()}, limits_{limits} {}
    void start(TimePoint now) override { read_called({name_}, true, now); }
    std::string message() const override { return "writing " + name_; }

private:
    void done(const Task& task, TimePoint now) override {
        if (write_ != nullptr) return report(*task.end());
        const ano::host::ParameterInfo* const info = parameter(name_);
        if (info == nullptr) return;
        const auto given = value_in(Json::parse(json_), info->type);
        if (!given) return finish(work_fault({"value_needed"}));
        const auto value = texts().wire(*given);
        if (!value) return finish(work_fault({"text_unfit", name_, texts().misfit()}));
        limits_.max_bytes = place().net.device_limits(place().device.address()).text.max_bytes;
        auto write = std::make_unique<ParameterWrite>(place().device, *info, *value, limits_);
        write->set_before(parameters().bytes(info->id), parameters().doubts());
        write_ = &next(std::move(write));
        write_->start(now);
    }
    void report(const ano::host::End& end) {
        const ano::host::ParameterInfo& info = write_->info();
        Json result{{"id", info.id}, {"name", texts().display_text(info.name)}, {"type", name_of(*info.type)}};
        if (const auto before = write_->before()) result["was"] = value_json(*before, info.type, texts());
        result["written"] = value_json(write_->written(), info.type, texts());
        result["stored"] = value_json(*write_->stored(), info.type, texts());
        result["clamped"] = write_->is_clamped();
        result["acknowledged"] = write_->was_acknowledged();
        if (end.evidence.by_port || !end.evidence.unfit.empty()) result["note"] = end.fault.text();
        finish(with_result(end_of(end, texts()), result));
    }

    std::string name_, json_;
    ano::host::WriteLimits limits_;
    ParameterWrite* write_ = nullptr;
};

// In the order of ParameterApply::State.
constexpr std::string_view apply_states[] = {"waiting", "unchanged", "written", "clamped", "failed", "undone", "not_undone"};
constexpr std::string_view dry_states[] = {"differs", "unchanged"};

class Apply final : public ParameterWork {
public:
    Apply(const WorkPlace& place, const Json& values, ApplyOrder order)
        : ParameterWork{place}, wanted_(values), order_{order} {}    // braces would make a list of it
    // The types must be known before. Whether the device is still the same is checked while the values are read.
    void start(TimePoint now) override {
        const auto* const before = known(now);
        if (before != nullptr && has_all(*before)) return apply(*before, now);
        read(Parameters::Values::none, now);
    }
    std::string message() const override {
        if (apply_ != nullptr && apply_->is_undoing()) return "undoing the changes";
        return order_.dry_run ? "comparing parameters" : "writing parameters";
    }

private:
    void done(const Task& task, TimePoint now) override {
        if (apply_ != nullptr) {
            forget_kept();
            WorkEnd end = end_of(*task.end(), texts());
            Json result = rows();
            if (!end.fault.empty()) result["note"] = end.fault.text();
            return finish(with_result(std::move(end), result));
        }
        apply(parameters().descriptions(), now);
    }
    bool has_all(const std::vector<ano::host::ParameterInfo>& descriptions) {
        for (const auto& [name, json] : wanted_.items())
            if (named(descriptions, name).parameter == nullptr) return false;
        return true;
    }
    void apply(const std::vector<ano::host::ParameterInfo>& descriptions, TimePoint now) {
        std::vector<std::pair<std::string, ano::host::AnyValue>> values;
        std::vector<std::optional<std::uint16_t>> ids;
        std::size_t strangers = 0;
        for (const auto& [name, json] : wanted_.items()) {
            const auto found = named(descriptions, name);
            if (found.parameter == nullptr) ++strangers;
            if (found.several) return finish(ambiguous(name, descriptions));
            const auto* info = found.parameter;
            given_.push_back({name, json, info != nullptr ? info->type : std::nullopt, info != nullptr, {}});
            const auto value = value_in(json, given_.back().type);
            if (!value) return finish(work_fault({"number_or_text_needed", ano::in_quotes(name)}));
            const auto wire = texts().wire(*value);
            if (!wire && !order_.dry_run) return finish(work_fault({"text_unfit", name, texts().misfit()}));
            if (!wire) given_.back().unwritable = json.get<std::string>();
            const bool is_unclear = info != nullptr &&
                                    (info->name.empty() ||
                                     std::any_of(descriptions.begin(), descriptions.end(),
                                                 [&](const auto& one) { return &one != info && one.name == info->name; }));
            ids.push_back(is_unclear ? std::optional{static_cast<std::uint16_t>(info - descriptions.data())} : std::nullopt);
            values.emplace_back(info != nullptr ? info->name : texts().bytes(name).value_or(name), wire.value_or(*value));
        }
        if (strangers > max_strangers) return finish(no_file_of_it(strangers));
        ano::host::ApplyOptions options{.rollback = order_.rollback,
                                        .dry_run = order_.dry_run,
                                        .also_the_same = order_.also_the_same,
                                        .goes_on = order_.goes_on && !order_.rollback,
                                        .text = place().net.device_limits(place().device.address()).text};
        if (std::any_of(ids.begin(), ids.end(), [](const auto& id) { return id.has_value(); })) options.ids = std::move(ids);
        options.text.longer = order_.longer;
        options.text.beyond_range = order_.force;
        options.same_text = [texts = texts()](const std::string& one, const std::string& other) {
            return texts.display_text(one) == texts.display_text(other);
        };
        apply_ = &next(std::make_unique<ParameterApply>(place().device, &place().cache, values, options));
        apply_->start(now);
    }
    // Too many unknown names to list each.
    WorkEnd no_file_of_it(std::size_t strangers) const {
        constexpr std::size_t max_names = 5;
        std::string names;
        std::size_t listed = 0;
        for (const Given& given : given_)
            if (!given.is_known && listed < max_names) names += (listed++ == 0 ? "" : ", ") + ano::in_quotes(given.name);
        return work_fault({"unknown_parameters", names, strangers - listed});
    }
    // Also reports what is half done.
    void failed(const Task& task, TimePoint) override {
        WorkEnd end = end_of(*task.end(), texts());
        if (apply_ == nullptr) return finish(std::move(end));
        forget_kept();
        finish(with_result(std::move(end), rows()));
    }
    // Old values stored by a calibration are no longer needed if the device has them.
    void forget_kept() {
        using State = ParameterApply::State;
        if (order_.dry_run) return;
        Json has = Json::object();
        Json::object_t::Container& members = has.get_ref<Json::object_t&>();
        for (std::size_t i = 0; i < given_.size(); ++i)
            if (const State state = apply_->rows()[i].state; state == State::same || state == State::written)
                members.emplace_back(given_[i].name, given_[i].wanted);
        forget_written(place(), has);
    }
    Json rows() const {
        Json rows = Json::array();
        std::size_t i = 0;
        for (const ParameterApply::Row& row : apply_->rows()) {
            const Given& given = given_[i++];
            const auto type = given.type;
            const auto state = static_cast<std::size_t>(row.state);
            Json json{{"name", given.is_known ? texts().display_text(row.name) : given.name}};
            if (row.before) json["was"] = value_json(*row.before, type, texts());
            json["written"] = given.unwritable ? Json(*given.unwritable) : value_json(row.wanted, type, texts());
            if (row.stored && !order_.dry_run) json["stored"] = value_json(*row.stored, type, texts());
            json["clamped"] = row.state == ParameterApply::State::clamped;
            json["state"] = order_.dry_run && state < std::size(dry_states) ? dry_states[state] : apply_states[state];
            if (!row.fault.empty())
                json["what"] = given.is_known ? texts().display_fault(row.fault).text() : "unknown parameter " + given.name;
            if (given.unwritable) {
                json["state"] = dry_states[0];
                json["encodable"] = false;
                json["what"] = texts().misfit().text();
            }
            using State = ParameterApply::State;
            if ((row.state == State::written || row.state == State::clamped) && !row.acknowledged) json["acknowledged"] = false;
            rows.push_back(std::move(json));
        }
        Json result{{"dry_run", order_.dry_run}, {"parameters", std::move(rows)}};
        if (apply_->is_of_another()) result["another_device"] = true;
        return result;
    }

    static constexpr std::size_t max_strangers = 500;    // unknown names: up to this number, each has a row in the answer

    Json wanted_;
    ApplyOrder order_;
    struct Given {
        std::string name;    // as the client sent it
        Json wanted;
        std::optional<ano::Type> type;
        bool is_known;
        std::optional<std::string> unwritable;    // of a dry run: a text that can't be written in the encoding of the device
    };
    std::vector<Given> given_;    // in the order of the rows
    ParameterApply* apply_ = nullptr;
};

class Act final : public TaskWork {
public:
    Act(const WorkPlace& place, ano::host::Action action, std::string name)
        : TaskWork{place}, action_{action}, name_{std::move(name)} {}
    void start(TimePoint now) override {
        auto task = std::make_unique<ano::host::ParameterAction>(place().device, action_);
        task->mean_present_device();
        next(std::move(task)).start(now);
    }
    std::string message() const override { return name_; }

private:
    void done(const Task& task, TimePoint) override {
        Json result{{"action", name_}, {"done", true}};
        if (task.end()->evidence.by_port) result["note"] = task.end()->fault.text();
        finish(with_result(end_of(*task.end(), texts()), result));
    }

    ano::host::Action action_;
    std::string name_;
};

}    // namespace

std::unique_ptr<Work> read_parameters(const WorkPlace& place, ParameterOrder order) {
    return std::make_unique<ReadAll>(place, std::move(order));
}

std::unique_ptr<Work> read_parameter(const WorkPlace& place, std::string name) {
    return std::make_unique<ReadOne>(place, std::move(name));
}

std::unique_ptr<Work> write_parameter(const WorkPlace& place, std::string name, const Json& value,
                                      ano::host::WriteLimits limits) {
    return std::make_unique<WriteOne>(place, std::move(name), value, limits);
}

std::unique_ptr<Work> apply_parameters(const WorkPlace& place, const Json& values, ApplyOrder order) {
    return std::make_unique<Apply>(place, values, order);
}

std::unique_ptr<Work> act(const WorkPlace& place, ano::host::Action action, std::string name) {
    return std::make_unique<Act>(place, action, std::move(name));
}

}    // namespace anogate
