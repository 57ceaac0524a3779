#include "sim/block/body_factors.h"

#include "sim/base/lane_count.h"

#include <Eigen/OrderingMethods>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace sim {

/// In the graph of bodies, whose edges are a 36th of the matrix's entries.
void BodyFactors::find_order(int count, std::span<const std::array<int, 2>> pairs) {
    std::vector<Eigen::Triplet<double>> edges;
    for (const auto [a, b] : pairs) {
        edges.emplace_back(std::max(a, b), std::min(a, b), 1.0);
    }
    for (int i = 0; i < count; ++i) {
        edges.emplace_back(i, i, 1.0); // what has none counts as dense, and comes last as it is
    }
    Eigen::SparseMatrix<double> graph(count, count);
    graph.setFromTriplets(edges.begin(), edges.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(graph.selfadjointView<Eigen::Lower>(), order);
    place_of_.resize(static_cast<std::size_t>(count));
    columns_.resize(static_cast<std::size_t>(count));
    for (int place = 0; place < count; ++place) {
        Column& column = columns_[static_cast<std::size_t>(place)];
        column.body = order.indices()[place];
        column.below.clear();
        place_of_[static_cast<std::size_t>(column.body)] = place;
    }
}

/// A column has the blocks of the matrix, and those of the columns of which it is the first one below (their parent in the
/// elimination tree).
void BodyFactors::find_fill(std::span<const std::array<int, 2>> pairs) {
    for (const auto& [a, b] : pairs) {
        const auto [first, second] = std::minmax(place_of_[static_cast<std::size_t>(a)], place_of_[static_cast<std::size_t>(b)]);
        columns_[static_cast<std::size_t>(first)].below.push_back(second);
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
    find_order(count, pairs);
    find_fill(pairs);
    std::size_t size = 0;
    for (Column& column : columns_) {
        column.first = size;
        size += 6 * static_cast<std::size_t>(column.rows());
    }
    numbers_.assign(size + lane_count, 0.0); // see subtract_product()
}

void BodyFactors::add(int body, const Matrix6& added) {
    block(columns_[static_cast<std::size_t>(place_of_[static_cast<std::size_t>(body)])], 0) += added;
}

void BodyFactors::add(int a, int b, const Matrix6& added) {
    const int row = place_of_[static_cast<std::size_t>(a)];
    const int place = place_of_[static_cast<std::size_t>(b)];
    const Column& column = columns_[static_cast<std::size_t>(std::min(row, place))];
    const auto before = std::ranges::lower_bound(column.below, std::max(row, place)) - column.below.begin();
    block(column, 1 + static_cast<std::size_t>(before)) += row > place ? added : Matrix6(added.transpose());
}

std::size_t BodyFactors::size() const {
    return std::accumulate(columns_.begin(), columns_.end(), std::size_t{0},
                           [](std::size_t sum, const Column& column) { return sum + column.below.size(); });
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
    row_.resize(columns_.size());
    for (std::size_t i = 0; i < columns_.size(); ++i) {
        row_[i] = 0;
        int row = 0;
        for (const int place : columns_[i].below) {
            row_[static_cast<std::size_t>(place)] = ++row;
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
    rows_.clear();
    for (const int place : std::span(before.below).subspan(next)) {
        rows_.push_back(row_[static_cast<std::size_t>(place)]);
    }
    subtract_product({.from = left.data(),
                      .from_rows = before.rows(),
                      .count = static_cast<int>(rows_.size()),
                      .factor = factor.data(), // its columns are the rows of what is multiplied by
                      .to = numbers(column),
                      .to_rows = column.rows(),
                      .places = rows_.data()});
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
    const auto of = [&](const Column& column) { return x.segment<6>(6 * column.body); };
    // Calls work(block, the column in whose rows it is) for those below the diagonal.
    const auto for_each_below = [&](const Column& column, auto&& work) {
        for (std::size_t k = 0; k < column.below.size(); ++k) {
            work(block(column, 1 + k), columns_[static_cast<std::size_t>(column.below[k])]);
        }
    };
    for (const Column& column : columns_) {
        const Matrix6 diagonal = block(column, 0);
        Vector6 own = of(column);
        diagonal.triangularView<Eigen::UnitLower>().solveInPlace(own);
        of(column) = own;
        for_each_below(column, [&](const auto& left, const Column& below) { of(below).noalias() -= left * own; });
    }
    for (auto column = columns_.rbegin(); column != columns_.rend(); ++column) {
        const Matrix6 diagonal = block(*column, 0);
        Vector6 own = of(*column).cwiseQuotient(Eigen::Map<const Vector6>(column->pivots.data()));
        for_each_below(*column, [&](const auto& left, const Column& below) { own.noalias() -= left.transpose() * of(below); });
        diagonal.transpose().triangularView<Eigen::UnitUpper>().solveInPlace(own);
        of(*column) = own;
    }
}

} // namespace sim
