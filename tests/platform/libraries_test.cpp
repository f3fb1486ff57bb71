// What libraries would do by the machine that they find.
#include "os/linux/libraries.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cstddef>

#include "base/rng.hpp"

namespace polhode::platform::libraries_test {
namespace {

/// So long that a small cache has it cut into parts.
Eigen::MatrixXd long_matrix(std::uint64_t seed) {
  Rng rng(seed, 3);
  Eigen::MatrixXd matrix(60, 2000);
  for (Eigen::Index i = 0; i < matrix.size(); ++i) {
    matrix(i % matrix.rows(), i / matrix.rows()) = rng.uniform();
  }
  return matrix;
}

/// Eigen cuts long sums by the sizes of the caches.
TEST(Libraries, ProductsOfMatricesDoNotDependOnTheCachesOfTheMachine) {
  constexpr std::ptrdiff_t kKib = 1024;
  const Eigen::MatrixXd a = long_matrix(1);
  const Eigen::MatrixXd b = long_matrix(2);
  pin_libraries();
  const Eigen::MatrixXd pinned = a * b.transpose();
  Eigen::setCpuCacheSizes(16 * kKib, 256 * kKib, 4 * kKib * kKib);
  const Eigen::MatrixXd by_other_caches = a * b.transpose();
  EXPECT_NE(pinned, by_other_caches) << "else the test says nothing";
  pin_libraries();
  EXPECT_EQ(pinned, a * b.transpose());
}

}  // namespace
}  // namespace polhode::platform::libraries_test
