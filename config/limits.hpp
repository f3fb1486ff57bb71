// Every capacity of the component, with its reason. Compile-time: a table's size is part of the
// build that is tested. docs/resources.md has what happens when a table is full.
#pragma once

#include <cstddef>

namespace polhode::limits {

// Features of a frame. 800, the default, give 3 to 5 per grid cell of a body. More improve a pose
// as 1/sqrt(N), while matching time grows as N.
inline constexpr std::size_t kFeatures = 1000;

// Pixels of the working image, in which features are detected: the default, 580,000, rounded up.
// Its scale space takes 32 bytes a pixel.
inline constexpr std::size_t kWorkingPixels = 600000;

// The longer side of that image. Chosen: twice a side of 1920 px, for a boom across the image.
// What would be longer is enlarged less.
inline constexpr std::size_t kWorkingSide = 4096;

// The longer side of a camera's image; the upper limit of camera.width_px and camera.height_px.
inline constexpr std::size_t kImageSide = 8192;

// 50 keyframes 2.9 deg apart, then 50 that are 5.7 deg apart (map.keyframe_rotation_min_rad): 430
// deg, which is a full turn and 70 deg about another axis.
inline constexpr std::size_t kKeyframes = 100;

// About 4000 are needed: 400 for each of six faces, which look different under several lights. The
// rest is room for landmarks that are not confirmed yet.
inline constexpr std::size_t kLandmarks = 6000;

// Frames that an initialisation can look back on. They are collected every 2 deg of rotation at the
// soonest, so they span 62 deg or more. Hypothesis selection keeps sets of them in 32 bits.
inline constexpr std::size_t kInitialFrames = 32;

// Pixels of the target's part of a kept frame: 128 x 128, which the budgets have room for. A larger
// part is kept at a fraction of its resolution.
inline constexpr std::size_t kCropPixels = 16384;

// Tracks before there is a map. Chosen: nearly twice the default's 800 features of a frame, as
// tracks end and others begin. Larger: memory and longer selections.
inline constexpr std::size_t kInitialTracks = 1500;

// Tracks that hypotheses of a start are compared on. The cost margin to the depth-reversed solution
// grows as N and its noise as sqrt(N), so fewer decide less; the time of the last adjustments grows
// as N.
inline constexpr std::size_t kSelectionTracks = 512;

// Points that an absolute pose can use: one landmark for each feature.
inline constexpr std::size_t kPoseMatches = kFeatures;

// Points of the denoised and completed cloud: the landmarks and as many that completion adds.
inline constexpr std::size_t kCloudPoints = 2 * kLandmarks;

// Planes reported of a body. A box with two panels has ten; the shape packet has room for twelve.
inline constexpr std::size_t kPlanes = 12;

// Observations of one adjustment: 600 features of each keyframe. The sample's full map has 26,000.
inline constexpr std::size_t kAdjustmentObservations = 600 * kKeyframes;

// Poses that the motion stage looks back on. Chosen: above the default's 300 of a rigid-body fit
// (motion.fit_poses_max). Larger: memory, and longer fits where they are used.
inline constexpr std::size_t kMotionPoses = 512;

// Bytes of one packet. The largest, cloud, has 1370. With the headers of UDP and IP (28) a packet
// still fits into one Ethernet frame (1500).
inline constexpr std::size_t kPacketOctets = 1400;

}  // namespace polhode::limits
