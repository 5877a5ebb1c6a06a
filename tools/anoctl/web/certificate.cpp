// anoctl certificate: makes a certificate authority, and a certificate for each computer.
#include <anoctl/anoctl.hpp>
#include <anoctl/text/table.hpp>
#include "web_certificate.hpp"

#include <gateway/host_spec.hpp>
#include <http/client/certificate.hpp>

#include <ano_json/frame_json.hpp>
#include <ano_json/text.hpp>
#include <nlohmann/json.hpp>

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace anoctl {
namespace {

namespace fs = std::filesystem;
using namespace anogate::http;

constexpr char another_folder[] = "; choose another folder with --into";

/// Where the files of another computer are to be copied.
constexpr char folder_there[] = "/etc/anogate";

struct CertificateCommand {
    std::optional<std::string> name, into;
    bool renew = false, json = false;

    int run(Streams& streams) const {
        const Computer computer = this_computer();
        if (name && name->empty()) throw UsageError{"NAME is an empty name; for the certificate of this computer, omit it"};
        std::string whose = name.value_or(computer.name);
        if (whose.ends_with('.')) whose.pop_back();
        check_name(whose);
        if (whose == "ca" || whose.ends_with("-key"))
            throw UsageError{"the files of " + ano::in_quotes(whose) +
                             " would have the names of other files: choose another name"};
        const fs::path folder = folder_for(into.value_or(certificate_folder()));
        const CertificateFiles authority{folder / "ca.pem", folder / "ca-key.pem"};
        const CertificateFiles made{folder / (whose + ".pem"), folder / (whose + "-key.pem")};
        const bool is_new = !fs::exists(authority.certificate), is_here = whose == computer.name;
        check(authority, made, is_new);
        const bool has_key = fs::exists(made.key);
        CertificateNames names = is_here ? names_for(computer) : names_of_another(whose);
        if (renew) add_previous(names, made.certificate);
        if (is_new) must(make_authority(name_of_authority(computer.name), authority));
        const auto done = make_signed_certificate(names, made, authority, renew ? Existing::replaced : Existing::kept);
        if (!done && is_new)
            for (const std::string& file : {authority.certificate, authority.key}) ::unlink(file.c_str());
        must(done);
        if (!has_key) set_service_owner(made.key);
        if (json) return print_json(authority, made, streams.out);
        if (is_new) print_authority(authority, streams.out);
        if (renew) print_renewed(made, is_here ? "" : whose, streams.out);
        else if (is_here) print_result(authority, made, streams.out);
        else print_result_for(whose, computer, folder, streams.out);
        return fine;
    }

private:
    static void check_name(const std::string& whose) {
        const auto address = anogate::IpAddress::parse(whose);
        const std::size_t percent = whose.find('%');
        if (percent != whose.npos && anogate::IpAddress::parse(whose.substr(0, percent)))
            throw UsageError{ano::in_quotes(whose) + ": a certificate can't contain an interface: omit " + whose.substr(percent)};
        if (!address && !anogate::is_host_name(whose))
            throw UsageError{ano::in_quotes(whose) + " is not a host name or an IP address"};
        if (address && (address->is_any() || address->is_multicast() || anogate::is_broadcast(*address, {})))
            throw UsageError{ano::in_quotes(whose) + " is not the address of one computer"};
    }
    static fs::path folder_for(const std::string& given) {
        fs::path folder = fs::absolute(given).lexically_normal();
        if (!folder.has_filename() && folder.has_relative_path()) folder = folder.parent_path();    // removes a trailing slash
        if (!fs::is_directory(folder)) throw Failure{"folder not found: " + folder.string() + another_folder};
        if (::access(folder.c_str(), W_OK | X_OK) != 0)
            throw Failure{"permission denied: cannot write to " + folder.string() + another_folder + ", or use sudo"};
        return folder;
    }
    void check(const CertificateFiles& authority, const CertificateFiles& made, bool is_new) const {
        if (is_new && renew)
            throw Failure{"authority not found: " + authority.certificate +
                          "; run this command in its folder (--into), or without --renew to create a new authority"};
        if (is_new && fs::exists(authority.key))
            throw Failure{authority.key +
                          " is here without its certificate ca.pem; copy ca.pem back from a computer that has it, "
                          "or remove ca-key.pem to create a new authority for all computers"};
        if (renew && !fs::exists(made.certificate))
            throw Failure{made.certificate + " not found; to make a new certificate, omit --renew"};
        for (const std::string& file : {made.certificate, made.key})
            if (!renew && fs::exists(fs::symlink_status(file)))
                throw Failure{file + " already exists; to replace the certificate and its key by new ones, use --renew"};
    }
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
    /// The addresses of networks that are not connected now are kept.
    static void add_previous(CertificateNames& names, const std::string& certificate) {
        const auto previous = names_in(certificate);
        if (!previous) throw Failure{previous.error() + "; to make a new certificate, remove the file and omit --renew"};
        const auto add = [](std::vector<std::string>& all, const std::vector<std::string>& more) {
            for (const std::string& one : more)
                if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(one);
        };
        add(names.hosts, previous->hosts);
        add(names.addresses, previous->addresses);
    }
    static std::string fingerprint_of(const CertificateFiles& made) {
        const auto known_by = anogate::http::fingerprint(made.certificate);
        if (!known_by) throw Failure{known_by.error()};
        return *known_by;
    }
    static int print_json(const CertificateFiles& authority, const CertificateFiles& made, std::ostream& out) {
        out << ano::Json{{"certificate", made.certificate},
                         {"key", made.key},
                         {"ca", authority.certificate},
                         {"fingerprint", fingerprint_of(made)}}
            << '\n';
        return fine;
    }
    static void print_authority(const CertificateFiles& authority, std::ostream& out) {
        out << authority.certificate << ": a new authority; every computer needs this file\n"
            << authority.key << ": its key, which signs further certificates; keep it secret, on this computer\n";
    }
    static void print_keys(const fs::path& folder, const std::string& whose, std::ostream& out) {
        const std::string path = (folder / whose).string();
        out << ",certificate=" << path << ".pem,key=" << path << "-key.pem,ca=" << (folder / "ca.pem").string() << '\n';
    }
    static void print_links(const fs::path& folder, const std::string& whose, const std::string& peer, std::ostream& out) {
        print_keys(folder, whose, out << "    tls-listen:0.0.0.0:12334");
        print_keys(folder, whose, out << "    tls:" << peer << ":12334");
    }
    static void print_result(const CertificateFiles& authority, const CertificateFiles& made, std::ostream& out) {
        const fs::path file{made.certificate};
        out << made.certificate << ", " << made.key << ": the certificate of this computer and its key\n"
            << "Links on this computer; HOST is a name in the certificate of the other end:\n";
        print_links(file.parent_path(), file.stem().string(), "HOST", out);
        out << "For the page, add this to the configuration and restart the gateway:\n    \"control\": {\"tls\": "
            << ano::Json{{"certificate", made.certificate}, {"key", made.key}}.dump() << "}\n"
            << "Import " << authority.certificate << " into the browser, or compare the SHA-256 fingerprint in its warning:\n    "
            << fingerprint_of(made) << '\n';
    }
    static void print_result_for(const std::string& other, const Computer& here, const fs::path& folder, std::ostream& out) {
        out << "Copy " << other << ".pem, " << other << "-key.pem and ca.pem from " << folder.string() << " to " << folder_there
            << " on " << other << ".\n";
        print_chown(other, out);
        out << "Links on " << other << ":\n";
        print_links(folder_there, other, here.name.empty() ? "HOST" : names_of(here).back(), out);
    }
    static void print_chown(const std::string& other, std::ostream& out) {
        out << "If the gateway there is a service, let it read the key, on " << other
            << ":\n    sudo chown anogate: " << folder_there << '/' << other << "-key.pem\n";
    }
    // `other`: the computer to which the certificate belongs; empty: this one.
    static void print_renewed(const CertificateFiles& made, const std::string& other, std::ostream& out) {
        out << made.certificate << ", " << made.key << ": the new certificate and its key\n";
        if (other.empty()) out << "Links use them for new connections. Reload the gateway if its page uses them: anoctl reload\n";
        else
            print_chown(other, out << "Copy both to " << other
                                   << ", over the previous ones. Links there use them for new connections.\n");
    }
};

}    // namespace

Run add_certificate(Options& options) {
    const auto self = std::make_shared<CertificateCommand>();
    options.push_back({"name", &self->name, "[NAME]", "Host name or IP address of the computer (default: this computer)"});
    options.push_back(
        {"--into", &self->into, "FOLDER", "Output folder (default: /etc/anogate for root if it exists, otherwise this folder)"});
    options.push_back(
        {"--renew", &self->renew, "", "Replace an existing certificate and its key by new ones of the same authority"});
    options.push_back({"--json", &self->json, "", "Print one JSON object"});
    return [self](Streams& streams) { return self->run(streams); };
}

}    // namespace anoctl
