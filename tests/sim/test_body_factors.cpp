#include "sim/block/body_factors.h"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <limits>
#include <random>
#include <vector>

using namespace sim;

namespace {

/// A random matrix of bodies in a lattice, each with others near it, and the same dense.
struct Sample {
    BodyFactors factors;
    Eigen::MatrixXd dense;

    Sample(int side, unsigned seed, double stiffness) {
        const int count = side * side * side;
        dense = Eigen::MatrixXd::Zero(6 * count, 6 * count);
        std::mt19937 random(seed);
        std::normal_distribution<double> normal;
        std::vector<std::array<int, 2>> pairs;
        for (int a = 0; a < count; ++a) {
            for (int b = 0; b < a; ++b) {
                const Eigen::Vector3i apart(a % side - b % side, a / side % side - b / side % side, a / side / side - b / side / side);
                if (apart.squaredNorm() <= 2 && random() % 3 > 0) {
                    pairs.push_back(random() % 2 == 0 ? std::array{a, b} : std::array{b, a});
                }
            }
        }
        factors.begin(count, pairs);
        const auto rows = [&] { return Eigen::Matrix<double, 6, 3>::NullaryExpr([&] { return stiffness * normal(random); }).eval(); };
        for (const auto [a, b] : pairs) {
            const Eigen::Matrix<double, 6, 3> of_a = rows();
            const Eigen::Matrix<double, 6, 3> of_b = rows();
            add(a, of_a * of_a.transpose());
            add(b, of_b * of_b.transpose());
            const BodyFactors::Matrix6 between = of_a * of_b.transpose();
            factors.add(a, b, between);
            dense.block<6, 6>(6 * a, 6 * b) += between;
            dense.block<6, 6>(6 * b, 6 * a) += between.transpose();
        }
        for (int i = 0; i < count; ++i) {
            add(i, BodyFactors::Matrix6::Identity());
        }
    }
    void add(int body, const BodyFactors::Matrix6& block) {
        factors.add(body, block);
        dense.block<6, 6>(6 * body, 6 * body) += block;
    }
};

} // namespace

TEST(body_factors, solutions_are_those_of_the_dense_matrix) {
    for (const int side : {1, 2, 3, 4}) {
        for (const double stiffness : {1.0, 1e3}) {
            Sample sample(side, 7u + static_cast<unsigned>(side), stiffness);
            ASSERT_TRUE(sample.factors.factorise());
            const Eigen::VectorXd load = Eigen::VectorXd::Random(sample.dense.rows());
            Eigen::VectorXd x = load;
            sample.factors.solve(x);
            const Eigen::VectorXd expected = sample.dense.ldlt().solve(load);
            const double rounding = 1e-13 * stiffness * stiffness;
            EXPECT_LT((x - expected).norm(), rounding * expected.norm()) << side << ' ' << stiffness;
            EXPECT_LT((sample.dense * x - load).norm(), rounding * load.norm()) << side << ' ' << stiffness;
        }
    }
}

TEST(body_factors, a_matrix_of_fewer_bodies_follows_one_of_more) {
    Sample sample(3, 1, 1.0);
    ASSERT_TRUE(sample.factors.factorise());
    sample.factors.begin(2, std::vector<std::array<int, 2>>{{1, 0}});
    sample.factors.add(0, 2.0 * BodyFactors::Matrix6::Identity());
    sample.factors.add(1, 2.0 * BodyFactors::Matrix6::Identity());
    sample.factors.add(1, 0, BodyFactors::Matrix6::Identity());
    ASSERT_TRUE(sample.factors.factorise());
    Eigen::VectorXd x = Eigen::VectorXd::Constant(12, 3.0);
    sample.factors.solve(x);
    EXPECT_LT((x - Eigen::VectorXd::Ones(12)).norm(), 1e-15);
}

/// Eliminated first, the body in the middle of a star would connect all others; a chain's bodies from the middle on, the ends of it.
TEST(body_factors, the_order_of_elimination_keeps_factors_sparse) {
    constexpr int count = 50;
    std::vector<std::array<int, 2>> star;
    std::vector<std::array<int, 2>> chain;
    for (int i = 1; i < count; ++i) {
        star.push_back({0, i});
        chain.push_back({i * 7 % count, (i - 1) * 7 % count});
    }
    for (const auto& pairs : {star, chain}) {
        BodyFactors factors;
        factors.begin(count, pairs);
        EXPECT_EQ(factors.size(), pairs.size());
    }
}

TEST(body_factors, a_pivot_that_is_zero_or_no_number_is_told) {
    for (const double pivot : {0.0, std::numeric_limits<double>::quiet_NaN()}) {
        BodyFactors factors;
        factors.begin(1, {});
        factors.add(0, BodyFactors::Matrix6((Eigen::Matrix<double, 6, 1>() << 1, 1, pivot, 1, 1, 1).finished().asDiagonal()));
        EXPECT_FALSE(factors.factorise()) << pivot;
    }
}
