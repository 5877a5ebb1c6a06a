#include <ano_json/text.hpp>
#include <devices/calibration_work.hpp>
#include <devices/device_json.hpp>
#include <devices/parameter_works.hpp>
#include <devices/rows_text.hpp>
#include <host/parameter_apply.hpp>
#include <host/parameters.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
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

WorkEnd with_result(WorkEnd end, const Json& result) {
    end.result = result.dump(-1, ' ', false, Json::error_handler_t::replace);
    return end;
}

// Reads the descriptions of all parameters, then goes on.
class ParameterWork : public TaskWork {
public:
    using TaskWork::TaskWork;

protected:
    void read(Parameters::Values values, TimePoint now) {
        parameters_ = &next(std::make_unique<Parameters>(place().device, &place().cache));
        parameters_->read(values, now);
    }
    void read(std::vector<std::string> names, TimePoint now) {
        parameters_ = &next(std::make_unique<Parameters>(place().device, &place().cache));
        parameters_->read_named(std::move(names), now);
    }
    const Parameters& parameters() const { return *parameters_; }
    /// nullptr, and the work has ended, if there is no such parameter.
    const ano::host::ParameterInfo* parameter(const std::string& word) {
        const ano::host::Found found = parameter_called(*parameters_, word);
        if (found.several) finish(ambiguous(word));
        else if (found.parameter == nullptr) finish(work_fault(404, "no parameter is called " + ano::in_quotes(word)));
        return found.parameter;
    }

    WorkEnd ambiguous(const std::string& name) const {
        std::string ids;
        for (const ano::host::ParameterInfo& one : parameters_->descriptions())
            if (one.name == name) ids += (ids.empty() ? "" : ", ") + std::to_string(one.id);
        return {
            409, {}, "several parameters are called " + ano::in_quotes(name) + ": say which by its number, " + ids, "ambiguous"};
    }

private:
    Parameters* parameters_ = nullptr;
};

class ReadAll final : public ParameterWork {
public:
    ReadAll(const WorkPlace& place, bool values) : ParameterWork{place}, values_{values} {}
    ReadAll(const WorkPlace& place, std::vector<std::string> names)
        : ParameterWork{place}, values_{true}, names_{std::move(names)} {}
    void start(TimePoint now) override {
        if (names_) read(*names_, now);
        else read(values_ ? Parameters::Values::all : Parameters::Values::none, now);
    }
    std::string message() const override { return "reading parameters"; }
    std::optional<TimePoint> due() const override { return text_ ? std::optional{TimePoint{}} : std::nullopt; }

private:
    void done(const Task& task, TimePoint) override { tell(end_of(*task.end())); }
    // Returns the parameters that came even if some did not.
    void failed(const Task& task, TimePoint) override {
        WorkEnd end = end_of(*task.end());
        if (task.end()->ending != Ending::incomplete) return finish(std::move(end));
        end.status = 200;
        tell(std::move(end));
    }
    // Adds a few rows at a time: it is called again until the work has ended.
    void tell(WorkEnd end) {
        const auto& all = parameters().descriptions();
        const auto& device = place().device;
        if (!text_) {
            text_.emplace(Json{{"device", identity_json(device.address(), device.info())}}, "parameters");
            end_of_rows_ = rows_that_came();
        }
        for (std::size_t n = 0; n < RowsText::rows_a_turn && told_ < end_of_rows_; ++n, ++told_) {
            ano::host::ParameterInfo row = all[told_];
            row.id = static_cast<std::uint16_t>(told_);
            if (is_wanted(row.name)) text_->add(parameter_json(row, parameters().value(row.id), values_));
        }
        if (text_->size() > RowsText::max_bytes) return finish(too_many_bytes(device.address()));
        if (told_ < end_of_rows_) return;
        Json tail = Json::object();
        if (end_of_rows_ < all.size()) tail["missing_from"] = end_of_rows_;
        if (!end.error.empty()) tail["incomplete"] = end.error;
        finish(text_->ended(std::move(end), tail));
    }
    bool is_wanted(const std::string& name) const {
        return !names_ || std::find(names_->begin(), names_->end(), name) != names_->end();
    }
    // Ends with the last parameter that came: a device may claim thousands that never do.
    std::size_t rows_that_came() const {
        const auto& all = parameters().descriptions();
        const auto came = [&](std::size_t i) {
            return all[i].type || !all[i].name.empty() || !parameters().bytes(static_cast<std::uint16_t>(i)).empty();
        };
        std::size_t end = all.size();
        while (end > 0 && !came(end - 1)) --end;
        return end;
    }

