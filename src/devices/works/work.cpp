#include <devices/works/work.hpp>
#include <http/response.hpp>

#include <utility>

namespace anogate {
namespace {

using ano::host::Ending;

struct Meaning {
    unsigned status;
    const char* what;
};

// Indexed by Ending.
constexpr Meaning meanings[] = {
    {200, ""},               // done
    {504, "timeout"},        // timeout
    {502, "timeout"},        // incomplete
    {504, "unknown"},        // unknown
    {502, "refused"},        // refused
    {502, "refused"},        // failed
    {422, "invalid"},        // invalid
    {501, "unsupported"},    // unsupported
    {409, "refused"},        // cancelled
};
static_assert(std::size(meanings) == ano::host::ending_names.size());

}    // namespace

WorkEnd end_of(const ano::host::End& end, const DeviceTexts& texts) {
    const Meaning& meaning = meanings[static_cast<std::size_t>(end.ending)];
    return {meaning.status, {}, texts.display_fault(end.fault), meaning.what, end.evidence, end.ending == Ending::cancelled};
}

WorkEnd work_fault(ano::Fault fault) {
    const unsigned status = fault.status();
    return {status, {}, std::move(fault), std::string{http::what_of(status)}, {}, false};
}

void TaskWork::run(ano::TimePoint now) {
    while (!end() && task_ && task_->end()) {
        const ano::host::Task* const before = handled_ = task_.get();
        if (before->end()->ending == Ending::done) done(*before, now);
        else failed(*before, now);
        if (task_.get() == before) break;
    }
    look(now);
}

void TaskWork::cancel(ano::TimePoint now) {
    if (task_) task_->cancel(now);
    else finish({409, {}, {"cancelled"}, "refused", {}, true});
}

ano::host::Progress TaskWork::progress() const { return task_ ? task_->progress() : ano::host::Progress{}; }

}    // namespace anogate
