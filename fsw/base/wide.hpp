// Loops over pixels, descriptors and lines are compiled twice where that pays: for every processor
// of the architecture, and for x86 with registers of 32 octets. Multiply and add are not fused, and
// no sum that rounds is reordered: both give the same bits.
#pragma once

namespace polhode {

#if defined(__x86_64__)
inline bool has_wide_registers() { return __builtin_cpu_supports("avx2") != 0; }

/// Everything that `work` calls is compiled into this function, for wide registers.
template <class Work>
[[gnu::target("avx2"), gnu::flatten]] auto run_wide(const Work& work) {
  return work();
}

/// @param work  a callable without parameters, whose functions this source file holds.
template <class Work>
auto widely(const Work& work) {
  return has_wide_registers() ? run_wide(work) : work();
}
#else
template <class Work>
auto widely(const Work& work) {
  return work();
}
#endif

}  // namespace polhode
