// The HTTP answers of jobs.
#pragma once
#include <devices/device_service.hpp>
#include <http/request.hpp>
#include <http/response.hpp>

#include <memory>

namespace anogate {

/// The client of a request: its right, its party, and whether its job changes a device.
Requester requester_of(const http::Request& request, bool acts);

/// Answers when the job has ended, or with lines if the request accepts them.
http::Response answer_of(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request);
/// Answers with lines if the request accepts them, with messages for a WebSocket, otherwise with the present state.
http::Response job_answer(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request, unsigned status);
/// Answers when the job has ended, with its state.
http::Response job_at_its_end(const std::shared_ptr<Job>& job);
http::Response answer_of(const NotBegun& refused);

}    // namespace anogate
