// Writes several parameters by name: only those that differ, each read back; optionally all are undone if one fails.
//
// Flow:    ParameterApply apply{device, &cache, {{"PID_P", 4.5}, {"NAME", std::string{"mine"}}}, {.rollback = true}};
//          apply.start(now);                   // then drive the device until apply.end()
//          for (const auto& row : apply.rows()) use(row.name, row.state);
#pragma once
#include <host/parameter_write.hpp>
#include <host/parameters.hpp>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace ano::host {

struct ApplyOptions {
    bool rollback = false;
    bool dry_run = false;          // only reports the values that would be written
    bool also_the_same = false;    // also writes values that do not differ
    bool goes_on = false;          // continues after a value that the device refuses; not with `rollback`
    WriteLimits text{};
    /// For a row whose name is empty or belongs to several parameters: the number of the intended parameter, which must have this
    /// name. May be shorter than the rows.
    std::vector<std::optional<std::uint16_t>> ids{};
    /// Whether two texts that differ in bytes are the same to the user; may be empty.
    std::function<bool(const std::string&, const std::string&)> same_text{};
};

/// Nothing is written before every name is found, every value fits its type and every old value is read; otherwise all wrong rows
/// are `failed`. Writes go one by one in the given order. The first failure ends the task; with `goes_on`, only a device that no
/// longer answers or became another one ends it.
///
/// A device that restarts loses values that were not saved, and a short restart shows no sign. So all written values are read
/// once more at the end, if there are several or the device restarted (after a restart also those that did not differ). A lost
/// value is written again once, then it is `failed`. The same applies after undoing: every old value must be restored. Once the
/// device became another one, nothing is written, and so nothing is undone.
class ParameterApply final : public Task {
public:
    enum class State : std::uint8_t {
        waiting,
        same,          // not written: the device has this value
        written,       // written and read back
        clamped,       // stored as another value
        failed,        // see `fault`
        undone,        // the old value is restored and was read back
        not_undone,    // it may be written, and the old value could not be restored
    };
    struct Row {
        std::string name;
        AnyValue wanted;
        State state = State::waiting;
        Fault fault{};                        // why it failed
        std::optional<AnyValue> before{};     // as read first
        std::optional<AnyValue> stored{};     // as read last
        bool acknowledged = false;            // for `written` and `clamped`; if false, only reading back showed it
        bool wrongly_acknowledged = false;    // with wrong check bytes; `fault` says so
    };

    ParameterApply(Device& device, DescriptionCache* cache, const std::vector<std::pair<std::string, AnyValue>>& values,
                   ApplyOptions options = {});

    void start(TimePoint now);
    /// In parameters.
    Progress progress() const noexcept override { return {at_, rows_.size()}; }
    /// With `rollback`, written values are undone first.
    void cancel(TimePoint now) override;
    void ended(const Ended&, TimePoint) override {}    // only its sub-tasks send requests

    const std::vector<Row>& rows() const noexcept { return rows_; }
    /// One failed or the task was cancelled, and the old values are being restored.
    bool is_undoing() const noexcept { return undoing_; }

private:
    void described(TimePoint now);
    bool check(TimePoint now);
    Found found(std::size_t row) const;
    bool is_same(const AnyValue& wanted, const AnyValue& has, const ParameterInfo& info) const;
    Fault fault_of(const Row& row, const Found& found) const;
    using SeveralId = FaultId<std::ptrdiff_t, std::size_t, Fault>;
    End failure(SeveralId if_several) const;
    bool is_restarted() const noexcept;
    Fault restart() const;
    void next(TimePoint now);
    void row_ended(TimePoint now);
    void fail(const End& end, TimePoint now);
    void read_again(void (ParameterApply::*then)(TimePoint), TimePoint now);
    bool is_read_again(const Row& row) const noexcept;
    bool has(std::size_t row, const std::optional<AnyValue>& value) const;
    void check_written(TimePoint now);
    void written_is_read(TimePoint now);
    void finish_written(TimePoint now);
    void undo_next(TimePoint now);
    void undo_no_more() noexcept;
    void finish_undone(TimePoint now);
    void undone(TimePoint now);
    void undone_is_read(TimePoint now);
    void write(std::size_t row, const AnyValue& value, WriteLimits limits, void (ParameterApply::*then)(TimePoint),
               TimePoint now);

    ApplyOptions options_;
    std::vector<Row> rows_;
    std::vector<ParameterInfo> infos_;    // of rows_
    DescriptionCache own_cache_;          // used if the caller passes none
    DescriptionCache* cache_;
    Parameters parameters_;
    std::unique_ptr<Parameters> again_;         // at the end
    std::unique_ptr<Parameters> last_again_;    // as last_
    std::unique_ptr<ParameterWrite> write_;
    std::unique_ptr<ParameterWrite> last_;    // the previous task, which may not be destroyed in its own on_end() call
    std::size_t at_ = 0;
    std::uint32_t presence_ = 0, announcements_ = 0;    // of the device when the first value was written
    std::uint32_t compared_ = 0;    // Device::doubts() when a description was last read or compared, if there was no other sign
    std::uint32_t signs_ = 0;       // Device::signs() when the first value was written
    std::vector<std::size_t> touched_;    // rows whose old value is to be restored if one fails
    std::vector<bool> repeated_;          // of rows_: written once more, since the value was lost
    std::size_t lost_ = 0;
    bool undoing_ = false;
    std::vector<bool> undone_again_;    // of rows_
    std::optional<End> why_;            // the first failure; the end of the task after undoing
};

}    // namespace ano::host
