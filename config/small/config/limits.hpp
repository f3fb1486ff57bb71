// The capacities of the small component (CMake preset `small`), which comes before
// config/limits.hpp in the search for headers: 64 MB in all. The same names as there.
#pragma once

#include <cstddef>

namespace polhode::limits {

// A frame's features: half as many as in the standard set give a pose sigma that is larger by 1.4.
inline constexpr std::size_t kFeatures = 450;

// A body 120 px across is enlarged three times, and larger ones less. Its scale space takes 32
// octets a pixel.
inline constexpr std::size_t kWorkingPixels = 240000;

// The longer side of that picture: a boom across the whole picture, enlarged.
inline constexpr std::size_t kWorkingSide = 2048;

// The longer side of a camera's picture.
inline constexpr std::size_t kImageSide = 2048;

// One keyframe per 9 deg over a full turn.
inline constexpr std::size_t kKeyframes = 40;

// Half as many as six faces seen under several lights need, with half the features.
inline constexpr std::size_t kLandmarks = 2500;

// Frames that a start of the map can look back on, collected at every 2 deg of turn at the soonest:
// over 30 deg at least.
inline constexpr std::size_t kStartFrames = 16;

// Tracks held while a map is being started.
inline constexpr std::size_t kStartTracks = 600;

// Points that an absolute pose can use.
inline constexpr std::size_t kPoseMatches = 450;

// Points of the denoised and completed cloud: its landmarks and twice as many that completion adds.
inline constexpr std::size_t kCloudPoints = 8000;

// Planes reported of a body: a box with two panels has ten.
inline constexpr std::size_t kPlanes = 12;

// Sightings of one adjustment: 40 keyframes that tie 300 of their features each.
inline constexpr std::size_t kAdjustmentSightings = 12000;

// Poses that the motion stage looks back on.
inline constexpr std::size_t kMotionPoses = 300;

// Packets of one step.
inline constexpr std::size_t kPacketOctets = 1400;

}  // namespace polhode::limits
