// Linear least squares of a few unknowns.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

namespace ano::host {

/// The unknowns x with the least sum of (row · x - wanted)² over all rows added.
template <std::size_t N>
class LeastSquares {
public:
    using Row = std::array<double, N>;

    void add(const Row& row, double wanted) noexcept {
        for (std::size_t i = 0; i < N; ++i) {
            for (std::size_t j = 0; j < N; ++j) normal_[i][j] += row[i] * row[j];
            right_[i] += row[i] * wanted;
        }
    }

    /// std::nullopt if the rows do not determine all unknowns.
    std::optional<Row> solution() const noexcept {
        auto a = normal_;
        Row b = right_;
        double largest = 0;
        for (std::size_t i = 0; i < N; ++i) largest = std::max(largest, std::abs(a[i][i]));
        for (std::size_t k = 0; k < N; ++k) {
            std::size_t pivot = k;
            for (std::size_t i = k + 1; i < N; ++i)
                if (std::abs(a[i][k]) > std::abs(a[pivot][k])) pivot = i;
            if (!(std::abs(a[pivot][k]) > largest * 1e-12)) return std::nullopt;
            std::swap(a[k], a[pivot]);
            std::swap(b[k], b[pivot]);
            for (std::size_t i = k + 1; i < N; ++i) {
                const double factor = a[i][k] / a[k][k];
                for (std::size_t j = k; j < N; ++j) a[i][j] -= factor * a[k][j];
                b[i] -= factor * b[k];
            }
        }
        Row x{};
        for (std::size_t k = N; k-- > 0;) {
            double rest = b[k];
            for (std::size_t j = k + 1; j < N; ++j) rest -= a[k][j] * x[j];
            x[k] = rest / a[k][k];
        }
        return x;
    }

private:
    std::array<Row, N> normal_{};
    Row right_{};
};

}    // namespace ano::host
