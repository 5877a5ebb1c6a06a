#include <http/client/certificate.hpp>
#include <sys/errors.hpp>
#include <sys/files/write_all.hpp>
#include <sys/unique_fd.hpp>

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>

#include <arpa/inet.h>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <memory>

namespace anogate::http {
namespace {

template <auto free_it>
struct Free {
    template <class T>
    void operator()(T* what) const {
        free_it(what);
    }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;
using Text = std::unique_ptr<BIO, Free<BIO_free>>;
using File = std::unique_ptr<std::FILE, Free<std::fclose>>;
using Extension = std::unique_ptr<X509_EXTENSION, Free<X509_EXTENSION_free>>;

constexpr long day = 24L * 60 * 60, valid_days = 824, authority_days = 20 * 365;

Unexpected openssl_fault() {
    char words[256] = {};
    ERR_error_string_n(ERR_get_error(), words, sizeof words);
    return Unexpected{std::string{"OpenSSL: "} + words};
}

bool add_extension(X509& certificate, int kind, const std::string& value) {
    X509V3_CTX context{};
    X509V3_set_ctx_nodb(&context);
    X509V3_set_ctx(&context, &certificate, &certificate, nullptr, nullptr, 0);
    const Extension extension{X509V3_EXT_conf_nid(nullptr, &context, kind, value.c_str())};
    return extension && X509_add_ext(&certificate, extension.get(), -1) == 1;
}

std::string alternative_names(const CertificateNames& names) {
    std::string all;
    for (const std::string& host : names.hosts) all += (all.empty() ? "DNS:" : ",DNS:") + host;
    for (const std::string& address : names.addresses) all += (all.empty() ? "IP:" : ",IP:") + address;
    return all;
}

bool set_serial(X509& certificate) {
    std::uint64_t number = 0;
    if (RAND_bytes(reinterpret_cast<unsigned char*>(&number), sizeof number) != 1) return false;
    return ASN1_INTEGER_set_uint64(X509_get_serialNumber(&certificate), number >> 1) == 1;
}

bool fill(X509& certificate, EVP_PKEY& key, const std::string& subject, long days) {
    constexpr long version_3 = 2;
    X509_NAME* name = X509_get_subject_name(&certificate);
    return X509_set_version(&certificate, version_3) == 1 && set_serial(certificate) &&
           X509_gmtime_adj(X509_getm_notBefore(&certificate), -day) != nullptr &&
           X509_gmtime_adj(X509_getm_notAfter(&certificate), (days - 1) * day) != nullptr &&
           X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8, reinterpret_cast<const unsigned char*>(subject.c_str()), -1, -1,
                                      0) == 1 &&
           X509_set_issuer_name(&certificate, name) == 1 && X509_set_pubkey(&certificate, &key) == 1;
}

bool add_use(X509& certificate, const CertificateNames& names, const char* ends) {
    return add_extension(certificate, NID_basic_constraints, "critical,CA:FALSE") &&
           add_extension(certificate, NID_key_usage, "critical,digitalSignature") &&
           add_extension(certificate, NID_ext_key_usage, ends) &&
           add_extension(certificate, NID_subject_alt_name, alternative_names(names));
}

// A subject has at most 64 characters. The alternative names, which are complete, are what other programs check.
std::string subject_of(const CertificateNames& names) {
    constexpr std::size_t longest = 64;
    return names.hosts.empty() ? "anogate" : names.hosts.front().substr(0, longest);
}

Expected<void> write_new(const std::string& path, BIO& text, mode_t mode) {
    char* bytes = nullptr;
    const auto size = static_cast<std::size_t>(BIO_get_mem_data(&text, &bytes));
    const UniqueFd fd{::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, mode)};
    if (!fd) return Unexpected{error_text(path, errno)};
    ::fchmod(fd.get(), mode);    // whatever the umask: the service reads the certificates of root
    if (write_all(fd.get(), {bytes, size})) return {};
    const int error = errno;
    ::unlink(path.c_str());
    return Unexpected{error_text(path, error)};
}

struct Pair {
    Text key, certificate;
};

Expected<void> write_pair(const Pair& pair, const CertificateFiles& files) {
    if (auto written = write_new(files.key, *pair.key, S_IRUSR | S_IWUSR); !written) return written;
    auto written = write_new(files.certificate, *pair.certificate, S_IRUSR | S_IWUSR | S_IRGRP | S_IROTH);
    if (!written) ::unlink(files.key.c_str());
    return written;
}

// The owner stays unchanged without the permission to set it: then the previous owner is this user.
Expected<void> keep_owner(const std::string& previous, const std::string& key) {
    struct stat facts {};
    if (::lstat(previous.c_str(), &facts) != 0)
        return errno == ENOENT ? Expected<void>{} : Unexpected{error_text(previous, errno)};
    if (!S_ISREG(facts.st_mode)) return Unexpected{previous + ": is not a file"};
    const UniqueFd fd{::open(key.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW)};
    if (fd && ::fchown(fd.get(), facts.st_uid, facts.st_gid) == 0) ::fchmod(fd.get(), facts.st_mode & (S_IRWXU | S_IRWXG));
    return {};
}

// Who reads the files between the two replacements sees a key of another certificate, and has to read them again.
Expected<void> replace_pair(const Pair& pair, const CertificateFiles& files) {
    const CertificateFiles fresh{files.certificate + ".new", files.key + ".new"};
    for (const std::string& file : {fresh.certificate, fresh.key}) ::unlink(file.c_str());
    if (auto written = write_pair(pair, fresh); !written) return written;
    Expected<void> replaced = keep_owner(files.key, fresh.key);
    if (replaced && ::rename(fresh.key.c_str(), files.key.c_str()) != 0) replaced = Unexpected{error_text(files.key, errno)};
    if (replaced && ::rename(fresh.certificate.c_str(), files.certificate.c_str()) != 0)
        replaced = Unexpected{error_text(files.certificate, errno)};
    if (!replaced)
        for (const std::string& file : {fresh.certificate, fresh.key}) ::unlink(file.c_str());
    return replaced;
}

/// Makes a key and a certificate, calls `finish` to complete and sign the certificate, and returns both as PEM.
template <class Finish>
Expected<Pair> make_pair(const std::string& subject, long days, Finish finish) {
    const Key pair{EVP_EC_gen("P-256")};
    const Certificate made{X509_new()};
    Pair texts{Text{BIO_new(BIO_s_mem())}, Text{BIO_new(BIO_s_mem())}};
    const bool done = pair && made && texts.key && texts.certificate && fill(*made, *pair, subject, days) &&
                      finish(*made, *pair) &&
                      PEM_write_bio_PKCS8PrivateKey(texts.key.get(), pair.get(), nullptr, nullptr, 0, nullptr, nullptr) == 1 &&
                      PEM_write_bio_X509(texts.certificate.get(), made.get()) == 1;
    if (!done) return openssl_fault();
    return texts;
}

Expected<void> write(const Expected<Pair>& pair, const CertificateFiles& files, Existing existing = Existing::kept) {
    if (!pair) return Unexpected{pair.error()};
    return existing == Existing::replaced ? replace_pair(*pair, files) : write_pair(*pair, files);
}

Expected<Certificate> read_certificate(const std::string& path) {
    const File file{::fopen(path.c_str(), "re")};
    if (!file) return Unexpected{error_text(path, errno)};
    Certificate read{PEM_read_X509(file.get(), nullptr, nullptr, nullptr)};
    if (!read) return Unexpected{path + ": not a PEM certificate"};
    return read;
}

}    // namespace

