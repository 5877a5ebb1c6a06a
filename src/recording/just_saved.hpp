// The recordings that were saved a short while ago and are not deleted, even if `keep` requires it. Thread-safe: one thread
// saves,
// another one deletes.
#pragma once
#include <ano/time.hpp>

#include <algorithm>
#include <map>
#include <mutex>
#include <string>

namespace anogate {

/// Any thread may call it.
class JustSaved {
public:
    /// If the name exists, the later time counts. To be called while the file is still locked, so that a thread that finds it
    /// unlocked also finds it here.
    void add(const std::string& name, ano::TimePoint until) {
        const std::lock_guard lock{mutex_};
        ano::TimePoint& its = until_[name];
        its = std::max(its, until);
    }
    bool contains(const std::string& name, ano::TimePoint now) {
        const std::lock_guard lock{mutex_};
        std::erase_if(until_, [now](const auto& saved) { return saved.second <= now; });
        return until_.contains(name);
    }

private:
    std::mutex mutex_;
    std::map<std::string, ano::TimePoint> until_;
};

}    // namespace anogate
