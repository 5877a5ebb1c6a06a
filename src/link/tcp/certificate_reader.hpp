// Reads the certificate files of a link, in a thread, and again when they change.
#pragma once
#include <link/link_context.hpp>
#include <link/tcp/tls_context.hpp>
#include <sys/alarm.hpp>
#include <sys/background_task.hpp>

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace anogate {

/// Whether files have changed is checked once a second; unusable ones are also read again every 10 s. Until the changed files are read, and if they can't be used, the previous
/// ones stay in use. Open connections are not affected.
///
/// Flow:    read(done) → done(usable) → connection()...
class CertificateReader {
public:
    static constexpr Duration between_checks = std::chrono::seconds{1};
    using Done = std::function<void(Opened<void> usable)>;

    /// While `link` is up, trouble with its certificates is reported once when it appears.
    CertificateReader(const LinkContext& context, Link& link, LinkCertificates files, TlsContext::Side side);
    ~CertificateReader();
    CertificateReader(const CertificateReader&) = delete;
    CertificateReader& operator=(const CertificateReader&) = delete;

    /// Calls `done`: at once if files are in use, otherwise when they are read. After an error, call it again to retry.
    void read(Done done);
    /// Stops checking; `done` is not called any more.
    void stop() noexcept;

    /// As TlsContext::connection(), with the files in use.
    Opened<std::shared_ptr<TlsConnection>> connection(int fd, const std::string& host) const;
    /// The reason why the current files can't be used; empty: they can.
    const std::string& fault() const noexcept { return fault_; }
    bool has_usable() const noexcept { return in_use_ != nullptr; }
    /// nullptr: none yet.
    const TlsContext* in_use() const noexcept { return in_use_.get(); }
    /// Until the certificate in use expires, as in CertificateValidity.
    std::optional<std::int64_t> days_left() const;

private:
    struct Result;
    void begin();
    void finished(std::shared_ptr<const Result> result);
    void report();

    LinkContext context_;
    Link& link_;
    LinkCertificates files_;
    TlsContext::Side side_;
    std::shared_ptr<const TlsContext> in_use_;    // nullptr: none yet
    std::shared_ptr<const Result> last_;          // of the last reading; nullptr: none yet
    std::string fault_;
    std::string reported_;    // the last trouble; empty: there is none
    Done done_;
    BackgroundTask task_;
    Alarm check_;
};

}    // namespace anogate