Expected<void> make_certificate(const CertificateNames& names, const std::string& certificate, const std::string& key) {
    const auto pair = make_pair(subject_of(names), valid_days, [&](X509& made, EVP_PKEY& own_key) {
        return add_use(made, names, "serverAuth") && X509_sign(&made, &own_key, EVP_sha256()) > 0;
    });
    return write(pair, {certificate, key});
}

Expected<void> make_authority(const std::string& name, const CertificateFiles& files) {
    const auto pair = make_pair(name, authority_days, [](X509& made, EVP_PKEY& own_key) {
        return add_extension(made, NID_basic_constraints, "critical,CA:TRUE,pathlen:0") &&
               add_extension(made, NID_key_usage, "critical,keyCertSign,cRLSign") && X509_sign(&made, &own_key, EVP_sha256()) > 0;
    });
    return write(pair, files);
}

Expected<void> make_signed_certificate(const CertificateNames& names, const CertificateFiles& files,
                                       const CertificateFiles& authority, Existing existing) {
    const File certificate{::fopen(authority.certificate.c_str(), "re")};
    if (!certificate) return Unexpected{error_text(authority.certificate, errno)};
    const File key{::fopen(authority.key.c_str(), "re")};
    if (!key)
        return Unexpected{error_text(authority.key, errno) +
                          "; run this on the computer that has this key of the authority, as a user who may read it"};
    const Certificate issuer{PEM_read_X509(certificate.get(), nullptr, nullptr, nullptr)};
    const Key its_key{PEM_read_PrivateKey(key.get(), nullptr, nullptr, nullptr)};
    if (!issuer || !its_key || X509_check_private_key(issuer.get(), its_key.get()) != 1)
        return Unexpected{authority.certificate + " and " + authority.key + " are not a certificate and its key"};
    const auto pair = make_pair(subject_of(names), valid_days, [&](X509& made, EVP_PKEY&) {
        return X509_set_issuer_name(&made, X509_get_subject_name(issuer.get())) == 1 &&
               add_use(made, names, "serverAuth,clientAuth") && X509_sign(&made, its_key.get(), EVP_sha256()) > 0;
    });
    return write(pair, files, existing);
}

