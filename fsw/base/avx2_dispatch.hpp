// AVX2 dispatch. Loops over pixels, descriptors and lines are compiled twice where that pays: for
// every processor of the architecture, and for x86 with AVX2. Multiply and add are not fused, and
// no rounded sum is reordered, so both give the same bits.
#pragma once

namespace polhode {

#if defined(__x86_64__)
inline bool has_avx2() { return __builtin_cpu_supports("avx2") != 0; }

/// Everything that `work` calls is compiled into this function, for AVX2.
template <class Work>
[[gnu::target("avx2"), gnu::flatten]] auto run_avx2(const Work& work) {
  return work();
}

/// @param work  a callable without parameters; the functions that it calls are defined in the same
/// source file.
template <class Work>
auto with_avx2(const Work& work) {
  return has_avx2() ? run_avx2(work) : work();
}
#else
template <class Work>
auto with_avx2(const Work& work) {
  return work();
}
#endif

}  // namespace polhode
