// Sub-pixel alignment of tracks before the initialisation: registers each observation to the view
// in the middle of its track.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "geometry/camera_model.hpp"
#include "initialisation/crop.hpp"
#include "initialisation/local_motion.hpp"
#include "initialisation/outcome.hpp"
#include "initialisation/registration.hpp"

namespace polhode {

/// Images of a problem's frames, and the places where its tracks were detected in them.
struct InitialImages {
  CameraModel camera;
  Crops crops;  ///< kept from problem to problem, as they are too large to copy
  std::array<std::int8_t, limits::kInitialFrames> crop_of{};  ///< by frame; -1: there is none
  std::array<TrackPlaces, limits::kInitialTracks> places;

  /// nullptr where there is none.
  [[nodiscard]] const Crop* crop(std::size_t frame) const {
    return crop_of[frame] < 0 ? nullptr : &crops.kept[static_cast<std::uint8_t>(crop_of[frame])];
  }
};

/// Holds nothing between calls.
struct AlignmentWorkspace {
  /// kSame: another track has its spot.
  enum class Turn : std::uint8_t { kWaits, kAligned, kSame };

  PatchTemplate patch;
  std::array<Turn, limits::kInitialTracks> turns{};
};

/// Moves each observation to the place where the track's middle view is found: alignment to one
/// view does not drift. Follows tracks into frames that missed them, joins tracks of one spot, and
/// drops observations that do not look alike. Observations without an image stay.
/// @cost  at most one registration for each track and frame.
void align_tracks(const InitialImages& images,
                  std::size_t frames,
                  std::span<InitialTrack> tracks,
                  AlignmentWorkspace* workspace);

}  // namespace polhode