Expected<CertificateNames> names_in(const std::string& certificate) {
    const auto read = read_certificate(certificate);
    if (!read) return Unexpected{read.error()};
    const std::unique_ptr<GENERAL_NAMES, Free<GENERAL_NAMES_free>> all{
        static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(read->get(), NID_subject_alt_name, nullptr, nullptr))};
    CertificateNames names;
    for (int i = 0; all && i < sk_GENERAL_NAME_num(all.get()); ++i) {
        int kind = 0;
        const auto* const value = static_cast<const ASN1_STRING*>(
            GENERAL_NAME_get0_value(sk_GENERAL_NAME_value(all.get(), i), &kind));
        if (kind != GEN_DNS && kind != GEN_IPADD) continue;
        const unsigned char* const bytes = ASN1_STRING_get0_data(value);
        const auto size = static_cast<std::size_t>(ASN1_STRING_length(value));
        char text[INET6_ADDRSTRLEN] = {};
        const bool is_address = size == sizeof(in_addr) || size == sizeof(in6_addr);
        if (kind == GEN_DNS) names.hosts.emplace_back(bytes, bytes + size);
        else if (is_address && ::inet_ntop(size == sizeof(in_addr) ? AF_INET : AF_INET6, bytes, text, sizeof text))
            names.addresses.emplace_back(text);
    }
    return names;
}

Expected<std::string> fingerprint(const std::string& certificate) {
    const auto read = read_certificate(certificate);
    if (!read) return Unexpected{read.error()};
    unsigned char bytes[EVP_MAX_MD_SIZE];
    unsigned size = 0;
    if (X509_digest(read->get(), EVP_sha256(), bytes, &size) != 1) return openssl_fault();
    constexpr char digits[] = "0123456789ABCDEF";
    std::string text;
    for (unsigned i = 0; i < size; ++i) {
        if (i > 0) text += ':';
        text.append({digits[bytes[i] >> 4], digits[bytes[i] & 15]});
    }
    return text;
}

}    // namespace anogate::http
