// How a job is answered.
#pragma once
#include <devices/device_service.hpp>
#include <http/request.hpp>
#include <http/response.hpp>

#include <memory>

namespace anogate {

/// When it has ended, or by lines where the request accepts these.
http::Response answer_of(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request);
/// By lines where the request accepts these, by messages where it wants to become a WebSocket, or as it is now.
http::Response job_answer(DeviceService& service, const std::shared_ptr<Job>& job, const http::Request& request, unsigned status);
/// When it has ended, as it is then.
http::Response job_at_its_end(const std::shared_ptr<Job>& job);
http::Response answer_of(const NotBegun& refused);

}    // namespace anogate
