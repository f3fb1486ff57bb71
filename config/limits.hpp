// Every capacity of the component, with its reason. Compile-time: a table's size is part of the
// build that is tested.
#pragma once

#include <cstddef>

namespace polhode::limits {

// A frame's features: 800 spread over a body give 3 to 5 per grid cell; past that pose sigma falls
// as 1/sqrt(N) while matching time grows as N.
inline constexpr std::size_t kFeatures = 1000;

// Pixels of the picture that features are sought in: the default, rounded up. Its scale space takes
// 32 octets a pixel.
inline constexpr std::size_t kWorkingPixels = 600000;

// The longer side of that picture: a boom across a camera's whole picture, enlarged.
inline constexpr std::size_t kWorkingSide = 4096;

// The longer side of a camera's picture.
inline constexpr std::size_t kImageSide = 8192;

// 50 of them 3 deg apart, then 50 that are 6 deg apart: a full turn, and what another axis adds.
inline constexpr std::size_t kKeyframes = 100;

// A face sees about 400 landmarks; six faces seen under several lights need about 4000.
inline constexpr std::size_t kLandmarks = 6000;

// Frames that a start of the map can look back on, collected at every 2 deg of turn at the soonest:
// these reach over 62 deg at least. A contest keeps sets of them in 32 bits.
inline constexpr std::size_t kStartFrames = 32;

// Tracks held while a map is being started.
inline constexpr std::size_t kStartTracks = 1500;

// Points that an absolute pose can use.
inline constexpr std::size_t kPoseMatches = 1000;

// Points of the denoised and completed cloud.
inline constexpr std::size_t kCloudPoints = 12000;

// Planes reported of a body: a box with two panels has ten.
inline constexpr std::size_t kPlanes = 12;

// Sightings of one adjustment: 100 keyframes that tie 600 of their features each. The sample's full
// map has 26,000.
inline constexpr std::size_t kAdjustmentSightings = 60000;

// Poses that the motion stage looks back on.
inline constexpr std::size_t kMotionPoses = 512;

// Packets of one step.
inline constexpr std::size_t kPacketOctets = 1400;

}  // namespace polhode::limits
