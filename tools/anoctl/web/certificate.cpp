// anoctl certificate: makes a certificate authority, and a certificate for each computer.
#include <anoctl/anoctl.hpp>
#include <anoctl/text/table.hpp>
#include "web_certificate.hpp"

#include <gateway/host_spec.hpp>
#include <http/client/certificate.hpp>

#include <ano_json/text.hpp>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace anoctl {
namespace {

namespace fs = std::filesystem;
using namespace anogate::http;

struct CertificateCommand {
    std::string name;
    std::optional<std::string> into;

    int run(Streams& streams) const {
        const Computer computer = this_computer();
        const std::string whose = name.empty() ? computer.name : name;
        if (!anogate::is_host_name(whose) && !anogate::IpAddress::parse(whose))
            throw UsageError{ano::in_quotes(whose) + " is not a host name or an IP address"};
        const fs::path folder = fs::absolute(into.value_or(certificate_folder())).lexically_normal();
        if (!fs::is_directory(folder)) throw Failure{"folder not found: " + folder.string() + "; choose another one with --into"};

        const CertificateFiles authority{folder / "ca.pem", folder / "ca-key.pem"};
        const CertificateFiles made{folder / (whose + ".pem"), folder / (whose + "-key.pem")};
        const bool is_new = !fs::exists(authority.certificate);
        if (is_new) must(make_authority(name_of_authority(computer.name), authority));
        must(make_signed_certificate(whose == computer.name ? names_for(computer) : names_of_another(whose), made, authority));
        set_service_owner(made.key);
        print_result(authority, made, is_new, whose == computer.name ? "" : whose, streams.out);
        return fine;
    }

private:
    /// A unique name, so that a certificate of another authority is recognised by its issuer, not only by a wrong signature.
    static std::string name_of_authority(const std::string& computer) {
        const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
        return "anogate " + computer.substr(0, 40) + ' ' + std::to_string(now.time_since_epoch().count());
    }
    static void must(const anogate::Expected<void>& done) {
        if (!done) throw Failure{done.error()};
    }
    static CertificateNames names_of_another(const std::string& name) {
        if (anogate::IpAddress::parse(name)) return {{}, {name}};
        return {names_of({name, {}}), {}};
    }
    // `other`: the computer to which the certificate belongs; empty: this one.
    static void print_result(const CertificateFiles& authority, const CertificateFiles& made, bool is_new,
                             const std::string& other, std::ostream& out) {
        if (is_new)
            out << authority.certificate << ": a new authority; every computer needs this file\n"
                << authority.key << ": its key, which signs further certificates; keep it secret, on this computer\n";
        out << made.certificate << ", " << made.key << ": the certificate and its key\n";
        if (!other.empty())
            out << "Copy " << made.certificate << ", " << made.key << " and " << authority.certificate << " to " << other
                << ", and adapt the paths there.\n";
        out << "Links:\n"
            << "    tls-listen:0.0.0.0:12334,certificate=" << made.certificate << ",key=" << made.key
            << ",ca=" << authority.certificate << "\n    tls:HOST:12334,certificate=" << made.certificate << ",key=" << made.key
            << ",ca=" << authority.certificate << '\n';
    }
};

}    // namespace

Run add_certificate(Options& options) {
    const auto self = std::make_shared<CertificateCommand>();
    options.push_back({"name", &self->name, "[NAME]", "Host name or IP address of the computer (default: this computer)"});
    options.push_back(
        {"--into", &self->into, "FOLDER", "Output folder (default: /etc/anogate for root if it exists, otherwise this folder)"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
