// The elementary functions that the program gives itself and its libraries.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <complex>
#include <cstdint>
#include <limits>

#include "base/crc.hpp"
#include "base/rng.hpp"

extern "C" void sincos(double x, double* sine, double* cosine) noexcept;
extern "C" __complex__ double clog(__complex__ double z) noexcept;

namespace polhode::elementary_functions_test {
namespace {

using Function = double (*)(double);
using Reference = long double (*)(long double);

struct Case {
  const char* name;
  Function function;
  Reference reference;
  double low;
  double high;
  double ulps_max;       ///< of SLEEF's own statement
  std::uint32_t digest;  ///< CRC-32 of the results of kDraws arguments, the same on all processors
};

constexpr int kDraws = 100'000;

double drawn(Rng* rng, const Case& c) { return c.low + rng->uniform() * (c.high - c.low); }

std::uint32_t added(double result, std::uint32_t digest) {
  const auto bytes = std::bit_cast<std::array<std::uint8_t, sizeof(double)>>(result);
  return crc32_iso_hdlc(bytes, digest);
}

long double precise(double x) { return static_cast<long double>(x); }

double ulps_off(double found, long double exact) {
  const double nearest = std::abs(static_cast<double>(exact));
  const double ulp = std::nextafter(nearest, std::numeric_limits<double>::infinity()) - nearest;
  return std::abs(static_cast<double>((precise(found) - exact) / precise(ulp)));
}

class ElementaryFunction : public testing::TestWithParam<Case> {};

TEST_P(ElementaryFunction, GivesTheSameBitsOnAllProcessors) {
  const Case& c = GetParam();
  Rng rng(65, 1);
  std::uint32_t digest = 0;
  for (int i = 0; i < kDraws; ++i) {
    digest = added(c.function(drawn(&rng, c)), digest);
  }
  EXPECT_EQ(digest, c.digest) << std::hex << "0x" << digest;
}

TEST_P(ElementaryFunction, IsAsNearAsItsLibrarySays) {
  const Case& c = GetParam();
  Rng rng(65, 2);
  double worst = 0.0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = drawn(&rng, c);
    worst = std::max(worst, ulps_off(c.function(x), c.reference(precise(x))));
  }
  EXPECT_LE(worst, c.ulps_max);
}

INSTANTIATE_TEST_SUITE_P(
    OfTheProgram,
    ElementaryFunction,
    testing::Values(Case{"sin", std::sin, std::sin, -10.0, 10.0, 1.0, 0xA806B227U},
                    Case{"cos", std::cos, std::cos, -10.0, 10.0, 1.0, 0xFBD6EEC6U},
                    Case{"tan", std::tan, std::tan, -1.5, 1.5, 1.0, 0x4ADC75ACU},
                    Case{"asin", std::asin, std::asin, -1.0, 1.0, 1.0, 0xF02632EEU},
                    Case{"acos", std::acos, std::acos, -1.0, 1.0, 1.0, 0x9F056A76U},
                    Case{"atan", std::atan, std::atan, -10.0, 10.0, 1.0, 0x17ED20D1U},
                    Case{"sinh", std::sinh, std::sinh, -4.0, 4.0, 1.0, 0x938DEA0FU},
                    Case{"cosh", std::cosh, std::cosh, -4.0, 4.0, 1.0, 0x666B3284U},
                    Case{"exp", std::exp, std::exp, -40.0, 10.0, 1.0, 0xCEC9690FU},
                    Case{"exp2", std::exp2, std::exp2, -40.0, 10.0, 1.0, 0xDA7388BU},
                    Case{"log2", std::log2, std::log2, 1e-6, 100.0, 1.0, 0x9D98B522U},
                    Case{"log", std::log, std::log, 1e-6, 100.0, 3.5, 0x9D640749U},
                    Case{"log10", std::log10, std::log10, 1e-6, 100.0, 1.0, 0x96B76659U},
                    Case{"log1p", std::log1p, std::log1p, -0.9, 10.0, 1.0, 0xA7800C33U},
                    Case{"cbrt", std::cbrt, std::cbrt, -10.0, 10.0, 1.0, 0x3B3B187AU}),
    [](const testing::TestParamInfo<Case>& one) { return one.param.name; });

TEST(ElementaryFunctions, OfTwoArgumentsGiveTheSameBitsOnAllProcessors) {
  Rng rng(65, 3);
  std::uint32_t digest = 0;
  for (int i = 0; i < kDraws; ++i) {
    const double x = 10.0 * rng.uniform();
    const double y = 6.0 * rng.uniform() - 3.0;
    digest = added(std::pow(x, y), digest);
    digest = added(std::atan2(y, x), digest);
    digest = added(std::hypot(x, y), digest);
    EXPECT_LE(ulps_off(std::pow(x, y), std::pow(precise(x), precise(y))), 1.0) << x << ' ' << y;
    EXPECT_LE(ulps_off(std::atan2(y, x), std::atan2(precise(y), precise(x))), 1.0) << y << ' ' << x;
    EXPECT_LE(ulps_off(std::hypot(x, y), std::hypot(precise(x), precise(y))), 0.51)
        << x << ' ' << y;
  }
  EXPECT_EQ(digest, 0x63104E8AU) << std::hex << "0x" << digest;
}

TEST(ElementaryFunctions, OfSinglePrecisionAreTheDoublesRounded) {
  Rng rng(65, 4);
  for (int i = 0; i < kDraws; ++i) {
    const auto x = static_cast<float>(rng.uniform());
    const auto wide = static_cast<double>(x);
    EXPECT_EQ(std::sin(x), static_cast<float>(std::sin(wide)));
    EXPECT_EQ(std::cos(x), static_cast<float>(std::cos(wide)));
    EXPECT_EQ(std::exp(x), static_cast<float>(std::exp(wide)));
    EXPECT_EQ(std::exp2(x), static_cast<float>(std::exp2(wide)));
    EXPECT_EQ(std::log2(x), static_cast<float>(std::log2(wide)));
    EXPECT_EQ(std::acos(x), static_cast<float>(std::acos(wide)));
    EXPECT_EQ(std::pow(x, 0.3F), static_cast<float>(std::pow(wide, static_cast<double>(0.3F))));
  }
}

TEST(ElementaryFunctions, SineAndCosineTogetherAreEachAlone) {
  Rng rng(65, 5);
  for (int i = 0; i < kDraws; ++i) {
    const double x = 20.0 * rng.uniform() - 10.0;
    double sine = 0.0;
    double cosine = 0.0;
    sincos(x, &sine, &cosine);
    ASSERT_LE(ulps_off(sine, std::sin(precise(x))), 1.0) << x;
    ASSERT_LE(ulps_off(cosine, std::cos(precise(x))), 1.0) << x;
  }
}

TEST(ElementaryFunctions, OfArgumentsWithoutAResultSayIt) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  volatile double none = -1.0;  // else the compiler takes them for known
  volatile double zero = 0.0;
  EXPECT_TRUE(std::isnan(std::log(none)));
  EXPECT_TRUE(std::isnan(std::acos(2.0 * none)));
  EXPECT_TRUE(std::isnan(std::pow(none, 0.5)));
  EXPECT_EQ(std::log(zero), -kInfinite);
  EXPECT_EQ(std::exp(1e4 * none), 0.0);
  EXPECT_EQ(std::exp(-1e4 * none), kInfinite);
  EXPECT_EQ(std::pow(zero, zero), 1.0);
  EXPECT_EQ(std::hypot(kInfinite * none, zero), kInfinite);
  EXPECT_EQ(std::atan2(zero, none), static_cast<double>(std::acos(-1.0L)));
  EXPECT_TRUE(std::isnan(std::sin(kInfinite * none)));
  EXPECT_EQ(std::log1p(none), -kInfinite);
}

TEST(ElementaryFunctions, TheComplexLogarithmIsThatOfSizeAndAngle) {
  __complex__ double z = 0.0;
  __real__ z = -3.0;
  __imag__ z = 4.0;
  const __complex__ double found = clog(z);
  EXPECT_DOUBLE_EQ(__real__ found, std::log(5.0));
  EXPECT_DOUBLE_EQ(__imag__ found, std::atan2(4.0, -3.0));
}

}  // namespace
}  // namespace polhode::elementary_functions_test