    std::optional<RowsText> text_;
    std::size_t told_ = 0, end_of_rows_ = 0;
    bool values_ = false;
    std::optional<std::vector<std::string>> names_;    // of the wanted parameters; std::nullopt: all
};

class ReadOne final : public ParameterWork {
public:
    ReadOne(const WorkPlace& place, std::string name) : ParameterWork{place}, name_{std::move(name)} {}
    void start(TimePoint now) override { read(Parameters::Values::none, now); }
    std::string message() const override { return "reading " + name_; }

private:
    void done(const Task& task, TimePoint now) override {
        const ano::host::ParameterInfo* const info = parameter(name_);
        if (info == nullptr) return;
        if (!std::exchange(is_described_, true)) {
            auto one = std::make_unique<Parameters>(place().device, &place().cache);
            one_ = one.get();
            id_ = info->id;
            next(std::move(one)).read_numbered({id_}, now);
            return;
        }
        if (id_ >= one_->descriptions().size())
            return finish(work_fault(502, "the device changed while it was asked: it no longer has " + name_));
        finish(with_result(end_of(*task.end()), parameter_json(one_->descriptions()[id_], one_->value(id_), true)));
    }

    std::string name_;
    bool is_described_ = false;
    std::uint16_t id_ = 0;
    Parameters* one_ = nullptr;
};

class WriteOne final : public ParameterWork {
public:
    WriteOne(const WorkPlace& place, std::string name, const Json& value, bool longer)
        : ParameterWork{place}, name_{std::move(name)}, json_{value.dump()}, longer_{longer} {}
    void start(TimePoint now) override { read(Parameters::Values::none, now); }
    std::string message() const override { return "writing " + name_; }

private:
    void done(const Task& task, TimePoint now) override {
        if (write_ != nullptr) return tell(*task.end());
        const ano::host::ParameterInfo* const info = parameter(name_);
        if (info == nullptr) return;
        const auto value = value_in(Json::parse(json_), info->type);
        if (!value) return finish(work_fault(422, "the value must be a number or a text"));
        auto limits = place().net.manners(place().device.address()).text;
        limits.longer = longer_;
        write_ = &next(std::make_unique<ParameterWrite>(place().device, *info, *value, limits));
        write_->start(now);
    }
    void tell(const ano::host::End& end) {
        const ano::host::ParameterInfo& info = write_->info();
        Json result{{"id", info.id}, {"name", info.name}, {"type", name_of(*info.type)}};
        if (const auto before = write_->before()) result["was"] = value_json(*before, info.type);
        result["written"] = value_json(write_->written(), info.type);
        result["stored"] = value_json(*write_->stored(), info.type);
        result["clamped"] = write_->is_clamped();
        result["acknowledged"] = write_->was_acknowledged();
        finish(with_result(end_of(end), result));
    }

    std::string name_, json_;
    bool longer_;
    ParameterWrite* write_ = nullptr;
};

// In the order of ParameterApply::State.
constexpr std::string_view apply_states[] = {"waiting", "unchanged", "written", "clamped", "failed", "undone", "not_undone"};
constexpr std::string_view dry_states[] = {"differs", "unchanged"};

