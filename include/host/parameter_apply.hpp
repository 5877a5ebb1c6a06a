// Writes several parameters by name: only what differs, each read back, and all undone when one fails, where that is wanted.
//
// Flow:    ParameterApply apply{device, &cache, {{"PID_P", 4.5}, {"NAME", std::string{"mine"}}}, {.rollback = true}};
//          apply.start(now);                   // then drive the device until apply.end()
//          for (const auto& row : apply.rows()) use(row.name, row.state);
#pragma once
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ano::host {

struct ApplyOptions {
    bool rollback = false;
    bool dry_run = false;          // says what would be written
    bool also_the_same = false;    // what does not differ is written as well
    bool goes_on = false;          // behind one that the device refuses; not with `rollback`
    TextLimits text{};
};

/// Nothing is written before every name is found, every value fits its type and every old value is read: where that is not so, every one
/// that is wrong has failed. Writes go one by one in the order given. The first that fails ends it; where it goes on, only a device that
/// no longer answers, or became another one.
class ParameterApply final : public Task {
public:
    enum class State : std::uint8_t {
        waiting,
        same,          // not written: the device has this value
        written,       // and read back
        clamped,       // stored as another value
        failed,        // see `what`
        undone,        // the old value is back, and was read back
        not_undone,    // it may be written, and the old value could not be brought back
    };
    struct Row {
        std::string name;
        AnyValue wanted;
        State state = State::waiting;
        std::string what{};                  // of one that failed: a clause
        std::optional<AnyValue> before{};    // as read first
        std::optional<AnyValue> stored{};    // as read last
    };

    ParameterApply(Device& device, DescriptionCache* cache, const std::vector<std::pair<std::string, AnyValue>>& values,
                   ApplyOptions options = {});

    void start(TimePoint now);
    /// In parameters: where it is among them.
    Progress progress() const noexcept override { return {at_, rows_.size()}; }
    /// With `rollback` what was written is undone first.
    void cancel(TimePoint now) override;
    void ended(const Ended&, TimePoint) override {}    // its parts ask

    const std::vector<Row>& rows() const noexcept { return rows_; }
    /// One failed or it was cancelled, and what was written is brought back.
    bool is_undoing() const noexcept { return undoing_; }

private:
    void described(TimePoint now);
    bool check(TimePoint now);
    std::string fault_of(const Row& row, const Found& found) const;
    End failure(const char* deed) const;
    void next(TimePoint now);
    void row_ended(TimePoint now);
    void fail(const End& end, TimePoint now);
    void undo_next(TimePoint now);
    void undone(TimePoint now);
    void write(std::size_t row, const AnyValue& value, TextLimits limits, void (ParameterApply::*then)(TimePoint), TimePoint now);

    ApplyOptions options_;
    std::vector<Row> rows_;
    std::vector<ParameterInfo> infos_;    // of rows_
    Parameters parameters_;
    std::unique_ptr<ParameterWrite> write_;
    std::unique_ptr<ParameterWrite> last_;    // a task is not destroyed while it tells its end
    std::size_t at_ = 0;
    std::vector<std::size_t> touched_;    // rows whose old value is to be brought back if one fails
    bool undoing_ = false;
    std::optional<End> why_;    // of the first that failed; after undoing it ends so
};

}    // namespace ano::host
