#pragma once
/// L D L^T of a sparse symmetric matrix that has six rows and columns a body: one body is eliminated after the other (George &
/// Liu 1981, "Computer solution of large sparse positive definite systems"), in the order of approximate minimum degree (Amestoy,
/// Davis & Duff 1996). A general library goes number by number: heaps take up to a tenth longer, and their slowest steps two to three
/// times as long.
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

    /// [-] of two blocks that factorise() takes.
    std::size_t products() const;
    /// What was added becomes L and D. Returns whether it could: not if a pivot is zero, or no number.
    bool factorise();
    /// x = matrix^-1 x [6 a body].
    void solve(Eigen::VectorXd& x) const;

    /// Blocks of L below its diagonal.
    std::size_t size() const { return below_.size(); }

private:
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    /// Of a body, at its place in the order.
    struct Column {
        int body = -1;
        std::vector<int> below; ///< places of those that have a block below the diagonal, ascending
        std::size_t first = 0;  ///< of these blocks
        Matrix6 diagonal;
        Vector6 pivots; ///< D
    };
    void find_order(int count, std::span<const std::array<int, 2>> pairs);
    void find_fill(std::span<const std::array<int, 2>> pairs);
    bool divide(Column& column);
    void subtract(const Column& column, std::size_t k);

    std::vector<int> place_of_; ///< [bodies] in the order
    std::vector<Column> columns_;
    std::vector<Matrix6> below_; ///< column by column
};

} // namespace sim
