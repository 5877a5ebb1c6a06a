#include <mavlink/signature.hpp>

#include <openssl/evp.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

namespace anogate::mavlink {
namespace {

constexpr std::size_t time_size = 6, hash_size = 6, link_size = 1;

SigningKey sha256(std::span<const std::uint8_t> bytes) {
    SigningKey hash{};
    unsigned size = 0;
    if (EVP_Digest(bytes.data(), bytes.size(), hash.data(), &size, EVP_sha256(), nullptr) != 1)
        throw std::runtime_error{"SHA-256 is not available"};
    return hash;
}

// Of the packet up to its time.
SigningKey signature_hash(const SigningKey& key, std::span<const std::uint8_t> packet) {
    std::vector<std::uint8_t> bytes(key.begin(), key.end());
    bytes.insert(bytes.end(), packet.begin(), packet.end());
    return sha256(bytes);
}

}    // namespace

SigningKey key_of_passphrase(std::string_view passphrase) {
    return sha256({reinterpret_cast<const std::uint8_t*>(passphrase.data()), passphrase.size()});
}

std::uint64_t signing_time(std::uint64_t unix_us) noexcept {
    constexpr std::uint64_t begin_us = 1'420'070'400'000'000, unit_us = 10;
    return unix_us > begin_us ? (unix_us - begin_us) / unit_us : 0;
}

void sign(std::span<std::uint8_t> packet, const SigningKey& key, std::uint8_t link, std::uint64_t time) {
    const std::size_t end = packet.size() - signature_size;
    packet[end] = link;
    for (std::size_t i = 0; i < time_size; ++i) packet[end + link_size + i] = static_cast<std::uint8_t>(time >> (8 * i));
    const SigningKey hash = signature_hash(key, packet.first(packet.size() - hash_size));
    std::copy_n(hash.begin(), hash_size, packet.end() - hash_size);
}

bool SignatureCheck::accepts(PacketView packet, std::uint64_t now) {
    if (!packet.is_signed()) return false;
    const auto signature = packet.signature();
    std::uint64_t time = 0;
    for (std::size_t i = 0; i < time_size; ++i) time |= std::uint64_t{signature[link_size + i]} << (8 * i);
    const SigningKey hash = signature_hash(key_, packet.bytes().first(packet.bytes().size() - hash_size));
    unsigned difference = 0;    // the time that it takes tells nothing of the key
    for (std::size_t i = 0; i < hash_size; ++i)
        difference |= static_cast<unsigned>(hash[i] ^ signature[link_size + time_size + i]);
    if (difference != 0) return false;
    const auto sender = std::tuple{signature[0], packet.system(), packet.component()};
    const auto known = newest_.find(sender);
    if (known == newest_.end() && (time + max_age < now || newest_.size() == max_senders)) return false;
    if (known != newest_.end() && time <= known->second) return false;
    newest_[sender] = time;
    return true;
}

}    // namespace anogate::mavlink
