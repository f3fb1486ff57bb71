// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// Offsets of all fields from their packet's first octet.
#pragma once

#include <cstddef>
#include <cstdint>

namespace polhode::bus {

// clang-format off
inline constexpr std::uint8_t kLayoutVersion = 3;

namespace motion_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kQ_CT = 24;  ///< 4 x f64
inline constexpr std::size_t kP_CT = 56;  ///< 3 x f64
inline constexpr std::size_t kV_C = 80;  ///< 3 x f64
inline constexpr std::size_t kW_T_rad_s = 104;  ///< 3 x f64
inline constexpr std::size_t kSigma_att_rad = 128;  ///< f64
inline constexpr std::size_t kSigma_pos = 136;  ///< f64
inline constexpr std::size_t kSigma_vel = 144;  ///< f64
inline constexpr std::size_t kSigma_rate_rad_s = 152;  ///< f64
inline constexpr std::size_t kCov_pose = 160;  ///< 21 x f32
inline constexpr std::size_t kCov_v = 244;  ///< 6 x f32
inline constexpr std::size_t kCov_w = 268;  ///< 6 x f32
inline constexpr std::size_t kFrame = 292;  ///< u32
inline constexpr std::size_t kFeatures = 296;  ///< u16
inline constexpr std::size_t kMatches = 298;  ///< u16
inline constexpr std::size_t kInliers = 300;  ///< u16
inline constexpr std::size_t kLandmarks = 302;  ///< u16
inline constexpr std::size_t kKeyframes = 304;  ///< u16
inline constexpr std::size_t kMode = 306;  ///< u8
inline constexpr std::size_t kFlags = 307;  ///< u8
inline constexpr std::size_t kCrc = 308;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 310;
inline constexpr std::uint8_t kFlagPose = 0x01;
inline constexpr std::uint8_t kFlagRate = 0x02;
inline constexpr std::uint8_t kFlagVelocity = 0x04;
inline constexpr std::uint8_t kFlagScaleKnown = 0x08;
inline constexpr std::uint8_t kFlagsUsed = 0x0F;
inline constexpr unsigned kScaleNumberShift = 4;  ///< its place in the flags
inline constexpr std::uint32_t kScaleNumbers = 16;  ///< it counts modulo this
}  // namespace motion_layout

namespace model_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kW_T_rad_s = 24;  ///< 3 x f64
inline constexpr std::size_t kQ_TB = 48;  ///< 4 x f64
inline constexpr std::size_t kInertia_ratio = 80;  ///< 2 x f64
inline constexpr std::size_t kPeriod_spin_s = 96;  ///< f64
inline constexpr std::size_t kPeriod_precession_s = 104;  ///< f64
inline constexpr std::size_t kMomentum_axis_C = 112;  ///< 3 x f64
inline constexpr std::size_t kV_C = 136;  ///< 3 x f64
inline constexpr std::size_t kC_T = 160;  ///< 3 x f64
inline constexpr std::size_t kCov_w = 184;  ///< 6 x f32
inline constexpr std::size_t kSigma_axes_rad = 208;  ///< 3 x f32
inline constexpr std::size_t kSigma_inertia_ratio = 220;  ///< 2 x f32
inline constexpr std::size_t kSigma_period_spin_s = 228;  ///< f32
inline constexpr std::size_t kSigma_period_precession_s = 232;  ///< f32
inline constexpr std::size_t kSigma_momentum_axis_rad = 236;  ///< f32
inline constexpr std::size_t kCov_v = 240;  ///< 6 x f32
inline constexpr std::size_t kCov_c = 264;  ///< 6 x f32
inline constexpr std::size_t kSpan_s = 288;  ///< f32
inline constexpr std::size_t kChi2_per_dof = 292;  ///< 2 x f32
inline constexpr std::size_t kPoses = 300;  ///< u32
inline constexpr std::size_t kFrame = 304;  ///< u32
inline constexpr std::size_t kDynamics = 308;  ///< u8
inline constexpr std::size_t kRefusal = 309;  ///< u8
inline constexpr std::size_t kClass_axes = 310;  ///< 3 x u8
inline constexpr std::size_t kClass_inertia = 313;  ///< 2 x u8
inline constexpr std::size_t kClass_spin = 315;  ///< u8
inline constexpr std::size_t kClass_precession = 316;  ///< u8
inline constexpr std::size_t kClass_momentum = 317;  ///< u8
inline constexpr std::size_t kClass_mass_centre = 318;  ///< 3 x u8
inline constexpr std::size_t kFlags = 321;  ///< u8
inline constexpr std::size_t kCrc = 322;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 324;
inline constexpr std::uint8_t kFlagRate = 0x01;
inline constexpr std::uint8_t kFlagAxes = 0x02;
inline constexpr std::uint8_t kFlagInertia = 0x04;
inline constexpr std::uint8_t kFlagSpin = 0x08;
inline constexpr std::uint8_t kFlagPrecession = 0x10;
inline constexpr std::uint8_t kFlagVelocity = 0x20;
inline constexpr std::uint8_t kFlagMassCentre = 0x40;
inline constexpr std::uint8_t kFlagScaleKnown = 0x80;
inline constexpr std::uint8_t kFlagsUsed = 0xFF;
}  // namespace model_layout

