#include "sim/block/body_factors.h"

#include "sim/base/sort_once.h"

#include <Eigen/OrderingMethods>

#include <algorithm>
#include <cmath>

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
        sort_once(below);
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
        column.diagonal.setZero();
        column.first = size;
        size += column.below.size();
    }
    below_.assign(size, Matrix6::Zero());
}

std::size_t BodyFactors::products() const {
    std::size_t sum = 0;
    for (const Column& column : columns_) {
        sum += column.below.size() * (column.below.size() + 1) / 2;
    }
    return sum;
}

void BodyFactors::add(int body, const Matrix6& added) {
    columns_[static_cast<std::size_t>(place_of_[static_cast<std::size_t>(body)])].diagonal += added;
}

void BodyFactors::add(int a, int b, const Matrix6& added) {
    const int row = place_of_[static_cast<std::size_t>(a)];
    const int place = place_of_[static_cast<std::size_t>(b)];
    const Column& column = columns_[static_cast<std::size_t>(std::min(row, place))];
    const auto before = std::ranges::lower_bound(column.below, std::max(row, place)) - column.below.begin();
    below_[column.first + static_cast<std::size_t>(before)] += row > place ? added : Matrix6(added.transpose());
}

bool BodyFactors::factorise() {
    for (Column& column : columns_) {
        if (!divide(column)) {
            return false;
        }
        for (std::size_t k = 0; k < column.below.size(); ++k) {
            subtract(column, k);
        }
    }
    return true;
}

/// Its blocks become those of L and D.
bool BodyFactors::divide(Column& column) {
    const std::span below = std::span(below_).subspan(column.first, column.below.size());
    Matrix6& own = column.diagonal;
    for (int k = 0; k < 6; ++k) {
        const double pivot = own(k, k);
        if (!(std::abs(pivot) > 0.0)) {
            return false;
        }
        column.pivots[k] = pivot;
        for (int later = k + 1; later < 6; ++later) {
            const double share = own(later, k) / pivot;
            own.col(later) -= share * own.col(k);
            for (Matrix6& block : below) {
                block.col(later) -= share * block.col(k);
            }
        }
        own.col(k) /= pivot;
        for (Matrix6& block : below) {
            block.col(k) /= pivot;
        }
    }
    return true;
}

/// Takes its products with its k-th block below the diagonal from the column of that.
void BodyFactors::subtract(const Column& column, std::size_t k) {
    const std::span below = std::span(below_).subspan(column.first, column.below.size());
    const Matrix6 factor = column.pivots.asDiagonal() * below[k].transpose();
    Column& other = columns_[static_cast<std::size_t>(column.below[k])];
    other.diagonal.noalias() -= below[k].lazyProduct(factor);
    std::size_t at = 0;
    for (std::size_t i = k + 1; i < below.size(); ++i) {
        while (other.below[at] != column.below[i]) {
            ++at;
        }
        below_[other.first + at].noalias() -= below[i].lazyProduct(factor);
    }
}

void BodyFactors::solve(Eigen::VectorXd& x) const {
    const auto of = [&](const Column& column) { return x.segment<6>(6 * column.body); };
    // Calls work(block, the column in whose rows it is) for those below the diagonal.
    const auto for_each_below = [&](const Column& column, auto&& work) {
        for (std::size_t k = 0; k < column.below.size(); ++k) {
            work(below_[column.first + k], columns_[static_cast<std::size_t>(column.below[k])]);
        }
    };
    for (const Column& column : columns_) {
        Vector6 own = of(column);
        column.diagonal.triangularView<Eigen::UnitLower>().solveInPlace(own);
        of(column) = own;
        for_each_below(column, [&](const Matrix6& block, const Column& below) { of(below).noalias() -= block * own; });
    }
    for (auto column = columns_.rbegin(); column != columns_.rend(); ++column) {
        Vector6 own = of(*column).cwiseQuotient(column->pivots);
        for_each_below(*column, [&](const Matrix6& block, const Column& below) { own.noalias() -= block.transpose() * of(below); });
        column->diagonal.transpose().triangularView<Eigen::UnitUpper>().solveInPlace(own);
        of(*column) = own;
    }
}

} // namespace sim
