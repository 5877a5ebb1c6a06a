#include <ano_json/fault_json.hpp>
#include <ano_json/json_line.hpp>
#include <devices/job_answers.hpp>
#include <http/web_socket.hpp>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <utility>

namespace anogate {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::string_view type_of_lines = "application/x-ndjson";

http::Response line_answer(unsigned status, std::string line) {
    http::Response response;
    response.status = status;
    response.body = std::move(line);
    return response;
}

http::Response line_answer(unsigned status, std::shared_ptr<const std::string> line) {
    http::Response response;
    response.status = status;
    response.shared = std::move(line);
    return response;
}

http::Response end_answer(const Job& job) {
    http::Response response = line_answer(job.end->status, end_line(job));
    if (!job.conflict.empty()) response.headers.push_back({"Anogate-Conflict", job.conflict.text()});
    return response;
}

/// A client that waits for a job; on request, the job is cancelled when it disconnects.
class WaitingClient {
public:
    WaitingClient(DeviceService& service, std::shared_ptr<Job> job, bool ends_with_him, const Requester& requester)
        : service_{service}, job_{std::move(job)}, ends_with_him_{ends_with_him}, place_{service.waiting_client(requester)} {
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

bool is_bound_to_connection(const http::Request& request) { return request.query_value("while_connected").has_value(); }

std::shared_ptr<WaitingClient> waiting_client(DeviceService& service, const std::shared_ptr<Job>& job,
                                              const http::Request& request, bool may_cancel) {
    return std::make_shared<WaitingClient>(service, job, may_cancel && is_bound_to_connection(request),
                                           requester_of(request, job->is_writing()));
}

// A client that only watches a job of others does not cancel it by disconnecting, and neither does a page of another site.
std::shared_ptr<WaitingClient> watching_client(DeviceService& service, const std::shared_ptr<Job>& job,
                                               const http::Request& request) {
    return waiting_client(service, job, request, request.access == http::Access::control && !request.is_foreign);
}

// Sends a line for each change; changes during the sending of a line are combined into one.
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
        if (!line_ && sent_version_ != job_->version) {
            sent_version_ = job_->version;
            line_ = job_line(*job_);
            at_ = 0;
        }
        if (line_) into.append(*line_, at_, part);
        at_ += into.size();
        if (line_ && at_ < line_->size()) return Next::part;
        line_.reset();
        if (sent_version_ != job_->version) return Next::part;
        return job_->is_over() ? Next::end : Next::later;
    }

private:
    std::shared_ptr<Job> job_;
    static constexpr std::size_t part = std::size_t{64} * 1024;

    std::shared_ptr<WaitingClient> client_;
    std::optional<std::uint64_t> sent_version_;
    std::shared_ptr<const std::string> line_;    // being sent
    std::size_t at_ = 0;                         // bytes of it already sent
    std::function<void()> wake_ = [] {};
};

// The same as messages; closes after the last one.
class JobMessages final : public http::WebSocketUser {
public:
    JobMessages(std::shared_ptr<Job> job, std::shared_ptr<WaitingClient> client)
        : job_{std::move(job)}, client_{std::move(client)} {
        job_->on_change.push_back(&wake_);
    }
    ~JobMessages() override {
        auto& all = job_->on_change;
        all.erase(std::remove(all.begin(), all.end(), &wake_), all.end());
    }
    JobMessages(const JobMessages&) = delete;
    JobMessages& operator=(const JobMessages&) = delete;

    void opened(http::WebSocket& socket) override {
        socket_ = &socket;
        answer();
    }
    void heard(std::string_view, http::WebSocket::Kind) override {}    // the client only receives
    void sent_all() override { answer(); }
    bool closes_itself() const override { return true; }

private:
    void answer() {
        if (socket_ == nullptr || socket_->waiting() > 0) return;
        if (sent_version_ == job_->version) {
            if (job_->is_over()) socket_->close(1000, "the job has ended");
            return;
        }
        sent_version_ = job_->version;
        const auto line = job_line(*job_);
        if (!socket_->send(std::make_shared<const std::string>(*line, 0, line->size() - 1), http::WebSocket::Kind::text))
            socket_->close(1009, "the result of the job is too large for a message");
    }

    std::shared_ptr<Job> job_;
    std::shared_ptr<WaitingClient> client_;
    http::WebSocket* socket_ = nullptr;    // nullptr: not open yet
    std::optional<std::uint64_t> sent_version_;
    std::function<void()> wake_ = [this] { answer(); };
};

http::Response lines_of(std::shared_ptr<Job> job, std::shared_ptr<WaitingClient> client) {
    http::Response response;
    response.type = type_of_lines;
    response.producer = std::make_unique<JobLines>(std::move(job), std::move(client));
    return response;
}

bool accepts_lines(const http::Request& request) {
    return request.header("Accept").find(type_of_lines) != std::string_view::npos;
}

using MakeResponse = http::Response (*)(const Job& job);

http::Response at_its_end(const std::shared_ptr<Job>& job, std::shared_ptr<WaitingClient> client, MakeResponse answer) {
    if (job->is_over()) return answer(*job);
    http::Response response = http::later([job, answer](const std::function<void(http::Response)>& respond) {
        if (job->is_over()) return respond(answer(*job));
        job->on_end.push_back([respond, answer](const Job& ended) { respond(answer(ended)); });
    });
    response.patient = true;
    response.needed = std::move(client);
    return response;
}

}    // namespace

Requester requester_of(const http::Request& request, bool acts) {
    const bool will_act = request.access == http::Access::control && request.query_value("to_act").has_value();
    return {request.access, http::client_id_of(request.user, request.connection_info), acts || will_act};
}

http::Response answer_of(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request) {
    auto client = waiting_client(service, job, request, true);
    if (!is_bound_to_connection(request)) job->goes_on = true;
    if (accepts_lines(request)) return lines_of(job, std::move(client));
    return at_its_end(job, std::move(client), end_answer);
}

http::Response job_answer(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request,
                          unsigned status) {
    const bool is_web_socket_client = http::is_web_socket(request);
    if (!is_web_socket_client && !accepts_lines(request)) return line_answer(status, job_line(*job));
    if (!service.has_room_for(requester_of(request, job->is_writing()))) return http::try_again(ano::Fault{"clients_waiting"});
    if (!is_web_socket_client) return lines_of(job, watching_client(service, job, request));
    http::Response response;
    response.web_socket = std::make_unique<JobMessages>(job, watching_client(service, job, request));
    return response;
}

http::Response job_at_its_end(const std::shared_ptr<Job>& job) {
    return at_its_end(job, nullptr, [](const Job& ended) { return line_answer(200, job_line(ended)); });
}

http::Response answer_of(const NotBegun& refused) {
    Json json;
    ano::add_fault(json, refused.fault);
    json["what"] = refused.what;
    if (refused.has_it) json["job"] = refused.has_it->id;
    http::Response response = line_answer(refused.status(), ano::json_line(json));
    if (refused.status() == 503) response.headers.push_back(http::retry_after());
    return response;
}

}    // namespace anogate