namespace prediction_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kPredicted_timestamp_ns = 24;  ///< i64
inline constexpr std::size_t kQ_CT = 32;  ///< 4 x f64
inline constexpr std::size_t kP_CT = 64;  ///< 3 x f64
inline constexpr std::size_t kW_T_rad_s = 88;  ///< 3 x f64
inline constexpr std::size_t kCov_pose = 112;  ///< 21 x f32
inline constexpr std::size_t kCov_w = 196;  ///< 6 x f32
inline constexpr std::size_t kFrame = 220;  ///< u32
inline constexpr std::size_t kPoses = 224;  ///< u16
inline constexpr std::size_t kDynamics = 226;  ///< u8
inline constexpr std::size_t kFlags = 227;  ///< u8
inline constexpr std::size_t kCrc = 228;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 230;
inline constexpr std::uint8_t kFlagAttitude = 0x01;
inline constexpr std::uint8_t kFlagRate = 0x02;
inline constexpr std::uint8_t kFlagPosition = 0x04;
inline constexpr std::uint8_t kFlagScaleKnown = 0x08;
inline constexpr std::uint8_t kFlagsUsed = 0x0F;
inline constexpr unsigned kScaleNumberShift = 4;  ///< its place in the flags
inline constexpr std::uint32_t kScaleNumbers = 16;  ///< it counts modulo this
}  // namespace prediction_layout

namespace shape_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kQ_TB = 24;  ///< 4 x f64
inline constexpr std::size_t kCentroid_T = 56;  ///< 3 x f64
inline constexpr std::size_t kCentroid_measured_T = 80;  ///< 3 x f64
inline constexpr std::size_t kDimensions = 104;  ///< 3 x f64
inline constexpr std::size_t kSigma_dimensions = 128;  ///< 3 x f64
inline constexpr std::size_t kMetres_per_mu = 152;  ///< f64
inline constexpr std::size_t kCylinder_axis_T = 160;  ///< 3 x f32
inline constexpr std::size_t kCylinder_centre_T = 172;  ///< 3 x f32
inline constexpr std::size_t kCylinder_radius = 184;  ///< f32
inline constexpr std::size_t kCylinder_length = 188;  ///< f32
inline constexpr std::size_t kCylinder_coverage_rad = 192;  ///< f32
inline constexpr std::size_t kSigma_cylinder_axis_rad = 196;  ///< f32
inline constexpr std::size_t kSigma_cylinder_radius = 200;  ///< f32
inline constexpr std::size_t kSpacing = 204;  ///< f32
inline constexpr std::size_t kThickness = 208;  ///< f32
inline constexpr std::size_t kSigma_scale = 212;  ///< f32
inline constexpr std::size_t kPlane_normal_T = 216;  ///< 36 x f32
inline constexpr std::size_t kPlane_offset = 360;  ///< 12 x f32
inline constexpr std::size_t kPlane_centre_T = 408;  ///< 36 x f32
inline constexpr std::size_t kPlane_extent = 552;  ///< 24 x f32
inline constexpr std::size_t kPlane_sigma = 648;  ///< 36 x f32
inline constexpr std::size_t kFrame = 792;  ///< u32
inline constexpr std::size_t kFrame_of_estimate = 796;  ///< u32
inline constexpr std::size_t kPlane_inliers = 800;  ///< 12 x u16
inline constexpr std::size_t kLandmarks = 824;  ///< u16
inline constexpr std::size_t kCloud_points = 826;  ///< u16
inline constexpr std::size_t kCompletion_points = 828;  ///< u16
inline constexpr std::size_t kPlane_count = 830;  ///< u8
inline constexpr std::size_t kCompletion = 831;  ///< u8
inline constexpr std::size_t kFrame_source = 832;  ///< u8
inline constexpr std::size_t kDimension_basis = 833;  ///< 3 x u8
inline constexpr std::size_t kFlags = 836;  ///< u8
inline constexpr std::size_t kSpare = 837;  ///< u8
inline constexpr std::size_t kCrc = 838;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 840;
inline constexpr std::uint8_t kFlagShape = 0x01;
inline constexpr std::uint8_t kFlagCylinder = 0x02;
inline constexpr std::uint8_t kFlagScaleKnown = 0x04;
inline constexpr std::uint8_t kFlagAxisX = 0x08;
inline constexpr std::uint8_t kFlagAxisY = 0x10;
inline constexpr std::uint8_t kFlagAxisZ = 0x20;
inline constexpr std::uint8_t kFlagsUsed = 0x3F;
}  // namespace shape_layout

