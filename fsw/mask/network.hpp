// Interface of an optional segmentation network for keyframes' outlines. The flight software knows
// no network: it calls a function that the platform hands over. Nothing depends on it.
#pragma once

namespace polhode {

struct MaskNetwork {
  /// Side of its square input and output, row by row. Chosen; larger costs time by its square.
  static constexpr int kSide_px = 128;

  /// @param gray 0 .. 1. @param outline 1 on the target as found so far, else 0.
  /// @param target probability, 0 .. 1.
  /// @return false: no answer. Must be a function of the two images alone, and must not throw.
  using Ask = bool (*)(void* context, const float* gray, const float* outline, float* target);

  Ask ask = nullptr;  ///< null: there is none
  void* context = nullptr;
};

}  // namespace polhode