class Apply final : public ParameterWork {
public:
    Apply(const WorkPlace& place, const Json& values, ApplyOrder order)
        : ParameterWork{place}, json_{values.dump()}, order_{order} {}
    void start(TimePoint now) override { read(Parameters::Values::none, now); }
    std::string message() const override {
        if (apply_ != nullptr && apply_->is_undoing()) return "undoing what was written";
        return order_.dry_run ? "comparing parameters" : "writing parameters";
    }

private:
    void done(const Task& task, TimePoint now) override {
        if (apply_ != nullptr) {
            forget_kept();
            return finish(with_result(end_of(*task.end()), rows()));
        }
        std::vector<std::pair<std::string, ano::host::AnyValue>> values;
        const Json given = Json::parse(json_);
        for (const auto& [name, json] : given.items()) {
            const auto found = parameters().find(name);
            if (found.several) return finish(ambiguous(name));
            const auto* info = found.parameter;
            types_.push_back(info != nullptr ? info->type : std::nullopt);
            const auto value = value_in(json, types_.back());
            if (!value) return finish(work_fault(422, ano::in_quotes(name) + " must be a number or a text"));
            values.emplace_back(name, *value);
        }
        ano::host::ApplyOptions options{.rollback = order_.rollback,
                                        .dry_run = order_.dry_run,
                                        .goes_on = !order_.rollback,
                                        .text = place().net.manners(place().device.address()).text};
        options.text.longer = order_.longer;
        apply_ = &next(std::make_unique<ParameterApply>(place().device, &place().cache, values, options));
        apply_->start(now);
    }
    // Reports what is half done as well.
    void failed(const Task& task, TimePoint) override {
        WorkEnd end = end_of(*task.end());
        if (apply_ == nullptr) return finish(std::move(end));
        forget_kept();
        finish(with_result(std::move(end), rows()));
    }
    // Old values kept by a calibration are no longer needed if the device has them.
    void forget_kept() {
        using State = ParameterApply::State;
        if (order_.dry_run) return;
        Json has = Json::parse(json_);
        for (const ParameterApply::Row& row : apply_->rows())
            if (row.state != State::same && row.state != State::written && row.state != State::clamped) has.erase(row.name);
        forget_written(place(), has);
    }
    Json rows() const {
        Json rows = Json::array();
        std::size_t i = 0;
        for (const ParameterApply::Row& row : apply_->rows()) {
            const auto type = types_[i++];
            const auto state = static_cast<std::size_t>(row.state);
            Json json{{"name", row.name}};
            if (row.before) json["was"] = value_json(*row.before, type);
            json["written"] = value_json(row.wanted, type);
            if (row.stored && !order_.dry_run) json["stored"] = value_json(*row.stored, type);
            json["clamped"] = row.state == ParameterApply::State::clamped;
            json["state"] = order_.dry_run && state < std::size(dry_states) ? dry_states[state] : apply_states[state];
            if (!row.what.empty()) json["what"] = row.what;
            rows.push_back(std::move(json));
        }
        return {{"dry_run", order_.dry_run}, {"parameters", std::move(rows)}};
    }

    std::string json_;
    ApplyOrder order_;
    std::vector<std::optional<ano::Type>> types_;    // of the values
    ParameterApply* apply_ = nullptr;
};

class Act final : public TaskWork {
public:
    Act(const WorkPlace& place, ano::host::Action action, std::string name)
        : TaskWork{place}, action_{action}, name_{std::move(name)} {}
    void start(TimePoint now) override { next(std::make_unique<ano::host::ParameterAction>(place().device, action_)).start(now); }
    std::string message() const override { return name_; }

private:
    void done(const Task& task, TimePoint) override {
        finish(with_result(end_of(*task.end()), {{"action", name_}, {"done", true}}));
    }

    ano::host::Action action_;
    std::string name_;
};

}    // namespace

std::unique_ptr<Work> read_parameters(const WorkPlace& place, bool values) { return std::make_unique<ReadAll>(place, values); }

std::unique_ptr<Work> read_parameters(const WorkPlace& place, std::vector<std::string> names) {
    return std::make_unique<ReadAll>(place, std::move(names));
}

std::unique_ptr<Work> read_parameter(const WorkPlace& place, std::string name) {
    return std::make_unique<ReadOne>(place, std::move(name));
}

std::unique_ptr<Work> write_parameter(const WorkPlace& place, std::string name, const Json& value, bool longer) {
    return std::make_unique<WriteOne>(place, std::move(name), value, longer);
}

std::unique_ptr<Work> apply_parameters(const WorkPlace& place, const Json& values, ApplyOrder order) {
    return std::make_unique<Apply>(place, values, order);
}

std::unique_ptr<Work> act(const WorkPlace& place, ano::host::Action action, std::string name) {
    return std::make_unique<Act>(place, action, std::move(name));
}

}    // namespace anogate