namespace housekeeping_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kMemory_octets = 24;  ///< u64
inline constexpr std::size_t kFrame = 32;  ///< u32
inline constexpr std::size_t kFrames_in = 36;  ///< u32
inline constexpr std::size_t kFrames_used = 40;  ///< u32
inline constexpr std::size_t kFrames_unreadable = 44;  ///< u32
inline constexpr std::size_t kFrames_dark = 48;  ///< u32
inline constexpr std::size_t kFrames_wrong_size = 52;  ///< u32
inline constexpr std::size_t kFrames_time_not_increasing = 56;  ///< u32
inline constexpr std::size_t kFrames_held = 60;  ///< u32
inline constexpr std::size_t kFrames_missing = 64;  ///< u32
inline constexpr std::size_t kFrames_flat = 68;  ///< u32
inline constexpr std::size_t kFrames_saturated = 72;  ///< u32
inline constexpr std::size_t kFrames_frozen = 76;  ///< u32
inline constexpr std::size_t kFrames_torn = 80;  ///< u32
inline constexpr std::size_t kFrames_bit_errors = 84;  ///< u32
inline constexpr std::size_t kFrames_blurred = 88;  ///< u32
inline constexpr std::size_t kFrames_with_care = 92;  ///< u32
inline constexpr std::size_t kPoses = 96;  ///< u32
inline constexpr std::size_t kLost = 100;  ///< u32
inline constexpr std::size_t kRelocalised = 104;  ///< u32
inline constexpr std::size_t kRestarts = 108;  ///< u32
inline constexpr std::size_t kStart_contests = 112;  ///< u32
inline constexpr std::size_t kKeyframes_inserted = 116;  ///< u32
inline constexpr std::size_t kKeyframes_culled = 120;  ///< u32
inline constexpr std::size_t kLandmarks_created = 124;  ///< u32
inline constexpr std::size_t kLandmarks_culled = 128;  ///< u32
inline constexpr std::size_t kClosures = 132;  ///< u32
inline constexpr std::size_t kShapes = 136;  ///< u32
inline constexpr std::size_t kJobs_issued = 140;  ///< u32
inline constexpr std::size_t kJobs_without_result = 144;  ///< u32
inline constexpr std::size_t kSteps_short_of_memory = 148;  ///< u32
inline constexpr std::size_t kScale_contradictions = 152;  ///< u32
inline constexpr std::size_t kTables_full = 156;  ///< u32
inline constexpr std::size_t kCommands_accepted = 160;  ///< u32
inline constexpr std::size_t kCommands_rejected = 164;  ///< u32
inline constexpr std::size_t kEvents_sent = 168;  ///< u32
inline constexpr std::size_t kEvents_suppressed = 172;  ///< u32
inline constexpr std::size_t kPackets_not_sent = 176;  ///< u32
inline constexpr std::size_t kTable_crc = 180;  ///< u32
inline constexpr std::size_t kTable_loaded_crc = 184;  ///< u32
inline constexpr std::size_t kTable_entries = 188;  ///< u16
inline constexpr std::size_t kLandmarks = 190;  ///< u16
inline constexpr std::size_t kKeyframes = 192;  ///< u16
inline constexpr std::size_t kCloud_chunks_left = 194;  ///< u16
inline constexpr std::size_t kLast_command = 196;  ///< u8
inline constexpr std::size_t kLast_rejection = 197;  ///< u8
inline constexpr std::size_t kMode = 198;  ///< u8
inline constexpr std::size_t kVersion = 199;  ///< 3 x u8
inline constexpr std::size_t kFlags = 202;  ///< u8
inline constexpr std::size_t kTables_damaged = 203;  ///< u8
inline constexpr std::size_t kCrc = 204;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 206;
inline constexpr std::uint8_t kFlagHeld = 0x01;
inline constexpr std::uint8_t kFlagScaleKnown = 0x02;
inline constexpr std::uint8_t kFlagTableLoaded = 0x04;
inline constexpr std::uint8_t kFlagServicerAttitude = 0x08;
inline constexpr std::uint8_t kFlagFocalLengthDoubted = 0x10;
inline constexpr std::uint8_t kFlagCameraContradicted = 0x20;
inline constexpr std::uint8_t kFlagsUsed = 0x3F;
}  // namespace housekeeping_layout

