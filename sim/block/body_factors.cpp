#include "sim/block/body_factors.h"

#include "sim/base/lane_count.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sim {

/// A column has the blocks of the matrix, and those of the columns of which it is the first one below (their parent in the
/// elimination tree).
void BodyFactors::find_fill(std::span<const std::array<int, 2>> pairs) {
    for (const auto [a, b] : pairs) {
        columns_[static_cast<std::size_t>(std::min(a, b))].below.push_back(std::max(a, b));
    }
    for (Column& column : columns_) {
        std::vector<int>& below = column.below;
        std::ranges::sort(below);
        below.erase(std::unique(below.begin(), below.end()), below.end());
        if (!below.empty()) {
            std::vector<int>& parent = columns_[static_cast<std::size_t>(below.front())].below;
            parent.insert(parent.end(), below.begin() + 1, below.end());
        }
    }
}

void BodyFactors::begin(int count, std::span<const std::array<int, 2>> pairs) {
    columns_.resize(static_cast<std::size_t>(count));
    for (Column& column : columns_) {
        column.below.clear();
    }
    find_fill(pairs);
    std::size_t size = 0;
    for (Column& column : columns_) {
        column.first = size;
        size += 6 * static_cast<std::size_t>(column.rows());
    }
    numbers_.assign(size + lane_count, 0.0); // see subtract_product()
}

void BodyFactors::add(int body, const Matrix6& added) {
    block(columns_[static_cast<std::size_t>(body)], 0) += added;
}

void BodyFactors::add(int a, int b, const Matrix6& added) {
    const Column& column = columns_[static_cast<std::size_t>(std::min(a, b))];
    const auto before = std::ranges::lower_bound(column.below, std::max(a, b)) - column.below.begin();
    block(column, 1 + static_cast<std::size_t>(before)) += a > b ? added : Matrix6(added.transpose());
}

/// For the column of its block `next`, if there is one.
void BodyFactors::wait(std::size_t column, std::size_t next) {
    if (next < columns_[column].below.size()) {
        const auto row = static_cast<std::size_t>(columns_[column].below[next]);
        waiting_[column] = {std::exchange(first_of_[row], static_cast<int>(column)), next};
    }
}

bool BodyFactors::factorise() {
    waiting_.resize(columns_.size());
    first_of_.assign(columns_.size(), -1);
    place_.resize(columns_.size());
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        place_[i] = 0;
        int place = 0;
        for (const int body : columns_[i].below) {
            place_[static_cast<std::size_t>(body)] = ++place;
        }
        for (int at = first_of_[i]; at >= 0;) {
            const auto before = static_cast<std::size_t>(at);
            const auto [after, next] = waiting_[before];
            subtract(columns_[before], next, columns_[i]);
            wait(before, next + 1);
            at = after;
        }
        if (!eliminate(columns_[i])) {
            return false;
        }
        wait(i, 0);
    }
    return true;
}

/// Takes from a column the product of one before it, from its block `next` on, with that block.
void BodyFactors::subtract(const Column& before, std::size_t next, const Column& column) {
    const Part left = block(before, 1 + next);
    const Matrix6 factor = left * Eigen::Map<const Eigen::Matrix<double, 6, 1>>(before.pivots.data()).asDiagonal();
    places_.clear();
    for (const int body : std::span(before.below).subspan(next)) {
        places_.push_back(place_[static_cast<std::size_t>(body)]);
    }
    subtract_product({.from = left.data(),
                      .from_rows = before.rows(),
                      .count = static_cast<int>(places_.size()),
                      .factor = factor.data(), // its columns are the rows of what is multiplied by
                      .to = numbers(column),
                      .to_rows = column.rows(),
                      .places = places_.data()});
}

/// Once all before it have been subtracted.
bool BodyFactors::eliminate(Column& column) {
    const int rows = column.rows();
    for (int k = 0; k < 6; ++k) {
        double* const own = numbers(column) + k * rows;
        const double pivot = own[k];
        if (!(std::abs(pivot) > 0.0)) {
            return false;
        }
        column.pivots[static_cast<std::size_t>(k)] = pivot;
        for (int later = k + 1; later < 6; ++later) {
            double* const other = numbers(column) + later * rows;
            const double share = own[later] / pivot;
            for (int row = later; row < rows; ++row) {
                other[row] -= share * own[row];
            }
        }
        for (int row = k + 1; row < rows; ++row) {
            own[row] /= pivot;
        }
    }
    return true;
}

void BodyFactors::solve(Eigen::VectorXd& x) const {
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    const auto of_body = [&](std::size_t i) { return x.segment<6>(6 * static_cast<Eigen::Index>(i)); };
    // Calls work(block, the body in whose rows it is) for those below the diagonal.
    const auto for_each_below = [&](const Column& column, auto&& work) {
        for (std::size_t k = 0; k < column.below.size(); ++k) {
            work(block(column, 1 + k), static_cast<std::size_t>(column.below[k]));
        }
    };
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        const Matrix6 diagonal = block(columns_[i], 0);
        Vector6 own = of_body(i);
        diagonal.triangularView<Eigen::UnitLower>().solveInPlace(own);
        of_body(i) = own;
        for_each_below(columns_[i], [&](const auto& left, std::size_t body) { of_body(body).noalias() -= left * own; });
    }
    for (std::size_t i = columns_.size(); i-- > 0;) {
        const Matrix6 diagonal = block(columns_[i], 0);
        Vector6 own = of_body(i).cwiseQuotient(Eigen::Map<const Vector6>(columns_[i].pivots.data()));
        for_each_below(columns_[i], [&](const auto& left, std::size_t body) {
            own.noalias() -= left.transpose() * of_body(body);
        });
        diagonal.transpose().triangularView<Eigen::UnitUpper>().solveInPlace(own);
        of_body(i) = own;
    }
}

} // namespace sim
