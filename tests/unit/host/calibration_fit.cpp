// The fits from six faces and from samples of all directions, for sensors with known errors.
#include <host/accelerometer_fit.hpp>
#include <host/compass_fit.hpp>
#include <host/least_squares.hpp>

#include <support/random.hpp>

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace ano::host::calibration_fit_tests {
namespace {

double noise(support::Random& random, double most) { return most * (static_cast<double>(random.below(2001u)) / 1000 - 1); }

const AccelerometerCalibration skewed{
    {40, -25, 60}, {1.02, 0.97, 1.05}, {{{1, 0.02, -0.01}, {-0.015, 1, 0.03}, {0.01, -0.02, 1}}}};

// The measurement of a sensor with these errors where the true value is `true_value`.
Vector raw_of(const AccelerometerCalibration& sensor, const Vector& true_value) {
    LeastSquares<3> squares;
    for (std::size_t i = 0; i < 3; ++i) {
        Vector row{};
        for (std::size_t j = 0; j < 3; ++j) row[j] = sensor.error[i][j] * sensor.sensitivity[j];
        squares.add(row, true_value[i]);
    }
    Vector raw = *squares.solution();
    for (std::size_t i = 0; i < 3; ++i) raw[i] += sensor.offset[i];
    return raw;
}

Vector gravity_on(std::size_t face) {
    Vector g{};
    g[face / 2] = face % 2 == 0 ? SixFaces::gravity : -SixFaces::gravity;
    return g;
}

void lie(SixFaces& faces, const Vector& raw, support::Random& random, int samples = 100, double shaking = 4,
         double turning = 0.5) {
    for (int i = 0; i < samples; ++i)
        faces.add({raw[0] + noise(random, shaking), raw[1] + noise(random, shaking), raw[2] + noise(random, shaking)},
                  {noise(random, turning) + 3, noise(random, turning), noise(random, turning)});
}

TEST(LeastSquares, finds_the_best_fit_and_nothing_for_an_underdetermined_problem) {
    LeastSquares<2> line;
    for (int x = 0; x < 5; ++x) line.add({static_cast<double>(x), 1}, 3 * x - 7 + (x % 2 == 0 ? 0 : 0));
    const auto found = line.solution();
    ASSERT_TRUE(found);
    EXPECT_NEAR((*found)[0], 3, 1e-9);
    EXPECT_NEAR((*found)[1], -7, 1e-9);
    LeastSquares<2> open;
    open.add({1, 1}, 2);
    open.add({2, 2}, 4);
    EXPECT_FALSE(open.solution());
}

TEST(AccelerometerCalibration, returns_its_15_values_in_the_order_of_the_parameters) {
    const auto values = skewed.values();
    EXPECT_FLOAT_EQ(values[1], -25);
    EXPECT_FLOAT_EQ(values[5], 1.05f);
    EXPECT_FLOAT_EQ(values[7], 0.02f);     // AEM1_Y
    EXPECT_FLOAT_EQ(values[11], 0.03f);    // AEM2_Z
    EXPECT_EQ(AccelerometerCalibration::of(values).values(), values);
}

TEST(SixFaces, find_which_face_is_up_and_whether_it_is_still) {
    support::Random random{1};
    for (std::size_t face = 0; face < 6; ++face) {
        SixFaces faces;
        EXPECT_FALSE(faces.unrest());
        lie(faces, raw_of(skewed, gravity_on(face)), random);
        EXPECT_TRUE(faces.is_still());
        EXPECT_EQ(faces.face(), static_cast<Face>(face)) << name_of(static_cast<Face>(face));
        EXPECT_TRUE(faces.is_enough(static_cast<Face>(face)));
        EXPECT_EQ(faces.faces_done(), 1u);
    }
}

TEST(SixFaces, accept_no_samples_while_the_device_shakes_turns_or_lies_on_an_edge) {
    support::Random random{1};
    SixFaces faces;
    lie(faces, gravity_on(4), random, 200, 100);
    EXPECT_FALSE(faces.is_still());
    lie(faces, gravity_on(4), random, 200, 1, 20);
    EXPECT_FALSE(faces.is_still());
    lie(faces, {0, 690, 690}, random, 200);
    EXPECT_TRUE(faces.is_still());
    EXPECT_FALSE(faces.face());
    lie(faces, {0, 0, 100}, random, 200);
    EXPECT_FALSE(faces.face()) << "in free fall";
    for (std::size_t face = 0; face < 6; ++face) EXPECT_EQ(faces.samples(static_cast<Face>(face)), 0u);
}

// 50 samples a second, behind a low pass of 1 s during which it was turned; and tilted by 1 °/s.
TEST(SixFaces, do_not_count_samples_while_the_device_settles_or_tilts) {
    SixFaces smooth;
    int n = 0;
    for (; n < 3000 && !smooth.is_enough(Face::z_plus); ++n)
        smooth.add({0, 0, SixFaces::gravity * (1 - 2 * std::exp(-n * 0.02)) + (n % 3 - 1)}, {});
    ASSERT_TRUE(smooth.is_enough(Face::z_plus));
    EXPECT_NEAR(smooth.mean(Face::z_plus)[2], SixFaces::gravity, 4);
    EXPECT_LT(n, 600) << "samples";
    SixFaces tilted;
    for (n = 0; n < 600; ++n) {
        const double angle = n * 0.02 * std::numbers::pi / 180;
        tilted.add({SixFaces::gravity * std::sin(angle), 0, SixFaces::gravity * std::cos(angle)}, {});
    }
    EXPECT_FALSE(tilted.is_enough(Face::z_plus));
}

TEST(SixFaces, find_the_errors_of_a_sensor) {
    support::Random random{1};
    SixFaces faces;
    for (std::size_t face = 0; face < 6; ++face) lie(faces, raw_of(skewed, gravity_on(face)), random);
    ASSERT_TRUE(faces.is_complete());
    const auto fit = faces.fit({});
    ASSERT_TRUE(fit.calibration) << fit.wrong.text();
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(fit.calibration->offset[i], skewed.offset[i], 1.5);
        EXPECT_NEAR(fit.calibration->sensitivity[i], skewed.sensitivity[i], 0.003);
        for (std::size_t j = 0; j < 3; ++j) EXPECT_NEAR(fit.calibration->error[i][j], skewed.error[i][j], 0.003);
    }
    EXPECT_LT(fit.after, 3);
    EXPECT_GT(fit.before, 40);
}

TEST(SixFaces, that_are_no_better_than_before_are_rejected) {
    support::Random random{7};
    SixFaces faces;
    for (std::size_t face = 0; face < 6; ++face) {
        // Every other sample is elsewhere, within the limit of stillness: the half used for the check fits the old values.
        for (int i = 0; i < 100; ++i) {
            Vector raw = raw_of(skewed, gravity_on(face));
            raw[0] += i % 2 == 1 ? 8 + noise(random, 1) : noise(random, 1);
            faces.add(raw, {});
        }
    }
    const auto fit = faces.fit(skewed);
    EXPECT_FALSE(fit.calibration);
    EXPECT_GE(fit.after, fit.before);
    EXPECT_EQ(fit.wrong.text().find("the old values are as good: "), 0u) << fit.wrong.text();
}

TEST(SixFaces, that_were_not_level_are_rejected) {
    support::Random random{1};
    SixFaces faces;
    for (std::size_t face = 0; face < 6; ++face) {
        Vector tilted = gravity_on(face);
        tilted[(face / 2 + 1) % 3] = 380;    // 22 degrees, always to the same side
        lie(faces, tilted, random);
    }
    ASSERT_TRUE(faces.is_complete());
    EXPECT_FALSE(faces.fit({}).calibration);
}

SixFaces laid(const AccelerometerCalibration& sensor, double off, std::uint64_t seed) {
    support::Random random{seed};
    SixFaces faces;
    for (std::size_t face = 0; face < 6; ++face) {
        Vector v = gravity_on(face);
        for (double& axis : v) axis += noise(random, off * SixFaces::gravity);
        const double length = std::hypot(v[0], v[1], v[2]);
        for (double& axis : v) axis *= SixFaces::gravity / length;
        lie(faces, raw_of(sensor, v), random);
    }
    return faces;
}

// cm/s², the largest error of the length over the 26 directions of a cube.
double worst_length(const AccelerometerCalibration& calibration, const AccelerometerCalibration& sensor) {
    double worst = 0;
    for (int i = 0; i < 27; ++i) {
        const Vector d{i % 3 - 1.0, i / 3 % 3 - 1.0, i / 9 - 1.0};
        const double length = std::hypot(d[0], d[1], d[2]);
        if (length == 0) continue;
        const double g = SixFaces::gravity / length;
        const Vector v = calibration.corrected(raw_of(sensor, {g * d[0], g * d[1], g * d[2]}));
        worst = std::max(worst, std::abs(std::hypot(v[0], v[1], v[2]) - SixFaces::gravity));
    }
    return worst;
}

TEST(SixFaces, measure_the_error_matrix_when_they_are_level_and_the_old_matrix_is_wrong) {
    EXPECT_EQ(laid(skewed, 0, 1).choose_measure({}), Measure::direction);
    EXPECT_EQ(laid(skewed, 0.002, 1).choose_measure({}), Measure::direction);
    EXPECT_EQ(laid(skewed, 0, 1).choose_measure(skewed), Measure::length) << "it is right";
    AccelerometerCalibration no_number;
    no_number.error[0][1] = std::nan("");
    EXPECT_EQ(laid(skewed, 0, 1).choose_measure(no_number), Measure::direction);
}

// The same result for a sensor that was good before, and for one with wrong offset and sensitivity.
TEST(SixFaces, that_are_tilted_find_offset_and_sensitivity_and_keep_the_error_matrix) {
    AccelerometerCalibration shifted = skewed;
    for (double& axis : shifted.offset) axis += 20;
    shifted.sensitivity[1] += 0.02;
    for (const auto& [off, most_wrong] : {std::pair{0.01, 8}, {0.02, 0}, {0.05, 0}, {0.08, 0}})
        for (const AccelerometerCalibration& old : {skewed, shifted}) {
            int wrong = 0;
            for (std::uint64_t seed = 1; seed <= 300; ++seed) {
                SixFaces faces = laid(skewed, off, seed);
                faces.measure_by(faces.choose_measure(old));
                wrong += worst_length(faces.fit(old).calibration.value_or(skewed), skewed) > 2;
            }
            EXPECT_LE(wrong, most_wrong) << off << " rad, of 300";
        }
}

TEST(SixFaces, that_are_not_all_measured_are_rejected) {
    support::Random random{1};
    SixFaces faces;
    lie(faces, gravity_on(0), random);
    EXPECT_EQ(faces.fit({}).wrong.text(), "only 1 of 6 faces were measured");
}

// Spread evenly over the sphere, up to `top` of its height.
std::vector<Vector> directions(std::size_t n, double top = 1) {
    std::vector<Vector> all;
    for (std::size_t i = 0; i < n; ++i) {
        const double z = top * (2 * (static_cast<double>(i) + 0.5) / static_cast<double>(n) - 1);
        const double around = static_cast<double>(i) * std::numbers::pi * (3 - std::sqrt(5.0));
        const double r = std::sqrt(1 - z * z);
        all.push_back({r * std::cos(around), r * std::sin(around), z});
    }
    return all;
}

const CompassCalibration iron{{120, -80, 45}, {0.9, 1.1, 1.0 / (0.9 * 1.1)}};

void turn(CompassSphere& sphere, double most_noise, double top = 1, double field = 400) {
    support::Random random{3};
    for (const Vector& d : directions(1000, top)) {
        Vector raw{};
        for (std::size_t i = 0; i < 3; ++i)
            raw[i] = field * d[i] / iron.sensitivity[i] + iron.offset[i] + noise(random, most_noise);
        sphere.add(raw);
    }
}

TEST(CompassSphere, finds_offset_and_sensitivity) {
    CompassSphere sphere;
    turn(sphere, 4);
    ASSERT_TRUE(sphere.is_complete());
    EXPECT_EQ(sphere.coverage(), 1);
    const auto fit = sphere.fit({});
    ASSERT_TRUE(fit.calibration) << fit.wrong.text();
    for (std::size_t i = 0; i < 3; ++i) {
        EXPECT_NEAR(fit.calibration->offset[i], iron.offset[i], 2);
        EXPECT_NEAR(fit.calibration->sensitivity[i], iron.sensitivity[i], 0.01);
    }
    EXPECT_LT(fit.after, 0.02);
    EXPECT_GT(fit.before, 0.1);
    EXPECT_EQ(CompassCalibration::of(fit.calibration->values()).values(), fit.calibration->values());
}

TEST(CompassSphere, shows_which_directions_are_missing) {
    CompassSphere sphere;
    turn(sphere, 1, 0.3);    // a band about the equator
    EXPECT_FALSE(sphere.is_complete());
    EXPECT_GT(sphere.map().count(), 0u);
    EXPECT_LT(sphere.coverage(), CompassSphere::enough);
    EXPECT_EQ(sphere.fit({}).wrong.text().substr(0, 5), "only ");
}

TEST(CompassSphere, stores_a_limited_number_of_samples_of_one_direction) {
    CompassSphere sphere;
    turn(sphere, 1);
    const std::size_t before = sphere.samples();
    for (int i = 0; i < 100'000; ++i) sphere.add({400, 0, 0});
    EXPECT_LE(sphere.samples(), before + CompassSphere::max_in_cell);
}

TEST(CompassSphere, rejects_noise) {
    CompassSphere sphere;
    support::Random random{1};
    for (int i = 0; i < 5000; ++i) sphere.add({noise(random, 400), noise(random, 400), noise(random, 400)});
    ASSERT_TRUE(sphere.is_complete());
    EXPECT_FALSE(sphere.fit({}).calibration);
}

TEST(CompassSphere, that_is_no_better_than_before_is_rejected) {
    CompassSphere sphere;
    turn(sphere, 0);
    const auto fit = sphere.fit(iron);
    EXPECT_TRUE(!fit.calibration || fit.after < fit.before);
    CompassSphere same;
    EXPECT_FALSE(same.fit(iron).calibration);
}

}    // namespace
}    // namespace ano::host::calibration_fit_tests
