// The calibration of a compass from samples of all directions.
#pragma once
#include <host/accelerometer_fit.hpp>

#include <array>
#include <bitset>
#include <cstddef>
#include <vector>

namespace ano::host {

/// corrected = diag(S) · (raw − O): maps an ellipsoid along the axes to a sphere of the same size.
struct CompassCalibration {
    Vector offset{};
    Vector sensitivity{1, 1, 1};

    Vector corrected(const Vector& raw) const noexcept;
    /// Not finite if `corrected` has no inverse.
    Vector raw_of(const Vector& corrected) const noexcept;
    /// In the order of its parameters (protocol text, section 4): CAL_MOFF_, CAL_MSEN_, each X Y Z.
    std::array<float, 6> values() const noexcept;
    static CompassCalibration of(const std::array<float, 6>& values) noexcept;
};

/// Collects samples (0x02) from all directions, and shows which directions are missing.
class CompassSphere {
public:
    /// Cells of equal area: bands of z from -1 to 1, sectors around it from the x axis. Cell = band * sectors + sector.
    static constexpr std::size_t bands = 6, sectors = 12, cells = bands * sectors;
    static constexpr std::size_t max_in_cell = 12;    // further samples in a cell are ignored
    static constexpr double enough = 0.8;             // share of the cells that completes the sphere
    static constexpr std::size_t min_samples = 200;
    static constexpr double max_residual = 0.15;    // as a share of the field; a larger one means magnetic disturbance

    void add(const Vector& raw);

    /// The cells that have samples. Until the centre is known, the middle of all samples is used.
    const std::bitset<cells>& map() const noexcept { return covered_; }
    double coverage() const noexcept { return static_cast<double>(covered_.count()) / double{cells}; }
    std::size_t samples() const noexcept { return samples_.size(); }
    bool is_complete() const noexcept { return samples_.size() >= min_samples && coverage() >= enough; }

    /// Computed from one half of the samples and checked with the other half: rejected if the residual is not below that of
    /// `old`. Residuals are standard deviations of the field's strength, as a share of it.
    Fit<CompassCalibration> fit(const CompassCalibration& old) const;
    /// The mean strength of the field in these samples, corrected by `calibration`.
    double strength(const CompassCalibration& calibration) const noexcept;
    static std::size_t cell_of(const Vector& from_centre) noexcept;
    /// As a share of the field, of one half of the samples; see fit(). `device`: the calibration with which the device has
    /// corrected them.
    double residual(const CompassCalibration& calibration, const CompassCalibration& device = {}) const noexcept;

private:
    void cover_again();
    std::optional<CompassCalibration> solve() const noexcept;

    std::vector<Vector> samples_;
    Vector min_{}, max_{};
    Vector centre_{};
    std::bitset<cells> covered_;
    std::array<std::size_t, cells> in_cell_{};
};

}    // namespace ano::host
