// Four floats side by side. Each lane is plain IEEE arithmetic, so the result has the same bits on
// any machine.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace polhode::sift {

inline constexpr int kLanes = 4;
using Lanes = float __attribute__((vector_size(16)));
using LaneMask = std::int32_t __attribute__((vector_size(16)));  ///< all bits of a lane, or none

/// From an address that need not be aligned.
inline Lanes load(const float* from) {
  Lanes v;
  std::memcpy(&v, from, sizeof v);
  return v;
}

inline void store(Lanes v, float* to) { std::memcpy(to, &v, sizeof v); }

inline Lanes splat(float value) { return Lanes{value, value, value, value}; }

// What plain operators would say in many instructions. Neither form has rounding, nor do they
// differ for numbers that are not NaN.
#if defined(__SSE2__)
inline bool any(LaneMask mask) { return _mm_movemask_epi8(reinterpret_cast<__m128i>(mask)) != 0; }
inline Lanes smaller(Lanes a, Lanes b) { return _mm_min_ps(a, b); }
inline Lanes larger(Lanes a, Lanes b) { return _mm_max_ps(a, b); }
inline Lanes square_root(Lanes a) { return _mm_sqrt_ps(a); }
#else
inline bool any(LaneMask mask) {
  std::uint64_t half[2];
  std::memcpy(half, &mask, sizeof half);
  return (half[0] | half[1]) != 0;
}
inline Lanes smaller(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes larger(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes square_root(Lanes a) {
  return Lanes{std::sqrt(a[0]), std::sqrt(a[1]), std::sqrt(a[2]), std::sqrt(a[3])};
}
#endif

}  // namespace polhode::sift
