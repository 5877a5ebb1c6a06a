// Signed packets against one that another implementation (node-mavlink) signed.
#include <mavlink/packet_parser.hpp>
#include <mavlink/signature.hpp>
#include <mavlink/typed.hpp>

#include <gtest/gtest.h>
#include <support/bytes.hpp>

namespace mavlink_signature_tests {
namespace {

using namespace anogate::mavlink;
using support::Bytes;

// Link 5, 1,700,000,000,000 ms since 1970, a key of 32 bytes 7.
const Bytes theirs = support::hex(
    "FD 09 01 00 09 FF BE 00 00 00 01 02 03 04 02 0C 51 03 03 61 44 05 00 E0 6F 9E 75 19 50 A7 E0 5C F5 A0");
const std::uint64_t time_of_theirs = signing_time(1'700'000'000'000'000);

SigningKey key() {
    SigningKey all;
    all.fill(7);
    return all;
}

Bytes signed_heartbeat(std::uint64_t time, std::uint8_t link = 1) {
    const Draft<"HEARTBEAT"> draft;
    Bytes bytes(max_packet);
    bytes.resize(encode(bytes, Version::v2, {255, 190}, 0, draft.row, draft.payload(), flag_signed) + signature_size);
    sign(bytes, key(), link, time);
    return bytes;
}

TEST(Signature, is_that_of_others) {
    Bytes ours = theirs;
    for (std::size_t i = ours.size() - signature_size; i < ours.size(); ++i) ours[i] = 0;
    sign(ours, key(), 5, time_of_theirs);
    EXPECT_EQ(ours, theirs);
    EXPECT_EQ(key_of_passphrase("abc")[0], 0xBA);    // FIPS 180-4
    EXPECT_EQ(key_of_passphrase("abc")[31], 0xAD);
}

TEST(SignatureCheck, accepts_a_packet_once) {
    SignatureCheck check{key()};
    EXPECT_TRUE(check.accepts(PacketView{theirs}, time_of_theirs));
    EXPECT_FALSE(check.accepts(PacketView{theirs}, time_of_theirs));
    EXPECT_TRUE(check.accepts(PacketView{signed_heartbeat(time_of_theirs)}, time_of_theirs));
    EXPECT_TRUE(check.accepts(PacketView{signed_heartbeat(time_of_theirs + 1)}, time_of_theirs));
    EXPECT_FALSE(check.accepts(PacketView{signed_heartbeat(time_of_theirs)}, time_of_theirs));
}

TEST(SignatureCheck, refuses_packets_that_are_old_or_of_another_key_or_not_signed) {
    SignatureCheck check{key()};
    EXPECT_FALSE(check.accepts(PacketView{signed_heartbeat(time_of_theirs)}, time_of_theirs + SignatureCheck::max_age + 1));
    SignatureCheck other{key_of_passphrase("another")};
    EXPECT_FALSE(other.accepts(PacketView{theirs}, time_of_theirs));
    for (std::size_t i = 1; i < theirs.size(); ++i) {
        Bytes changed = theirs;
        changed[i] ^= 0x10;
        if (packet_size(changed) == changed.size()) {
            EXPECT_FALSE(check.accepts(PacketView{changed}, time_of_theirs)) << i;
        }
    }
    const Draft<"HEARTBEAT"> draft;
    Bytes plain(max_packet);
    plain.resize(encode(plain, Version::v2, {255, 190}, 0, draft.row, draft.payload()));
    EXPECT_FALSE(check.accepts(PacketView{plain}, time_of_theirs));
}

}    // namespace
}    // namespace mavlink_signature_tests
