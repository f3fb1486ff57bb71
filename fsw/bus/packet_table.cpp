// Written by tools/generate_bus.py from config/bus/*.toml: change those.
#include <cstddef>

#include "bus/packets.hpp"

namespace polhode::bus {
namespace {

// clang-format off
constexpr Field kMotionPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(MotionPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"q_CT", FieldType::kF64, 4, true, 24, offsetof(MotionPacket, q_CT), 0, -1.0, 1.0, "w x y z", "", "", {}},
    {"p_CT", FieldType::kF64, 3, true, 56, offsetof(MotionPacket, p_CT), 0, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"v_C", FieldType::kF64, 3, true, 80, offsetof(MotionPacket, v_C), 2, -kNoLimit, kNoLimit, "x y z", "length/s", "", {}},
    {"w_T_rad_s", FieldType::kF64, 3, true, 104, offsetof(MotionPacket, w_T_rad_s), 1, -kNoLimit, kNoLimit, "x y z", "rad/s", "", {}},
    {"sigma_att_rad", FieldType::kF64, 1, false, 128, offsetof(MotionPacket, sigma_att_rad), 0, 0.0, kNoLimit, "", "rad", "", {}},
    {"sigma_pos", FieldType::kF64, 1, false, 136, offsetof(MotionPacket, sigma_pos), 0, 0.0, kNoLimit, "", "length", "", {}},
    {"sigma_vel", FieldType::kF64, 1, false, 144, offsetof(MotionPacket, sigma_vel), 2, 0.0, kNoLimit, "", "length/s", "", {}},
    {"sigma_rate_rad_s", FieldType::kF64, 1, false, 152, offsetof(MotionPacket, sigma_rate_rad_s), 1, 0.0, kNoLimit, "", "rad/s", "", {}},
    {"cov_pose", FieldType::kF32, 21, true, 160, offsetof(MotionPacket, cov_pose), 0, -kNoLimit, kNoLimit, "", "rad and length", "", {}},
    {"cov_v", FieldType::kF32, 6, true, 244, offsetof(MotionPacket, cov_v), 2, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "(length/s)^2", "", {}},
    {"cov_w", FieldType::kF32, 6, true, 268, offsetof(MotionPacket, cov_w), 1, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "(rad/s)^2", "", {}},
    {"frame", FieldType::kU32, 1, false, 292, offsetof(MotionPacket, frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"features", FieldType::kU16, 1, false, 296, offsetof(MotionPacket, features), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"matches", FieldType::kU16, 1, false, 298, offsetof(MotionPacket, matches), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"inliers", FieldType::kU16, 1, false, 300, offsetof(MotionPacket, inliers), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"landmarks", FieldType::kU16, 1, false, 302, offsetof(MotionPacket, landmarks), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"keyframes", FieldType::kU16, 1, false, 304, offsetof(MotionPacket, keyframes), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"mode", FieldType::kU8, 1, false, 306, offsetof(MotionPacket, mode), -1, 0.0, 4.0, "", "", "IDLE ACQUIRING TRACKING LOST COASTING", {}},
    {"flags", FieldType::kU8, 1, false, 307, offsetof(MotionPacket, flags), -1, 0.0, 255.0, "", "", "", {}},
};
constexpr Layout kMotionPacketLayout{"motion", 0, 310, kMotionPacket, offsetof(MotionPacket, flags), "pose rate velocity scale_known", "scale_number"};
static_assert(sizeof(MotionPacket) <= kStructOctetsMax);

constexpr Field kModelPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(ModelPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"w_T_rad_s", FieldType::kF64, 3, true, 24, offsetof(ModelPacket, w_T_rad_s), 0, -kNoLimit, kNoLimit, "x y z", "rad/s", "", {}},
    {"q_TB", FieldType::kF64, 4, true, 48, offsetof(ModelPacket, q_TB), 1, -1.0, 1.0, "w x y z", "", "", {}},
    {"inertia_ratio", FieldType::kF64, 2, true, 80, offsetof(ModelPacket, inertia_ratio), 2, 0.0, kNoLimit, "y z", "", "", {}},
    {"period_spin_s", FieldType::kF64, 1, false, 96, offsetof(ModelPacket, period_spin_s), 3, 0.0, kNoLimit, "", "s", "", {}},
    {"period_precession_s", FieldType::kF64, 1, false, 104, offsetof(ModelPacket, period_precession_s), 4, 0.0, kNoLimit, "", "s", "", {}},
    {"momentum_axis_C", FieldType::kF64, 3, true, 112, offsetof(ModelPacket, momentum_axis_C), -1, -1.0, 1.0, "x y z", "", "", {}},
    {"v_C", FieldType::kF64, 3, true, 136, offsetof(ModelPacket, v_C), 5, -kNoLimit, kNoLimit, "x y z", "length/s", "", {}},
    {"c_T", FieldType::kF64, 3, true, 160, offsetof(ModelPacket, c_T), 6, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"cov_w", FieldType::kF32, 6, true, 184, offsetof(ModelPacket, cov_w), 0, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "(rad/s)^2", "", {}},
    {"sigma_axes_rad", FieldType::kF32, 3, true, 208, offsetof(ModelPacket, sigma_axes_rad), 1, 0.0, kNoLimit, "x y z", "rad", "", {}},
    {"sigma_inertia_ratio", FieldType::kF32, 2, true, 220, offsetof(ModelPacket, sigma_inertia_ratio), 2, 0.0, kNoLimit, "y z", "", "", {}},
    {"sigma_period_spin_s", FieldType::kF32, 1, false, 228, offsetof(ModelPacket, sigma_period_spin_s), 3, 0.0, kNoLimit, "", "s", "", {}},
    {"sigma_period_precession_s", FieldType::kF32, 1, false, 232, offsetof(ModelPacket, sigma_period_precession_s), 4, 0.0, kNoLimit, "", "s", "", {}},
    {"sigma_momentum_axis_rad", FieldType::kF32, 1, false, 236, offsetof(ModelPacket, sigma_momentum_axis_rad), -1, 0.0, kNoLimit, "", "rad", "", {}},
    {"cov_v", FieldType::kF32, 6, true, 240, offsetof(ModelPacket, cov_v), 5, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "(length/s)^2", "", {}},
    {"cov_c", FieldType::kF32, 6, true, 264, offsetof(ModelPacket, cov_c), 6, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "length^2", "", {}},
    {"span_s", FieldType::kF32, 1, false, 288, offsetof(ModelPacket, span_s), -1, 0.0, kNoLimit, "", "s", "", {}},
    {"chi2_per_dof", FieldType::kF32, 2, true, 292, offsetof(ModelPacket, chi2_per_dof), -1, 0.0, kNoLimit, "attitude position", "", "", {}},
    {"poses", FieldType::kU32, 1, false, 300, offsetof(ModelPacket, poses), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frame", FieldType::kU32, 1, false, 304, offsetof(ModelPacket, frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"dynamics", FieldType::kU8, 1, false, 308, offsetof(ModelPacket, dynamics), -1, 0.0, 3.0, "", "", "NONE LOCAL TORQUE_FREE ORBIT", {}},
    {"refusal", FieldType::kU8, 1, false, 309, offsetof(ModelPacket, refusal), -1, 0.0, 3.0, "", "", "NONE TOO_FEW_POSES NO_FIT RESIDUALS_TOO_LARGE", {}},
    {"class_axes", FieldType::kU8, 3, true, 310, offsetof(ModelPacket, class_axes), -1, 0.0, 2.0, "x y z", "", "UNOBSERVED WEAK OBSERVED", {}},
    {"class_inertia", FieldType::kU8, 2, true, 313, offsetof(ModelPacket, class_inertia), -1, 0.0, 2.0, "y z", "", "UNOBSERVED WEAK OBSERVED", {}},
    {"class_spin", FieldType::kU8, 1, false, 315, offsetof(ModelPacket, class_spin), -1, 0.0, 2.0, "", "", "UNOBSERVED WEAK OBSERVED", {}},
    {"class_precession", FieldType::kU8, 1, false, 316, offsetof(ModelPacket, class_precession), -1, 0.0, 2.0, "", "", "UNOBSERVED WEAK OBSERVED", {}},
    {"class_momentum", FieldType::kU8, 1, false, 317, offsetof(ModelPacket, class_momentum), -1, 0.0, 2.0, "", "", "UNOBSERVED WEAK OBSERVED", {}},
    {"class_mass_centre", FieldType::kU8, 3, true, 318, offsetof(ModelPacket, class_mass_centre), -1, 0.0, 2.0, "best middle worst", "", "UNOBSERVED WEAK OBSERVED", {}},
    {"flags", FieldType::kU8, 1, false, 321, offsetof(ModelPacket, flags), -1, 0.0, 255.0, "", "", "", {}},
};
constexpr Layout kModelPacketLayout{"model", 1, 324, kModelPacket, offsetof(ModelPacket, flags), "rate axes inertia spin precession velocity mass_centre scale_known", ""};
static_assert(sizeof(ModelPacket) <= kStructOctetsMax);

constexpr Field kPredictionPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(PredictionPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"predicted_timestamp_ns", FieldType::kI64, 1, false, 24, offsetof(PredictionPacket, predicted_timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"q_CT", FieldType::kF64, 4, true, 32, offsetof(PredictionPacket, q_CT), 0, -1.0, 1.0, "w x y z", "", "", {}},
    {"p_CT", FieldType::kF64, 3, true, 64, offsetof(PredictionPacket, p_CT), 2, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"w_T_rad_s", FieldType::kF64, 3, true, 88, offsetof(PredictionPacket, w_T_rad_s), 1, -kNoLimit, kNoLimit, "x y z", "rad/s", "", {}},
    {"cov_pose", FieldType::kF32, 21, true, 112, offsetof(PredictionPacket, cov_pose), -1, -kNoLimit, kNoLimit, "", "rad and length", "", {}},
    {"cov_w", FieldType::kF32, 6, true, 196, offsetof(PredictionPacket, cov_w), 1, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "(rad/s)^2", "", {}},
    {"frame", FieldType::kU32, 1, false, 220, offsetof(PredictionPacket, frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"poses", FieldType::kU16, 1, false, 224, offsetof(PredictionPacket, poses), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"dynamics", FieldType::kU8, 1, false, 226, offsetof(PredictionPacket, dynamics), -1, 0.0, 3.0, "", "", "NONE LOCAL TORQUE_FREE ORBIT", {}},
    {"flags", FieldType::kU8, 1, false, 227, offsetof(PredictionPacket, flags), -1, 0.0, 255.0, "", "", "", {}},
};
constexpr Layout kPredictionPacketLayout{"prediction", 2, 230, kPredictionPacket, offsetof(PredictionPacket, flags), "attitude rate position scale_known", "scale_number"};
static_assert(sizeof(PredictionPacket) <= kStructOctetsMax);

constexpr Field kShapePacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(ShapePacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"q_TB", FieldType::kF64, 4, true, 24, offsetof(ShapePacket, q_TB), 0, -1.0, 1.0, "w x y z", "", "", {}},
    {"centroid_T", FieldType::kF64, 3, true, 56, offsetof(ShapePacket, centroid_T), 0, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"centroid_measured_T", FieldType::kF64, 3, true, 80, offsetof(ShapePacket, centroid_measured_T), 0, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"dimensions", FieldType::kF64, 3, true, 104, offsetof(ShapePacket, dimensions), 0, 0.0, kNoLimit, "x y z", "length", "", {}},
    {"sigma_dimensions", FieldType::kF64, 3, true, 128, offsetof(ShapePacket, sigma_dimensions), 0, 0.0, kNoLimit, "x y z", "length", "", {}},
    {"metres_per_mu", FieldType::kF64, 1, false, 152, offsetof(ShapePacket, metres_per_mu), 2, 0.0, kNoLimit, "", "m/map unit", "", {}},
    {"cylinder_axis_T", FieldType::kF32, 3, true, 160, offsetof(ShapePacket, cylinder_axis_T), 1, -1.0, 1.0, "x y z", "", "", {}},
    {"cylinder_centre_T", FieldType::kF32, 3, true, 172, offsetof(ShapePacket, cylinder_centre_T), 1, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"cylinder_radius", FieldType::kF32, 1, false, 184, offsetof(ShapePacket, cylinder_radius), 1, 0.0, kNoLimit, "", "length", "", {}},
    {"cylinder_length", FieldType::kF32, 1, false, 188, offsetof(ShapePacket, cylinder_length), 1, 0.0, kNoLimit, "", "length", "", {}},
    {"cylinder_coverage_rad", FieldType::kF32, 1, false, 192, offsetof(ShapePacket, cylinder_coverage_rad), 1, 0.0, 6.2832, "", "rad", "", {}},
    {"sigma_cylinder_axis_rad", FieldType::kF32, 1, false, 196, offsetof(ShapePacket, sigma_cylinder_axis_rad), 1, 0.0, kNoLimit, "", "rad", "", {}},
    {"sigma_cylinder_radius", FieldType::kF32, 1, false, 200, offsetof(ShapePacket, sigma_cylinder_radius), 1, 0.0, kNoLimit, "", "length", "", {}},
    {"spacing", FieldType::kF32, 1, false, 204, offsetof(ShapePacket, spacing), 0, 0.0, kNoLimit, "", "length", "", {}},
    {"thickness", FieldType::kF32, 1, false, 208, offsetof(ShapePacket, thickness), 0, 0.0, kNoLimit, "", "length", "", {}},
    {"sigma_scale", FieldType::kF32, 1, false, 212, offsetof(ShapePacket, sigma_scale), 2, 0.0, kNoLimit, "", "", "", {}},
    {"plane_normal_T", FieldType::kF32, 36, true, 216, offsetof(ShapePacket, plane_normal_T), 0, -1.0, 1.0, "x y z", "", "", {}},
    {"plane_offset", FieldType::kF32, 12, true, 360, offsetof(ShapePacket, plane_offset), 0, -kNoLimit, kNoLimit, "", "length", "", {}},
    {"plane_centre_T", FieldType::kF32, 36, true, 408, offsetof(ShapePacket, plane_centre_T), 0, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"plane_extent", FieldType::kF32, 24, true, 552, offsetof(ShapePacket, plane_extent), 0, 0.0, kNoLimit, "u v", "length", "", {}},
    {"plane_sigma", FieldType::kF32, 36, true, 648, offsetof(ShapePacket, plane_sigma), 0, 0.0, kNoLimit, "u v offset", "rad, rad, length", "", {}},
    {"frame", FieldType::kU32, 1, false, 792, offsetof(ShapePacket, frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frame_of_estimate", FieldType::kU32, 1, false, 796, offsetof(ShapePacket, frame_of_estimate), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"plane_inliers", FieldType::kU16, 12, true, 800, offsetof(ShapePacket, plane_inliers), 0, -kNoLimit, kNoLimit, "", "", "", {}},
    {"landmarks", FieldType::kU16, 1, false, 824, offsetof(ShapePacket, landmarks), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"cloud_points", FieldType::kU16, 1, false, 826, offsetof(ShapePacket, cloud_points), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"completion_points", FieldType::kU16, 1, false, 828, offsetof(ShapePacket, completion_points), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"plane_count", FieldType::kU8, 1, false, 830, offsetof(ShapePacket, plane_count), -1, 0.0, 12.0, "", "", "", {}},
    {"completion", FieldType::kU8, 1, false, 831, offsetof(ShapePacket, completion), -1, 0.0, 2.0, "", "", "NONE BOX CYLINDER", {}},
    {"frame_source", FieldType::kU8, 1, false, 832, offsetof(ShapePacket, frame_source), -1, 0.0, 2.0, "", "", "PRINCIPAL PLANES CYLINDER", {}},
    {"dimension_basis", FieldType::kU8, 3, true, 833, offsetof(ShapePacket, dimension_basis), 0, 0.0, 2.0, "x y z", "", "NOTHING POINTS SURFACES", {}},
    {"flags", FieldType::kU8, 1, false, 836, offsetof(ShapePacket, flags), -1, 0.0, 63.0, "", "", "", {}},
    {"spare", FieldType::kU8, 1, false, 837, offsetof(ShapePacket, spare), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kShapePacketLayout{"shape", 3, 840, kShapePacket, offsetof(ShapePacket, flags), "shape cylinder scale_known axis_x axis_y axis_z", ""};
static_assert(sizeof(ShapePacket) <= kStructOctetsMax);

constexpr Field kHousekeepingPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(HousekeepingPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"memory_octets", FieldType::kU64, 1, false, 24, offsetof(HousekeepingPacket, memory_octets), -1, -kNoLimit, kNoLimit, "", "octet", "", {}},
    {"frame", FieldType::kU32, 1, false, 32, offsetof(HousekeepingPacket, frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_in", FieldType::kU32, 1, false, 36, offsetof(HousekeepingPacket, frames_in), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_used", FieldType::kU32, 1, false, 40, offsetof(HousekeepingPacket, frames_used), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_unreadable", FieldType::kU32, 1, false, 44, offsetof(HousekeepingPacket, frames_unreadable), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_dark", FieldType::kU32, 1, false, 48, offsetof(HousekeepingPacket, frames_dark), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_wrong_size", FieldType::kU32, 1, false, 52, offsetof(HousekeepingPacket, frames_wrong_size), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_time_not_increasing", FieldType::kU32, 1, false, 56, offsetof(HousekeepingPacket, frames_time_not_increasing), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_held", FieldType::kU32, 1, false, 60, offsetof(HousekeepingPacket, frames_held), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_missing", FieldType::kU32, 1, false, 64, offsetof(HousekeepingPacket, frames_missing), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_flat", FieldType::kU32, 1, false, 68, offsetof(HousekeepingPacket, frames_flat), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_saturated", FieldType::kU32, 1, false, 72, offsetof(HousekeepingPacket, frames_saturated), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_frozen", FieldType::kU32, 1, false, 76, offsetof(HousekeepingPacket, frames_frozen), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_torn", FieldType::kU32, 1, false, 80, offsetof(HousekeepingPacket, frames_torn), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_bit_errors", FieldType::kU32, 1, false, 84, offsetof(HousekeepingPacket, frames_bit_errors), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_blurred", FieldType::kU32, 1, false, 88, offsetof(HousekeepingPacket, frames_blurred), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frames_with_care", FieldType::kU32, 1, false, 92, offsetof(HousekeepingPacket, frames_with_care), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"poses", FieldType::kU32, 1, false, 96, offsetof(HousekeepingPacket, poses), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"lost", FieldType::kU32, 1, false, 100, offsetof(HousekeepingPacket, lost), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"relocalised", FieldType::kU32, 1, false, 104, offsetof(HousekeepingPacket, relocalised), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"restarts", FieldType::kU32, 1, false, 108, offsetof(HousekeepingPacket, restarts), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"start_contests", FieldType::kU32, 1, false, 112, offsetof(HousekeepingPacket, start_contests), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"keyframes_inserted", FieldType::kU32, 1, false, 116, offsetof(HousekeepingPacket, keyframes_inserted), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"keyframes_culled", FieldType::kU32, 1, false, 120, offsetof(HousekeepingPacket, keyframes_culled), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"landmarks_created", FieldType::kU32, 1, false, 124, offsetof(HousekeepingPacket, landmarks_created), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"landmarks_culled", FieldType::kU32, 1, false, 128, offsetof(HousekeepingPacket, landmarks_culled), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"closures", FieldType::kU32, 1, false, 132, offsetof(HousekeepingPacket, closures), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"shapes", FieldType::kU32, 1, false, 136, offsetof(HousekeepingPacket, shapes), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"jobs_issued", FieldType::kU32, 1, false, 140, offsetof(HousekeepingPacket, jobs_issued), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"jobs_without_result", FieldType::kU32, 1, false, 144, offsetof(HousekeepingPacket, jobs_without_result), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"steps_short_of_memory", FieldType::kU32, 1, false, 148, offsetof(HousekeepingPacket, steps_short_of_memory), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"scale_contradictions", FieldType::kU32, 1, false, 152, offsetof(HousekeepingPacket, scale_contradictions), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"tables_full", FieldType::kU32, 1, false, 156, offsetof(HousekeepingPacket, tables_full), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"commands_accepted", FieldType::kU32, 1, false, 160, offsetof(HousekeepingPacket, commands_accepted), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"commands_rejected", FieldType::kU32, 1, false, 164, offsetof(HousekeepingPacket, commands_rejected), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"events_sent", FieldType::kU32, 1, false, 168, offsetof(HousekeepingPacket, events_sent), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"events_suppressed", FieldType::kU32, 1, false, 172, offsetof(HousekeepingPacket, events_suppressed), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"packets_not_sent", FieldType::kU32, 1, false, 176, offsetof(HousekeepingPacket, packets_not_sent), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"table_crc", FieldType::kU32, 1, false, 180, offsetof(HousekeepingPacket, table_crc), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"table_loaded_crc", FieldType::kU32, 1, false, 184, offsetof(HousekeepingPacket, table_loaded_crc), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"table_entries", FieldType::kU16, 1, false, 188, offsetof(HousekeepingPacket, table_entries), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"landmarks", FieldType::kU16, 1, false, 190, offsetof(HousekeepingPacket, landmarks), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"keyframes", FieldType::kU16, 1, false, 192, offsetof(HousekeepingPacket, keyframes), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"cloud_chunks_left", FieldType::kU16, 1, false, 194, offsetof(HousekeepingPacket, cloud_chunks_left), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"last_command", FieldType::kU8, 1, false, 196, offsetof(HousekeepingPacket, last_command), -1, -kNoLimit, kNoLimit, "", "", "", kCommandsNames},
    {"last_rejection", FieldType::kU8, 1, false, 197, offsetof(HousekeepingPacket, last_rejection), -1, 0.0, 7.0, "", "", "NONE LENGTH HEADER CRC UNKNOWN_CODE RANGE STATE TOO_MANY", {}},
    {"mode", FieldType::kU8, 1, false, 198, offsetof(HousekeepingPacket, mode), -1, 0.0, 4.0, "", "", "IDLE ACQUIRING TRACKING LOST COASTING", {}},
    {"version", FieldType::kU8, 3, true, 199, offsetof(HousekeepingPacket, version), -1, -kNoLimit, kNoLimit, "major minor patch", "", "", {}},
    {"flags", FieldType::kU8, 1, false, 202, offsetof(HousekeepingPacket, flags), -1, 0.0, 63.0, "", "", "", {}},
    {"tables_damaged", FieldType::kU8, 1, false, 203, offsetof(HousekeepingPacket, tables_damaged), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kHousekeepingPacketLayout{"housekeeping", 4, 206, kHousekeepingPacket, offsetof(HousekeepingPacket, flags), "held scale_known table_loaded servicer_attitude focal_length_doubted camera_contradicted", ""};
static_assert(sizeof(HousekeepingPacket) <= kStructOctetsMax);

constexpr Field kEventPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(EventPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"value", FieldType::kF64, 2, true, 24, offsetof(EventPacket, value), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"frame", FieldType::kU32, 1, false, 40, offsetof(EventPacket, frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"occurrences", FieldType::kU32, 1, false, 44, offsetof(EventPacket, occurrences), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"suppressed", FieldType::kU32, 1, false, 48, offsetof(EventPacket, suppressed), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"id", FieldType::kU16, 1, false, 52, offsetof(EventPacket, id), -1, -kNoLimit, kNoLimit, "", "", "", kEventsNames},
    {"severity", FieldType::kU8, 1, false, 54, offsetof(EventPacket, severity), -1, 0.0, 4.0, "", "", "DEBUG INFO WARNING ERROR CRITICAL", {}},
    {"text_octets", FieldType::kU8, 1, false, 55, offsetof(EventPacket, text_octets), -1, 0.0, 122.0, "", "", "", {}},
    {"text", FieldType::kText, 122, true, 56, offsetof(EventPacket, text), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"command_sequence", FieldType::kU16, 1, false, 178, offsetof(EventPacket, command_sequence), -1, 0.0, 16383.0, "", "", "", {}},
};
constexpr Layout kEventPacketLayout{"event", 5, 182, kEventPacket, kNoFlags, "", ""};
static_assert(sizeof(EventPacket) <= kStructOctetsMax);

constexpr Field kCloudPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(CloudPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"metres_per_mu", FieldType::kF64, 1, false, 24, offsetof(CloudPacket, metres_per_mu), 0, 0.0, kNoLimit, "", "m/map unit", "", {}},
    {"points_total", FieldType::kU32, 1, false, 32, offsetof(CloudPacket, points_total), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"first_point", FieldType::kU32, 1, false, 36, offsetof(CloudPacket, first_point), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"cloud", FieldType::kU16, 1, false, 40, offsetof(CloudPacket, cloud), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"chunk", FieldType::kU16, 1, false, 42, offsetof(CloudPacket, chunk), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"chunks", FieldType::kU16, 1, false, 44, offsetof(CloudPacket, chunks), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"points", FieldType::kU8, 1, false, 46, offsetof(CloudPacket, points), -1, 0.0, 110.0, "", "", "", {}},
    {"flags", FieldType::kU8, 1, false, 47, offsetof(CloudPacket, flags), -1, 0.0, 1.0, "", "", "", {}},
    {"p_T", FieldType::kF32, 330, true, 48, offsetof(CloudPacket, p_T), -1, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
};
constexpr Layout kCloudPacketLayout{"cloud", 6, 1370, kCloudPacket, offsetof(CloudPacket, flags), "scale_known", ""};
static_assert(sizeof(CloudPacket) <= kStructOctetsMax);

constexpr Field kPlatformPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(PlatformPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"resident_octets", FieldType::kU64, 1, false, 24, offsetof(PlatformPacket, resident_octets), -1, -kNoLimit, kNoLimit, "", "octet", "", {}},
    {"resident_peak_octets", FieldType::kU64, 1, false, 32, offsetof(PlatformPacket, resident_peak_octets), -1, -kNoLimit, kNoLimit, "", "octet", "", {}},
    {"uptime_s", FieldType::kU32, 1, false, 40, offsetof(PlatformPacket, uptime_s), -1, -kNoLimit, kNoLimit, "", "s", "", {}},
    {"frames_dropped", FieldType::kU32, 1, false, 44, offsetof(PlatformPacket, frames_dropped), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"camera_errors", FieldType::kU32, 1, false, 48, offsetof(PlatformPacket, camera_errors), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"camera_reopened", FieldType::kU32, 1, false, 52, offsetof(PlatformPacket, camera_reopened), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"deadline_misses", FieldType::kU32, 1, false, 56, offsetof(PlatformPacket, deadline_misses), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"jobs_late", FieldType::kU32, 1, false, 60, offsetof(PlatformPacket, jobs_late), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"last_step_us", FieldType::kU32, 1, false, 64, offsetof(PlatformPacket, last_step_us), -1, -kNoLimit, kNoLimit, "", "us", "", {}},
    {"longest_step_us", FieldType::kU32, 1, false, 68, offsetof(PlatformPacket, longest_step_us), -1, -kNoLimit, kNoLimit, "", "us", "", {}},
    {"packets_sent", FieldType::kU32, 1, false, 72, offsetof(PlatformPacket, packets_sent), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"packets_dropped", FieldType::kU32, 1, false, 76, offsetof(PlatformPacket, packets_dropped), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"commands_received", FieldType::kU32, 1, false, 80, offsetof(PlatformPacket, commands_received), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"commands_dropped", FieldType::kU32, 1, false, 84, offsetof(PlatformPacket, commands_dropped), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"restarts", FieldType::kU16, 1, false, 88, offsetof(PlatformPacket, restarts), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"flags", FieldType::kU8, 1, false, 90, offsetof(PlatformPacket, flags), -1, 0.0, 7.0, "", "", "", {}},
    {"spare", FieldType::kU8, 1, false, 91, offsetof(PlatformPacket, spare), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kPlatformPacketLayout{"platform", 7, 94, kPlatformPacket, offsetof(PlatformPacket, flags), "watchdog locked_memory real_time", ""};
static_assert(sizeof(PlatformPacket) <= kStructOctetsMax);

constexpr Field kCommandLinkPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(CommandLinkPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"highest_number", FieldType::kU64, 1, false, 24, offsetof(CommandLinkPacket, highest_number), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"received", FieldType::kU32, 1, false, 32, offsetof(CommandLinkPacket, received), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"passed", FieldType::kU32, 1, false, 36, offsetof(CommandLinkPacket, passed), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"refused_sender", FieldType::kU32, 1, false, 40, offsetof(CommandLinkPacket, refused_sender), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"refused_form", FieldType::kU32, 1, false, 44, offsetof(CommandLinkPacket, refused_form), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"refused_mac", FieldType::kU32, 1, false, 48, offsetof(CommandLinkPacket, refused_mac), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"refused_number", FieldType::kU32, 1, false, 52, offsetof(CommandLinkPacket, refused_number), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"dropped", FieldType::kU32, 1, false, 56, offsetof(CommandLinkPacket, dropped), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"numbers_not_kept", FieldType::kU32, 1, false, 60, offsetof(CommandLinkPacket, numbers_not_kept), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"ports", FieldType::kU8, 1, false, 64, offsetof(CommandLinkPacket, ports), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"flags", FieldType::kU8, 1, false, 65, offsetof(CommandLinkPacket, flags), -1, 0.0, 7.0, "", "", "", {}},
    {"spare", FieldType::kU8, 2, true, 66, offsetof(CommandLinkPacket, spare), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kCommandLinkPacketLayout{"command_link", 8, 70, kCommandLinkPacket, offsetof(CommandLinkPacket, flags), "key unauthenticated number_not_kept", ""};
static_assert(sizeof(CommandLinkPacket) <= kStructOctetsMax);

constexpr Field kPlatformEventPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(PlatformEventPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"value", FieldType::kF64, 4, true, 24, offsetof(PlatformEventPacket, value), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"id", FieldType::kU16, 1, false, 56, offsetof(PlatformEventPacket, id), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"severity", FieldType::kU8, 1, false, 58, offsetof(PlatformEventPacket, severity), -1, 0.0, 4.0, "", "", "DEBUG INFO WARNING ERROR CRITICAL", {}},
    {"text_octets", FieldType::kU8, 1, false, 59, offsetof(PlatformEventPacket, text_octets), -1, 0.0, 122.0, "", "", "", {}},
    {"text", FieldType::kText, 122, true, 60, offsetof(PlatformEventPacket, text), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"spare", FieldType::kU8, 2, true, 182, offsetof(PlatformEventPacket, spare), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kPlatformEventPacketLayout{"platform_event", 9, 186, kPlatformEventPacket, kNoFlags, "", ""};
static_assert(sizeof(PlatformEventPacket) <= kStructOctetsMax);

constexpr Field kPointPacket[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 16, offsetof(PointPacket, timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"predicted_timestamp_ns", FieldType::kI64, 1, false, 24, offsetof(PointPacket, predicted_timestamp_ns), -1, -kNoLimit, kNoLimit, "", "ns", "", {}},
    {"p_C", FieldType::kF64, 3, true, 32, offsetof(PointPacket, p_C), 0, -kNoLimit, kNoLimit, "x y z", "length", "", {}},
    {"v_C", FieldType::kF64, 3, true, 56, offsetof(PointPacket, v_C), 1, -kNoLimit, kNoLimit, "x y z", "length/s", "", {}},
    {"normal_C", FieldType::kF64, 3, true, 80, offsetof(PointPacket, normal_C), 2, -1.0, 1.0, "x y z", "", "", {}},
    {"cov_p", FieldType::kF32, 6, true, 104, offsetof(PointPacket, cov_p), 0, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "length^2", "", {}},
    {"cov_v", FieldType::kF32, 6, true, 128, offsetof(PointPacket, cov_v), 1, -kNoLimit, kNoLimit, "xx xy xz yy yz zz", "(length/s)^2", "", {}},
    {"sigma_normal_rad", FieldType::kF32, 1, false, 152, offsetof(PointPacket, sigma_normal_rad), 2, 0.0, kNoLimit, "", "rad", "", {}},
    {"number", FieldType::kU32, 1, false, 156, offsetof(PointPacket, number), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"target_frame", FieldType::kU32, 1, false, 160, offsetof(PointPacket, target_frame), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"dynamics", FieldType::kU8, 1, false, 164, offsetof(PointPacket, dynamics), -1, 0.0, 3.0, "", "", "NONE LOCAL TORQUE_FREE ORBIT", {}},
    {"flags", FieldType::kU8, 1, false, 165, offsetof(PointPacket, flags), -1, 0.0, 255.0, "", "", "", {}},
    {"spare", FieldType::kU8, 2, true, 166, offsetof(PointPacket, spare), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kPointPacketLayout{"point", 10, 170, kPointPacket, offsetof(PointPacket, flags), "position velocity normal scale_known", "scale_number"};
static_assert(sizeof(PointPacket) <= kStructOctetsMax);

constexpr Layout kNoopCommandLayout{"noop", 0, 10, {}, kNoFlags, "", ""};

constexpr Layout kResetCountersCommandLayout{"reset_counters", 1, 10, {}, kNoFlags, "", ""};

constexpr Layout kResetMapCommandLayout{"reset_map", 2, 10, {}, kNoFlags, "", ""};

constexpr Layout kHoldCommandLayout{"hold", 3, 10, {}, kNoFlags, "", ""};

constexpr Layout kResumeCommandLayout{"resume", 4, 10, {}, kNoFlags, "", ""};

constexpr Field kSetKnownLengthCommand[] = {
    {"frame_timestamp_ns", FieldType::kI64, 1, false, 8, offsetof(SetKnownLengthCommand, frame_timestamp_ns), -1, 0.0, 9.2e+18, "", "ns", "", {}},
    {"length_m", FieldType::kF64, 1, false, 16, offsetof(SetKnownLengthCommand, length_m), -1, 0.001, 1000.0, "", "m", "", {}},
    {"first_px", FieldType::kF64, 2, true, 24, offsetof(SetKnownLengthCommand, first_px), -1, -0.5, 16384.0, "u v", "px", "", {}},
    {"second_px", FieldType::kF64, 2, true, 40, offsetof(SetKnownLengthCommand, second_px), -1, -0.5, 16384.0, "u v", "px", "", {}},
};
constexpr Layout kSetKnownLengthCommandLayout{"set_known_length", 5, 58, kSetKnownLengthCommand, kNoFlags, "", ""};
static_assert(sizeof(SetKnownLengthCommand) <= kStructOctetsMax);

constexpr Field kSetRangeCommand[] = {
    {"frame_timestamp_ns", FieldType::kI64, 1, false, 8, offsetof(SetRangeCommand, frame_timestamp_ns), -1, 0.0, 9.2e+18, "", "ns", "", {}},
    {"range_m", FieldType::kF64, 1, false, 16, offsetof(SetRangeCommand, range_m), -1, 0.01, 100000.0, "", "m", "", {}},
};
constexpr Layout kSetRangeCommandLayout{"set_range", 6, 26, kSetRangeCommand, kNoFlags, "", ""};
static_assert(sizeof(SetRangeCommand) <= kStructOctetsMax);

constexpr Field kServicerAttitudeCommand[] = {
    {"timestamp_ns", FieldType::kI64, 1, false, 8, offsetof(ServicerAttitudeCommand, timestamp_ns), -1, 0.0, 9.2e+18, "", "ns", "", {}},
    {"q_IC", FieldType::kF64, 4, true, 16, offsetof(ServicerAttitudeCommand, q_IC), -1, -1.0, 1.0, "w x y z", "", "", {}},
    {"w_C_rad_s", FieldType::kF64, 3, true, 48, offsetof(ServicerAttitudeCommand, w_C_rad_s), -1, -10.0, 10.0, "x y z", "rad/s", "", {}},
};
constexpr Layout kServicerAttitudeCommandLayout{"servicer_attitude", 7, 74, kServicerAttitudeCommand, kNoFlags, "", ""};
static_assert(sizeof(ServicerAttitudeCommand) <= kStructOctetsMax);

constexpr Field kRequestCloudCommand[] = {
    {"points_max", FieldType::kU32, 1, false, 8, offsetof(RequestCloudCommand, points_max), -1, 1.0, 100000.0, "", "", "", {}},
};
constexpr Layout kRequestCloudCommandLayout{"request_cloud", 8, 14, kRequestCloudCommand, kNoFlags, "", ""};
static_assert(sizeof(RequestCloudCommand) <= kStructOctetsMax);

constexpr Field kTableLoadCommand[] = {
    {"entries", FieldType::kU16, 1, false, 8, offsetof(TableLoadCommand, entries), -1, 1.0, 64.0, "", "", "", {}},
    {"spare", FieldType::kU16, 3, true, 10, offsetof(TableLoadCommand, spare), -1, 0.0, 0.0, "", "", "", {}},
};
constexpr Layout kTableLoadCommandLayout{"table_load", 9, 18, kTableLoadCommand, kNoFlags, "", ""};
static_assert(sizeof(TableLoadCommand) <= kStructOctetsMax);

constexpr Field kTableLoadEntry[] = {
    {"key_crc", FieldType::kU32, 1, false, 0, offsetof(TableLoadEntry, key_crc), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"index", FieldType::kU16, 1, false, 4, offsetof(TableLoadEntry, index), -1, 0.0, 3.0, "", "", "", {}},
    {"spare", FieldType::kU16, 1, false, 6, offsetof(TableLoadEntry, spare), -1, 0.0, 0.0, "", "", "", {}},
    {"value", FieldType::kU64, 1, false, 8, offsetof(TableLoadEntry, value), -1, -kNoLimit, kNoLimit, "", "", "", {}},
};
constexpr Layout kTableLoadEntryLayout{"table_load_entry", 9, 16, kTableLoadEntry, kNoFlags, "", ""};
static_assert(sizeof(TableLoadEntry) <= kStructOctetsMax);

constexpr Field kTableActivateCommand[] = {
    {"crc32", FieldType::kU32, 1, false, 8, offsetof(TableActivateCommand, crc32), -1, -kNoLimit, kNoLimit, "", "", "", {}},
    {"entries", FieldType::kU32, 1, false, 12, offsetof(TableActivateCommand, entries), -1, 1.0, 4096.0, "", "", "", {}},
};
constexpr Layout kTableActivateCommandLayout{"table_activate", 10, 18, kTableActivateCommand, kNoFlags, "", ""};
static_assert(sizeof(TableActivateCommand) <= kStructOctetsMax);

constexpr Layout kTableDiscardCommandLayout{"table_discard", 11, 10, {}, kNoFlags, "", ""};

constexpr Layout kCheckpointCommandLayout{"checkpoint", 12, 10, {}, kNoFlags, "", ""};

constexpr Field kPredictPointCommand[] = {
    {"predicted_timestamp_ns", FieldType::kI64, 1, false, 8, offsetof(PredictPointCommand, predicted_timestamp_ns), -1, 0.0, 9.2e+18, "", "ns", "", {}},
    {"p_T", FieldType::kF64, 3, true, 16, offsetof(PredictPointCommand, p_T), -1, -1000000.0, 1000000.0, "x y z", "length", "", {}},
    {"normal_T", FieldType::kF64, 3, true, 40, offsetof(PredictPointCommand, normal_T), -1, -1.0, 1.0, "x y z", "", "", {}},
    {"target_frame", FieldType::kU32, 1, false, 64, offsetof(PredictPointCommand, target_frame), -1, 1.0, 4294967295.0, "", "", "", {}},
    {"number", FieldType::kU32, 1, false, 68, offsetof(PredictPointCommand, number), -1, 0.0, 4294967295.0, "", "", "", {}},
};
constexpr Layout kPredictPointCommandLayout{"predict_point", 13, 74, kPredictPointCommand, kNoFlags, "", ""};
static_assert(sizeof(PredictPointCommand) <= kStructOctetsMax);

constexpr const Layout* kPackets[] = {&kMotionPacketLayout, &kModelPacketLayout, &kPredictionPacketLayout, &kShapePacketLayout, &kHousekeepingPacketLayout, &kEventPacketLayout, &kCloudPacketLayout, &kPlatformPacketLayout, &kCommandLinkPacketLayout, &kPlatformEventPacketLayout, &kPointPacketLayout};
constexpr const Layout* kCommands[] = {&kNoopCommandLayout, &kResetCountersCommandLayout, &kResetMapCommandLayout, &kHoldCommandLayout, &kResumeCommandLayout, &kSetKnownLengthCommandLayout, &kSetRangeCommandLayout, &kServicerAttitudeCommandLayout, &kRequestCloudCommandLayout, &kTableLoadCommandLayout, &kTableActivateCommandLayout, &kTableDiscardCommandLayout, &kCheckpointCommandLayout, &kPredictPointCommandLayout};
// clang-format on

}  // namespace

const Layout& MotionPacket::layout() { return kMotionPacketLayout; }
const Layout& ModelPacket::layout() { return kModelPacketLayout; }
const Layout& PredictionPacket::layout() { return kPredictionPacketLayout; }
const Layout& ShapePacket::layout() { return kShapePacketLayout; }
const Layout& HousekeepingPacket::layout() { return kHousekeepingPacketLayout; }
const Layout& EventPacket::layout() { return kEventPacketLayout; }
const Layout& CloudPacket::layout() { return kCloudPacketLayout; }
const Layout& PlatformPacket::layout() { return kPlatformPacketLayout; }
const Layout& CommandLinkPacket::layout() { return kCommandLinkPacketLayout; }
const Layout& PlatformEventPacket::layout() { return kPlatformEventPacketLayout; }
const Layout& PointPacket::layout() { return kPointPacketLayout; }
const Layout& SetKnownLengthCommand::layout() { return kSetKnownLengthCommandLayout; }
const Layout& SetRangeCommand::layout() { return kSetRangeCommandLayout; }
const Layout& ServicerAttitudeCommand::layout() { return kServicerAttitudeCommandLayout; }
const Layout& RequestCloudCommand::layout() { return kRequestCloudCommandLayout; }
const Layout& TableLoadCommand::layout() { return kTableLoadCommandLayout; }
const Layout& TableLoadEntry::layout() { return kTableLoadEntryLayout; }
const Layout& TableActivateCommand::layout() { return kTableActivateCommandLayout; }
const Layout& PredictPointCommand::layout() { return kPredictPointCommandLayout; }

std::span<const Layout* const> packet_layouts() { return kPackets; }
std::span<const Layout* const> command_layouts() { return kCommands; }

}  // namespace polhode::bus
