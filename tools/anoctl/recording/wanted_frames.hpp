// Filters the frames of a link of this process. (A gateway filters its frames itself.)
#pragma once
#include <ano/frame.hpp>

#include <bitset>
#include <string>
#include <vector>

namespace anoctl {

class WantedFrames {
public:
    /// The words of --id, --from and --to; empty: all. Throws UsageError.
    WantedFrames(const std::vector<std::string>& ids, const std::vector<std::string>& from, const std::vector<std::string>& to);

    bool takes(ano::FrameView frame) const { return ids_[frame.id()] && from_[frame.source()] && to_[frame.destination()]; }

private:
    std::bitset<256> ids_, from_, to_;
};

}    // namespace anoctl
