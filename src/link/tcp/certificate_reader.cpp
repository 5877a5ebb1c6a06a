#include <link/tcp/certificate_reader.hpp>
#include <link/tcp/tcp_keys.hpp>

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <ctime>
#include <utility>

namespace anogate {
namespace {

constexpr Duration check_slack = std::chrono::milliseconds{250};
constexpr Duration retry_unusable = std::chrono::seconds{10};

/// Times and inodes of the files: differ after a change of a file or its mode, or if a file was replaced.
using Times = std::array<std::pair<timespec, ino_t>, 3>;
Times times_of(const LinkCertificates& files) {
    Times times{};
    for (std::size_t i = 0; const std::string* file : {&files.certificate, &files.key, &files.ca}) {
        struct stat facts {};
        if (!file->empty() && ::stat(file->c_str(), &facts) == 0) times[i] = {facts.st_ctim, facts.st_ino};
        ++i;
    }
    return times;
}
bool are_equal(const Times& one, const Times& two) {
    return std::equal(one.begin(), one.end(), two.begin(), [](const auto& a, const auto& b) {
        return a.first.tv_sec == b.first.tv_sec && a.first.tv_nsec == b.first.tv_nsec && a.second == b.second;
    });
}

}    // namespace

struct CertificateReader::Result {
    TimePoint read_at{};
    Times times{};
    Opened<std::shared_ptr<const TlsContext>> context{NotOpened{LinkError{}}};
};

CertificateReader::CertificateReader(const LinkContext& context, Link& link, LinkCertificates files, TlsContext::Side side)
    : context_{context},
      link_{link},
      files_{std::move(files)},
      side_{side},
      task_{context.io},
      check_{context.alarms, [this] { begin(); }, check_slack} {}

CertificateReader::~CertificateReader() { stop(); }

// Waits briefly: at the end of the program, OpenSSL must not be in use any more. A thread that hangs owns its data.
void CertificateReader::stop() noexcept {
    done_ = nullptr;
    check_.cancel();
    task_.stop();
}

void CertificateReader::read(Done done) {
    if (has_usable()) return done({});
    done_ = std::move(done);
    begin();
}

// Unusable files are read again even if they have not changed, but less often: a lack of memory or of descriptors is temporary.
void CertificateReader::begin() {
    if (task_.is_running()) return;
    const auto result = std::make_shared<Result>();
    const TimePoint now = context_.host.now();
    const bool is_retry = last_ && !last_->context && now - last_->read_at >= retry_unusable;
    const auto work = [result, now, files = files_, side = side_, last = is_retry ? nullptr : last_] {
        result->read_at = now;
        result->times = times_of(files);
        if (!last || !are_equal(result->times, last->times)) result->context = TlsContext::read(files, side);
        else *result = *last;
    };
    const bool runs = task_.run(work, [this, result](const std::string& broken) {
        if (!broken.empty()) result->context = NotOpened{LinkError{"tls", broken, {}}};
        finished(result);
    });
    if (runs) return;
    result->context = NotOpened{LinkError{"tls", std::string{task_.why_not()}, {}}};
    finished(result);
}

void CertificateReader::finished(std::shared_ptr<const Result> result) {
    last_ = std::move(result);
    fault_ = last_->context ? std::string{} : last_->context.error().text;
    if (last_->context) in_use_ = *last_->context;
    check_.set(context_.host.now() + between_checks);
    report();
    const Done done = std::exchange(done_, nullptr);
    if (!done) return;
    if (has_usable()) done({});
    else done(NotOpened{last_->context.error()});
}

void CertificateReader::report() {
    const LinkError trouble = tls_trouble(*this);
    if (trouble.text == reported_) return;
    reported_ = trouble.text;
    if (!reported_.empty()) context_.host.report_trouble(link_, trouble);
}

Opened<std::shared_ptr<TlsConnection>> CertificateReader::connection(int fd, const std::string& host) const {
    if (!has_usable()) return NotOpened{LinkError{"tls", fault_, {}}};
    return in_use_->connection(fd, host);
}

std::optional<std::int64_t> CertificateReader::days_left() const {
    return has_usable() ? in_use_->validity().days_left : std::nullopt;
}

}    // namespace anogate