namespace event_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kValue = 24;  ///< 2 x f64
inline constexpr std::size_t kFrame = 40;  ///< u32
inline constexpr std::size_t kOccurrences = 44;  ///< u32
inline constexpr std::size_t kSuppressed = 48;  ///< u32
inline constexpr std::size_t kId = 52;  ///< u16
inline constexpr std::size_t kSeverity = 54;  ///< u8
inline constexpr std::size_t kText_octets = 55;  ///< u8
inline constexpr std::size_t kText = 56;  ///< 122 x text
inline constexpr std::size_t kCommand_sequence = 178;  ///< u16
inline constexpr std::size_t kCrc = 180;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 182;
}  // namespace event_layout

namespace cloud_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kMetres_per_mu = 24;  ///< f64
inline constexpr std::size_t kPoints_total = 32;  ///< u32
inline constexpr std::size_t kFirst_point = 36;  ///< u32
inline constexpr std::size_t kCloud = 40;  ///< u16
inline constexpr std::size_t kChunk = 42;  ///< u16
inline constexpr std::size_t kChunks = 44;  ///< u16
inline constexpr std::size_t kPoints = 46;  ///< u8
inline constexpr std::size_t kFlags = 47;  ///< u8
inline constexpr std::size_t kP_T = 48;  ///< 330 x f32
inline constexpr std::size_t kCrc = 1368;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 1370;
inline constexpr std::uint8_t kFlagScaleKnown = 0x01;
inline constexpr std::uint8_t kFlagsUsed = 0x01;
}  // namespace cloud_layout

namespace platform_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kResident_octets = 24;  ///< u64
inline constexpr std::size_t kResident_peak_octets = 32;  ///< u64
inline constexpr std::size_t kUptime_s = 40;  ///< u32
inline constexpr std::size_t kFrames_dropped = 44;  ///< u32
inline constexpr std::size_t kCamera_errors = 48;  ///< u32
inline constexpr std::size_t kCamera_reopened = 52;  ///< u32
inline constexpr std::size_t kDeadline_misses = 56;  ///< u32
inline constexpr std::size_t kJobs_late = 60;  ///< u32
inline constexpr std::size_t kLast_step_us = 64;  ///< u32
inline constexpr std::size_t kLongest_step_us = 68;  ///< u32
inline constexpr std::size_t kPackets_sent = 72;  ///< u32
inline constexpr std::size_t kPackets_dropped = 76;  ///< u32
inline constexpr std::size_t kCommands_received = 80;  ///< u32
inline constexpr std::size_t kCommands_dropped = 84;  ///< u32
inline constexpr std::size_t kRestarts = 88;  ///< u16
inline constexpr std::size_t kFlags = 90;  ///< u8
inline constexpr std::size_t kSpare = 91;  ///< u8
inline constexpr std::size_t kCrc = 92;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 94;
inline constexpr std::uint8_t kFlagWatchdog = 0x01;
inline constexpr std::uint8_t kFlagLockedMemory = 0x02;
inline constexpr std::uint8_t kFlagRealTime = 0x04;
inline constexpr std::uint8_t kFlagsUsed = 0x07;
}  // namespace platform_layout

namespace command_link_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kHighest_number = 24;  ///< u64
inline constexpr std::size_t kReceived = 32;  ///< u32
inline constexpr std::size_t kPassed = 36;  ///< u32
inline constexpr std::size_t kRefused_sender = 40;  ///< u32
inline constexpr std::size_t kRefused_form = 44;  ///< u32
inline constexpr std::size_t kRefused_mac = 48;  ///< u32
inline constexpr std::size_t kRefused_number = 52;  ///< u32
inline constexpr std::size_t kDropped = 56;  ///< u32
inline constexpr std::size_t kNumbers_not_kept = 60;  ///< u32
inline constexpr std::size_t kPorts = 64;  ///< u8
inline constexpr std::size_t kFlags = 65;  ///< u8
inline constexpr std::size_t kSpare = 66;  ///< 2 x u8
inline constexpr std::size_t kCrc = 68;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 70;
inline constexpr std::uint8_t kFlagKey = 0x01;
inline constexpr std::uint8_t kFlagUnauthenticated = 0x02;
inline constexpr std::uint8_t kFlagNumberNotKept = 0x04;
inline constexpr std::uint8_t kFlagsUsed = 0x07;
}  // namespace command_link_layout

