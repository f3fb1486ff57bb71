// The capacities of the small component (CMake preset `small`), which comes before
// config/limits.hpp in the search for headers: 72 MiB in all. The same names as there.
#pragma once

#include <cstddef>

namespace polhode::limits {

// Features of a frame. Half as many as in the standard set give a pose sigma larger by 1.4.
inline constexpr std::size_t kFeatures = 450;

// Pixels of the working image, in which features are detected: a square of 163 px is enlarged
// three times, larger ones less. Fewer cost accuracy at once (docs/resources.md). Its scale space
// takes 32 bytes a pixel.
inline constexpr std::size_t kWorkingPixels = 240000;

// The longer side of that image. Chosen: three times a side of 640 px, for a boom across the image.
inline constexpr std::size_t kWorkingSide = 2048;

// The longer side of a camera's image. Chosen: three times that of config/small.toml.
inline constexpr std::size_t kImageSide = 2048;

// 360 deg at 9 deg each, the spacing that so few leave over a full turn.
inline constexpr std::size_t kKeyframes = 40;

// Half as many as six faces need under several lights, as there are half the features.
inline constexpr std::size_t kLandmarks = 2500;

// Frames that an initialisation can look back on. They are collected every 2 deg of rotation at the
// soonest, so they span 30 deg or more.
inline constexpr std::size_t kInitialFrames = 16;

// Pixels of the target's part of a kept frame: 110 x 110.
inline constexpr std::size_t kCropPixels = 12100;

// Tracks before there is a map. Chosen: 1.5 times the 400 features of a frame (config/small.toml).
inline constexpr std::size_t kInitialTracks = 600;

// Tracks that hypotheses of a start are compared on. Half as many as in the standard set.
inline constexpr std::size_t kSelectionTracks = 256;

// Points that an absolute pose can use: one landmark for each feature.
inline constexpr std::size_t kPoseMatches = kFeatures;

// Points of the denoised and completed cloud: 2500 landmarks, twice as many that completion adds,
// and 500 to spare.
inline constexpr std::size_t kCloudPoints = 8000;

// Planes reported of a body. A box with two panels has ten; the shape packet has room for twelve.
inline constexpr std::size_t kPlanes = 12;

// Observations of one adjustment: 300 features of each keyframe.
inline constexpr std::size_t kAdjustmentObservations = 300 * kKeyframes;

// Poses that the motion stage looks back on. Chosen: above the 200 of a rigid-body fit
// (config/small.toml).
inline constexpr std::size_t kMotionPoses = 300;

// Bytes of one packet, as in the standard set.
inline constexpr std::size_t kPacketOctets = 1400;

}  // namespace polhode::limits
