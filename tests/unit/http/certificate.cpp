#include <http/client/certificate.hpp>
#include <support/temp_dir.hpp>

#include <gtest/gtest.h>

#include <sys/stat.h>

namespace anogate::http::certificate_tests {
namespace {

TEST(Certificate, is_created_with_a_key_that_only_its_owner_can_read) {
    support::TempDir dir;
    const auto made = make_certificate({{"vehicle.local", "localhost"}, {"192.168.1.5", "fe80::1"}}, dir / "cert", dir / "key");
    ASSERT_TRUE(made) << made.error();
    struct stat facts {};
    ASSERT_EQ(::stat((dir / "key").c_str(), &facts), 0);
    EXPECT_EQ(facts.st_mode & 0777, 0600u);
}

TEST(Certificate, never_overwrites_an_existing_file) {
    support::TempDir dir;
    dir.write("cert", "mine");
    const auto made = make_certificate({{"vehicle"}, {}}, dir / "cert", dir / "key");
    ASSERT_FALSE(made);
    EXPECT_EQ(made.error(), (dir / "cert") + ": File exists");
    EXPECT_FALSE(std::filesystem::exists(dir / "key")) << "half a pair is of no use";
    dir.write("key", "mine");
    EXPECT_EQ(make_certificate({{"vehicle"}, {}}, dir / "other", dir / "key").error(), (dir / "key") + ": File exists");
    EXPECT_FALSE(std::filesystem::exists(dir / "other"));
}

TEST(Certificate, for_an_invalid_address_is_rejected) {
    support::TempDir dir;
    EXPECT_FALSE(make_certificate({{"vehicle"}, {"nowhere"}}, dir / "cert", dir / "key"));
    EXPECT_FALSE(std::filesystem::exists(dir / "key"));
}

TEST(Certificate, is_identified_by_its_fingerprint) {
    support::TempDir dir;
    ASSERT_TRUE(make_certificate({{"vehicle"}, {}}, dir / "cert", dir / "key"));
    const auto known = fingerprint(dir / "cert");
    ASSERT_TRUE(known) << known.error();
    EXPECT_EQ(known->size(), 32u * 3 - 1);
    EXPECT_EQ(known->find_first_not_of("0123456789ABCDEF:"), std::string::npos) << *known;
    EXPECT_EQ(fingerprint(dir / "none").error(), (dir / "none") + ": No such file or directory");
    EXPECT_EQ(fingerprint(dir / "key").error(), (dir / "key") + ": not a PEM certificate");
}

}    // namespace
}    // namespace anogate::http::certificate_tests