namespace platform_event_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kValue = 24;  ///< 4 x f64
inline constexpr std::size_t kId = 56;  ///< u16
inline constexpr std::size_t kSeverity = 58;  ///< u8
inline constexpr std::size_t kText_octets = 59;  ///< u8
inline constexpr std::size_t kText = 60;  ///< 122 x text
inline constexpr std::size_t kSpare = 182;  ///< 2 x u8
inline constexpr std::size_t kCrc = 184;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 186;
}  // namespace platform_event_layout

namespace point_layout {
inline constexpr std::size_t kTimestamp_ns = 16;  ///< i64
inline constexpr std::size_t kPredicted_timestamp_ns = 24;  ///< i64
inline constexpr std::size_t kP_C = 32;  ///< 3 x f64
inline constexpr std::size_t kV_C = 56;  ///< 3 x f64
inline constexpr std::size_t kNormal_C = 80;  ///< 3 x f64
inline constexpr std::size_t kCov_p = 104;  ///< 6 x f32
inline constexpr std::size_t kCov_v = 128;  ///< 6 x f32
inline constexpr std::size_t kSigma_normal_rad = 152;  ///< f32
inline constexpr std::size_t kNumber = 156;  ///< u32
inline constexpr std::size_t kTarget_frame = 160;  ///< u32
inline constexpr std::size_t kDynamics = 164;  ///< u8
inline constexpr std::size_t kFlags = 165;  ///< u8
inline constexpr std::size_t kSpare = 166;  ///< 2 x u8
inline constexpr std::size_t kCrc = 168;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 170;
inline constexpr std::uint8_t kFlagPosition = 0x01;
inline constexpr std::uint8_t kFlagVelocity = 0x02;
inline constexpr std::uint8_t kFlagNormal = 0x04;
inline constexpr std::uint8_t kFlagScaleKnown = 0x08;
inline constexpr std::uint8_t kFlagsUsed = 0x0F;
inline constexpr unsigned kScaleNumberShift = 4;  ///< its place in the flags
inline constexpr std::uint32_t kScaleNumbers = 16;  ///< it counts modulo this
}  // namespace point_layout

namespace set_known_length_layout {
inline constexpr std::size_t kFrame_timestamp_ns = 8;  ///< i64
inline constexpr std::size_t kLength_m = 16;  ///< f64
inline constexpr std::size_t kFirst_px = 24;  ///< 2 x f64
inline constexpr std::size_t kSecond_px = 40;  ///< 2 x f64
inline constexpr std::size_t kCrc = 56;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 58;
}  // namespace set_known_length_layout

namespace set_range_layout {
inline constexpr std::size_t kFrame_timestamp_ns = 8;  ///< i64
inline constexpr std::size_t kRange_m = 16;  ///< f64
inline constexpr std::size_t kCrc = 24;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 26;
}  // namespace set_range_layout

namespace servicer_attitude_layout {
inline constexpr std::size_t kTimestamp_ns = 8;  ///< i64
inline constexpr std::size_t kQ_IC = 16;  ///< 4 x f64
inline constexpr std::size_t kW_C_rad_s = 48;  ///< 3 x f64
inline constexpr std::size_t kCrc = 72;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 74;
}  // namespace servicer_attitude_layout

namespace request_cloud_layout {
inline constexpr std::size_t kPoints_max = 8;  ///< u32
inline constexpr std::size_t kCrc = 12;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 14;
}  // namespace request_cloud_layout

namespace table_load_layout {
inline constexpr std::size_t kEntries = 8;  ///< u16
inline constexpr std::size_t kSpare = 10;  ///< 3 x u16
inline constexpr std::size_t kPacketOctets = 18;
}  // namespace table_load_layout

namespace table_activate_layout {
inline constexpr std::size_t kCrc32 = 8;  ///< u32
inline constexpr std::size_t kEntries = 12;  ///< u32
inline constexpr std::size_t kCrc = 16;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 18;
}  // namespace table_activate_layout

namespace predict_point_layout {
inline constexpr std::size_t kPredicted_timestamp_ns = 8;  ///< i64
inline constexpr std::size_t kP_T = 16;  ///< 3 x f64
inline constexpr std::size_t kNormal_T = 40;  ///< 3 x f64
inline constexpr std::size_t kTarget_frame = 64;  ///< u32
inline constexpr std::size_t kNumber = 68;  ///< u32
inline constexpr std::size_t kCrc = 72;  ///< u16 over all octets before it
inline constexpr std::size_t kPacketOctets = 74;
}  // namespace predict_point_layout
// clang-format on

}  // namespace polhode::bus
