// A running recording, as Recordings stores it.
#pragma once
#include <recording/recordings.hpp>

#include <nlohmann/json_fwd.hpp>

namespace anogate {

struct Recordings::Running {
    AskedRecording asked;
    bool is_configured = false;
    std::uint64_t began_ns = 0;    // since 1970
    TimePoint began_at{};
    std::unique_ptr<Recorder> recorder{};
    std::uint64_t logged_files = 0;
    TimePoint file_began_at{};          // the current file
    std::string_view logged_fault{};    // the id of the last fault that was logged
    bool is_ending = false;
    std::vector<std::function<void(http::Response)>> begun{}, ended{};    // called at its begin, at its end
};

/// The name of the current file; empty: there is none yet.
std::string file_name_of(const Recordings::Running& running);

std::chrono::seconds since_1970();

http::Response json_answer(nlohmann::ordered_json json);

}    // namespace anogate
