// Vectors of floats: four lanes, or eight where the processor has AVX2. Each lane is plain IEEE
// arithmetic, so results have the same bits on any machine and with either number.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "base/avx2_dispatch.hpp"

#if defined(__SSE2__)
#include <immintrin.h>
#endif

namespace polhode::sift {

using Lanes4 = float __attribute__((vector_size(16)));

template <class Lanes>
inline constexpr int kLanes = static_cast<int>(sizeof(Lanes) / sizeof(float));

/// All bits of a lane, or none.
template <class Lanes>
using LaneMask = decltype(Lanes{} < Lanes{});

/// Loads from an address that need not be aligned.
template <class Lanes>
Lanes load(const float* from) {
  Lanes v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

template <class Lanes>
void store(Lanes v, float* to) {
  std::memcpy(to, &v, sizeof v);
}

template <class Lanes>
Lanes splat(float value);

template <>
inline Lanes4 splat<Lanes4>(float value) {
  return Lanes4{value, value, value, value};
}

// Written as intrinsics, as plain operators compile to many instructions. Both forms give the same
// bits for numbers that are not NaN.
#if defined(__SSE2__)
inline bool any(LaneMask<Lanes4> mask) {
  return _mm_movemask_epi8(reinterpret_cast<__m128i>(mask)) != 0;
}
inline Lanes4 smaller(Lanes4 a, Lanes4 b) { return _mm_min_ps(a, b); }
inline Lanes4 larger(Lanes4 a, Lanes4 b) { return _mm_max_ps(a, b); }
inline Lanes4 square_root(Lanes4 a) { return _mm_sqrt_ps(a); }
#else
inline bool any(LaneMask<Lanes4> mask) {
  std::uint64_t half[2];
  std::memcpy(half, &mask, sizeof half);
  return (half[0] | half[1]) != 0;
}
inline Lanes4 smaller(Lanes4 a, Lanes4 b) { return a < b ? a : b; }
inline Lanes4 larger(Lanes4 a, Lanes4 b) { return a > b ? a : b; }
inline Lanes4 square_root(Lanes4 a) {
  return Lanes4{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
}
#endif

/// Passes the type of lanes to a callable: `[](auto kind) { using Lanes = typename
/// decltype(kind)::Lanes; }`.
template <class L>
struct LaneKind {
  using Lanes = L;
};

// Eight lanes only with optimisation: without inlining, functions for AVX2 and others pass eight
// lanes by different calling conventions.
#if defined(__x86_64__) && defined(__OPTIMIZE__)
using Lanes8 = float __attribute__((vector_size(32)));

template <>
[[gnu::target("avx2")]] inline Lanes8 splat<Lanes8>(float value) {
  return _mm256_set1_ps(value);
}
[[gnu::target("avx2")]] inline bool any(LaneMask<Lanes8> mask) {
  return _mm256_movemask_epi8(reinterpret_cast<__m256i>(mask)) != 0;
}
[[gnu::target("avx2")]] inline Lanes8 smaller(Lanes8 a, Lanes8 b) { return _mm256_min_ps(a, b); }
[[gnu::target("avx2")]] inline Lanes8 larger(Lanes8 a, Lanes8 b) { return _mm256_max_ps(a, b); }
[[gnu::target("avx2")]] inline Lanes8 square_root(Lanes8 a) { return _mm256_sqrt_ps(a); }

/// Runs `work` with the widest lanes that this processor has.
template <class Work>
void with_lanes(const Work& work) {
  if (has_avx2()) {
    run_avx2([&] { work(LaneKind<Lanes8>{}); });
  } else {
    work(LaneKind<Lanes4>{});
  }
}
#else
template <class Work>
void with_lanes(const Work& work) {
  work(LaneKind<Lanes4>{});
}
#endif

}  // namespace polhode::sift
