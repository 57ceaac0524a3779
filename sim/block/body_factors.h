#pragma once
/// L D L^T of a sparse symmetric matrix that has six rows and columns a body: one body after the other, its columns less the products
/// of those before them (left-looking; George & Liu 1981, "Computer solution of large sparse positive definite systems"), in the order
/// of approximate minimum degree (Amestoy, Davis & Duff 1996). A general library goes number by number: where many bodies touch each
/// other it takes ten times as long, and slowest steps of heaps twice.
#include "sim/block/panel.h"

#include <Eigen/Core>

#include <array>
#include <span>
#include <vector>

namespace sim {

class BodyFactors {
public:
    using Matrix6 = Eigen::Matrix<double, 6, 6>;

    /// A matrix of zeros; pairs: of bodies between which it may have others.
    void begin(int count, std::span<const std::array<int, 2>> pairs);
    /// Adds to the block of a body.
    void add(int body, const Matrix6& added);
    /// Adds to the block in the rows of body a and the columns of body b, and to its mirror image.
    void add(int a, int b, const Matrix6& added);

    /// What was added becomes L and D. Returns whether it could: not if a pivot is zero, or no number.
    bool factorise();
    /// x = matrix^-1 x [6 a body].
    void solve(Eigen::VectorXd& x) const;

    /// Blocks of L below its diagonal.
    std::size_t size() const;

private:
    /// Of a body, at its place in the order: a block on the diagonal, then those below.
    struct Column {
        int body = -1;
        std::vector<int> below;       ///< places of their bodies, ascending
        std::size_t first = 0;        ///< of its numbers, column by column
        std::array<double, 6> pivots; ///< D
        int rows() const { return 6 + 6 * static_cast<int>(below.size()); }
    };
    /// One before the column under way, that is to be subtracted from the column of its block `next`.
    struct Waiting {
        int after = -1; ///< a column that waits for the same one
        std::size_t next = 0;
    };
    using Stride = Eigen::OuterStride<>;
    using Part = Eigen::Map<Matrix6, 0, Stride>;
    using ConstPart = Eigen::Map<const Matrix6, 0, Stride>;

    double* numbers(const Column& column) { return numbers_.data() + column.first; }
    const double* numbers(const Column& column) const { return numbers_.data() + column.first; }
    /// Its diagonal block, then those below.
    Part block(const Column& column, std::size_t i) { return Part(numbers(column) + 6 * i, Stride(column.rows())); }
    ConstPart block(const Column& column, std::size_t i) const { return ConstPart(numbers(column) + 6 * i, Stride(column.rows())); }
    void find_order(int count, std::span<const std::array<int, 2>> pairs);
    void find_fill(std::span<const std::array<int, 2>> pairs);
    void wait(std::size_t column, std::size_t next);
    void subtract(const Column& before, std::size_t next, const Column& column);
    bool eliminate(Column& column);

    std::vector<int> place_of_; ///< [bodies] in the order
    std::vector<Column> columns_;
    std::vector<double> numbers_;
    // Of factorise():
    std::vector<Waiting> waiting_; ///< [columns]
    std::vector<int> first_of_;    ///< [columns] of those that wait for it; -1: none
    std::vector<int> row_;         ///< [columns] which block of the column under way is theirs
    std::vector<int> rows_;        ///< the same for the blocks of another one
};

} // namespace sim
