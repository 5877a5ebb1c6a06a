#include <ano_json/json_line.hpp>
#include <devices/job_answers.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view lines = "application/x-ndjson";

http::Response json_answer(unsigned status, const Json& json) {
    http::Response response;
    response.status = status;
    response.body = ano::json_line(json);
    return response;
}

// What came of a job, without the job.
http::Response end_answer(const Job& job) {
    const Json all = job_json(job);
    if (job.end->status < 300) return json_answer(job.end->status, all.value("result", Json{}));
    Json json{{"error", job.end->error}, {"what", job.end->what}, {"job", job.id}};
    if (all.contains("result")) json["result"] = all["result"];
    json["evidence"] = all["evidence"];
    return json_answer(job.end->status, json);
}

/// Who waits for a job; he may want it to end when he goes.
class WaitingClient {
public:
    WaitingClient(DeviceService& service, std::shared_ptr<Job> job, bool ends_with_him)
        : service_{service}, job_{std::move(job)}, ends_with_him_{ends_with_him}, place_{service.waiting_client()} {
        if (ends_with_him_) ++job_->needed_by;
    }
    ~WaitingClient() {
        if (ends_with_him_) service_.left(*job_);
    }
    WaitingClient(const WaitingClient&) = delete;
    WaitingClient& operator=(const WaitingClient&) = delete;

private:
    DeviceService& service_;
    std::shared_ptr<Job> job_;
    bool ends_with_him_;
    std::shared_ptr<void> place_;
};

std::shared_ptr<WaitingClient> waiting_client(DeviceService& service, const std::shared_ptr<Job>& job,
                                              const http::Request& request) {
    return std::make_shared<WaitingClient>(service, job, request.query_value("while_connected").has_value());
}

// A line for each change; what changed while its client took nothing is one.
class JobLines final : public http::Producer {
public:
    JobLines(std::shared_ptr<Job> job, std::shared_ptr<WaitingClient> client) : job_{std::move(job)}, client_{std::move(client)} {
        job_->on_change.push_back(&wake_);
    }
    ~JobLines() override {
        auto& all = job_->on_change;
        all.erase(std::remove(all.begin(), all.end(), &wake_), all.end());
    }

    void start(std::function<void()> wake) override { wake_ = std::move(wake); }
    Next next(std::string& into) override {
        if (told_ != job_->version) {
            told_ = job_->version;
            into += ano::json_line(job_json(*job_));
        }
        return job_->is_over() ? Next::end : Next::later;
    }

private:
    std::shared_ptr<Job> job_;
    std::shared_ptr<WaitingClient> client_;
    std::optional<std::uint64_t> told_;
    std::function<void()> wake_ = [] {};
};

http::Response lines_of(std::shared_ptr<Job> job, std::shared_ptr<WaitingClient> client) {
    http::Response response;
    response.type = lines;
    response.producer = std::make_unique<JobLines>(std::move(job), std::move(client));
    return response;
}

bool accepts_lines(const http::Request& request) { return request.header("Accept").find(lines) != std::string_view::npos; }

using Tell = http::Response (*)(const Job& job);

http::Response at_its_end(const std::shared_ptr<Job>& job, std::shared_ptr<WaitingClient> client, Tell tell) {
    if (job->is_over()) return tell(*job);
    http::Response response = http::later([job, tell](const std::function<void(http::Response)>& say) {
        if (job->is_over()) return say(tell(*job));
        job->on_end.push_back([say, tell](const Job& ended) { say(tell(ended)); });
    });
    response.patient = true;
    response.needed = std::move(client);
    return response;
}

}    // namespace

http::Response answer_of(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request) {
    auto client = waiting_client(service, job, request);
    if (accepts_lines(request)) return lines_of(job, std::move(client));
    return at_its_end(job, std::move(client), end_answer);
}

http::Response job_answer(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request,
                          unsigned status) {
    if (!accepts_lines(request)) return json_answer(status, job_json(*job));
    if (!service.has_room_for_a_client()) return http::try_again("too many clients wait for jobs: ask again when one has ended");
    return lines_of(job, waiting_client(service, job, request));
}

http::Response job_at_its_end(const std::shared_ptr<Job>& job) {
    return at_its_end(job, nullptr, [](const Job& ended) { return json_answer(200, job_json(ended)); });
}

http::Response answer_of(const NotBegun& refused) {
    Json json{{"error", refused.error}, {"what", refused.what}};
    if (refused.has_it) json["job"] = refused.has_it->id;
    return json_answer(refused.status, json);
}

}    // namespace anogate
