#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "base/crc.hpp"
#include "base/fixed_vector.hpp"
#include "base/ids.hpp"
#include "base/result.hpp"
#include "base/rng.hpp"

namespace polhode::base_test {
namespace {

/// The checksum bit by bit, as the polynomial's definition reads.
std::uint16_t crc_by_bits(const std::vector<std::uint8_t>& bytes) {
  unsigned remainder = 0xFFFFU;
  for (const std::uint8_t byte : bytes) {
    for (unsigned bit = 0; bit < 8; ++bit) {
      const unsigned in = (byte >> (7U - bit)) & 1U;
      const unsigned top = (remainder >> 15U) & 1U;
      remainder = (remainder << 1U) & 0xFFFFU;
      remainder ^= (in ^ top) != 0 ? 0x1021U : 0U;
    }
  }
  return static_cast<std::uint16_t>(remainder);
}

TEST(Crc, HasTheCheckValueOfItsName) {
  const std::string check = "123456789";
  const std::vector<std::uint8_t> bytes(check.begin(), check.end());
  EXPECT_EQ(crc16_ccitt_false(bytes), 0x29B1);
  EXPECT_EQ(crc16_ccitt_false({}), 0xFFFF);
}

TEST(Crc, EqualsTheBitwiseDefinitionAndVanishesOverItself) {
  Rng rng(1, 1);
  for (std::size_t length = 0; length < 300; ++length) {
    std::vector<std::uint8_t> bytes(length);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(rng.next());
    const std::uint16_t crc = crc16_ccitt_false(bytes);
    EXPECT_EQ(crc, crc_by_bits(bytes));
    bytes.push_back(static_cast<std::uint8_t>(crc >> 8U));
    bytes.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    EXPECT_EQ(crc16_ccitt_false(bytes), 0);
  }
}

TEST(FixedVector, HoldsWhatItsCapacityAllowsAndReportsWhenItIsFull) {
  FixedVector<int, 3> v;
  EXPECT_TRUE(v.empty());
  EXPECT_TRUE(v.push_back(1) && v.push_back(2) && v.push_back(3));
  EXPECT_TRUE(v.full());
  EXPECT_FALSE(v.push_back(4));
  EXPECT_EQ(v.size(), 3U);
  EXPECT_EQ(v.back(), 3);
  v.pop_back();
  EXPECT_EQ(v.size(), 2U);
  EXPECT_EQ(v[1], 2);
}

TEST(FixedVector, RemovesAndKeepsTheOrder) {
  FixedVector<int, 5> v;
  for (const int i : {10, 11, 12, 13, 14}) EXPECT_TRUE(v.push_back(i));
  v.erase(1);
  EXPECT_TRUE(std::equal(v.begin(), v.end(), std::array{10, 12, 13, 14}.begin()));
  v.erase(3);
  EXPECT_EQ(v.size(), 3U);
  v.clear();
  EXPECT_TRUE(v.empty());
}

TEST(FixedVector, GrowsWithFreshElements) {
  FixedVector<int, 4> v;
  EXPECT_TRUE(v.push_back(7));
  v.pop_back();
  v.resize(2);
  EXPECT_EQ(v[0], 0);
  EXPECT_EQ(v.view().size(), 2U);
}

using FixedVectorDeathTest = testing::Test;
TEST(FixedVectorDeathTest, StopsAtAnIndexOutOfRange) {
  FixedVector<int, 2> v;
  EXPECT_DEATH(v[0] = 1, "");
  EXPECT_DEATH(v.pop_back(), "");
  EXPECT_DEATH(v.resize(3), "");
  EXPECT_DEATH(v.erase(0), "");
}

TEST(Ids, AreInvalidUntilSetAndKeepTheirIndex) {
  LandmarkId id;
  EXPECT_FALSE(id.valid());
  id = LandmarkId::from_index(42);
  EXPECT_TRUE(id.valid());
  EXPECT_EQ(id.index(), 42U);
  EXPECT_LT(LandmarkId::from_index(1), LandmarkId::from_index(2));
  static_assert(!std::is_convertible_v<LandmarkId, KeyframeId>);
}

TEST(Result, IsAValueOrAnError) {
  const Result<int> value = 5;
  EXPECT_TRUE(value.ok());
  EXPECT_EQ(value.value(), 5);
  const Result<int> code = ErrorCode::kDegenerate;
  EXPECT_FALSE(code.ok());
  EXPECT_EQ(code.error().code, ErrorCode::kDegenerate);
  const Result<int> error = Error{.code = ErrorCode::kBadParameter, .message = "field"};
  EXPECT_FALSE(static_cast<bool>(error));
  EXPECT_EQ(error.error().message, "field");
}

using ResultDeathTest = testing::Test;
TEST(ResultDeathTest, StopsWhereTheWrongSideIsAskedFor) {
  const Result<int> value = 5;
  const Result<int> error = ErrorCode::kDegenerate;
  EXPECT_DEATH((void)value.error(), "");
  EXPECT_DEATH((void)error.value(), "");
}

TEST(Rng, IsAPureFunctionOfSeedStreamAndCount) {
  Rng a(3, 4);
  Rng b(3, 4);
  Rng other_seed(4, 4);
  Rng other_stream(3, 5);
  int same_seed = 0;
  int same_stream = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::uint64_t value = a.next();
    EXPECT_EQ(value, b.next());
    same_seed += value == other_seed.next() ? 1 : 0;
    same_stream += value == other_stream.next() ? 1 : 0;
  }
  EXPECT_EQ(same_seed, 0);
  EXPECT_EQ(same_stream, 0);
}

TEST(Rng, BelowIsEvenAndInRange) {
  Rng rng(5, 0);
  constexpr int kDraws = 70000;
  std::array<int, 7> counts{};
  for (int i = 0; i < kDraws; ++i) {
    const std::uint32_t value = rng.below(7);
    ASSERT_LT(value, 7U);
    ++counts[value];
  }
  double chi2 = 0.0;
  for (const int count : counts) chi2 += std::pow(count - kDraws / 7.0, 2) / (kDraws / 7.0);
  EXPECT_LT(chi2, 22.5);  // 99.9 % of chi-square with 6 degrees of freedom
  EXPECT_EQ(rng.below(1), 0U);
}

TEST(Rng, UniformAndNormalHaveTheirMoments) {
  Rng rng(6, 0);
  constexpr int kDraws = 100000;
  double sum = 0.0;
  double normal_sum = 0.0;
  double normal_square = 0.0;
  double normal_fourth = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double u = rng.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    const double n = rng.normal();
    ASSERT_TRUE(std::isfinite(n));
    normal_sum += n;
    normal_square += n * n;
    normal_fourth += n * n * n * n;
  }
  // Four standard deviations of the means: 0.289, 1, sqrt(2) and sqrt(96) over sqrt(1e5).
  EXPECT_NEAR(sum / kDraws, 0.5, 4.0 * 0.289 / 316.0);
  EXPECT_NEAR(normal_sum / kDraws, 0.0, 4.0 / 316.0);
  EXPECT_NEAR(normal_square / kDraws, 1.0, 4.0 * 1.414 / 316.0);
  EXPECT_NEAR(normal_fourth / kDraws, 3.0, 4.0 * 9.8 / 316.0);
}

}  // namespace
}  // namespace polhode::base_test
