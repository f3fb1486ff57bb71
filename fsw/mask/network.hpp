// What an optional neural network may add to the outline of keyframes. The flight software knows no
// network: it asks a function that the machine's side hands over. Nothing depends on it.
#pragma once

namespace polhode {

struct MaskNetwork {
  /// Of the square pictures that it sees and gives, rows one after the other.
  static constexpr int kSide_px = 128;

  /// @param gray 0 .. 1. @param outline 1 on what is taken for the target so far, else 0.
  /// @param target probability, 0 .. 1.
  /// @return false: it has nothing to say. Must be a function of the two pictures alone, and must
  /// not throw.
  using Ask = bool (*)(void* context, const float* gray, const float* outline, float* target);

  Ask ask = nullptr;  ///< null: there is none
  void* context = nullptr;
};

}  // namespace polhode
