#include "pipeline/parameter_table.hpp"

#include <charconv>
#include <cmath>
#include <type_traits>

#include "bus/commands.hpp"
#include "config/limits.hpp"

namespace polhode {
namespace {

template <typename T>
consteval AnyMember member(T& (*where)(Parameters&)) {
  return where;
}

// The type of the row follows from the field: a field that changes its type changes its row.
#define POLHODE_FIELD(path)                                                           \
  member(static_cast<Member<std::remove_reference_t<decltype((Parameters{}.path))>>>( \
      [](Parameters& p) -> std::remove_reference_t<decltype((Parameters{}.path))>& {  \
        return p.path;                                                                \
      }))
// The key follows from the field, too.
#define POLHODE_OPTION(path) #path, POLHODE_FIELD(path)

// Every double up to here fits into 63 bits: 2^63 is 9.22e18.
constexpr double kInt64Max = 9.2e18;

// Ranges recommend nothing. Upper limits that are limits::k... are sizes of tables. The others are
// chosen wide: they refuse wrong units and slips of the decimal point, and they bound the time.
// A principal point or an end of a length may lie up to one image side (8192) outside the image.

// clang-format off
constexpr ParameterRow kRows[] = {
  {POLHODE_OPTION(seed), 0, kInt64Max, "",
   "seed of every random draw; the same seed, frames and commands give the same octets"},

  {POLHODE_OPTION(image.dark_level), 0.0, 0.5, "of full scale",
   "a frame is dark, and skipped, unless 0.1 % of its pixels, or 400 of them, reach this; it is flat when its contrast is less"},
  {POLHODE_OPTION(image.saturated_level), 0.5, 1.0, "of full scale",
   "pixels at or above this are saturated"},

  {POLHODE_OPTION(mask.enabled), 0, 1, "",
   "separate the target from empty space; false: the whole image is the target"},
  {POLHODE_OPTION(mask.background), 0, 1, "",
   "separate the target from a lit background, too (Earth, room); needs mask.enabled"},
  {POLHODE_OPTION(mask.dark_level), 0.0, 0.5, "of full scale",
   "pixels at or below this are empty space; lower keeps dim parts of the target"},

  {POLHODE_OPTION(features.count_max), 50, limits::kFeatures, "",
   "features kept per frame at most; more: better poses, longer steps"},
  {POLHODE_OPTION(features.gamma), 1.0, 3.0, "",
   "gray level to this power is taken as light; 1: linear camera"},
  {POLHODE_OPTION(features.contrast_min), 0.001, 0.2, "of full scale",
   "least contrast of a feature, in light; lower: more and weaker features"},
  {POLHODE_OPTION(features.working_pixels_max), 10000, limits::kWorkingPixels, "px",
   "the target's region is resampled to at most this many pixels before detection; more: finer texture, longer steps"},
  {POLHODE_OPTION(features.sigma_px), 0.05, 5.0, "px",
   "1-sigma of a feature's image position at the finest scale; coarser features get more"},

  {POLHODE_OPTION(tracks.descriptor_ratio_max), 0.3, 1.0, "",
   "best over second-best descriptor distance of a match at most (ratio test); lower: fewer and safer matches"},
  {POLHODE_OPTION(tracks.forward_backward_max_px), 0.05, 5.0, "px",
   "optical flow forth and back must end this near to its start"},
  {POLHODE_OPTION(tracks.small_motion_max_px), 1.0, 100.0, "px",
   "features are tracked by optical flow up to this predicted image motion, beyond it detected and matched anew"},

  {POLHODE_OPTION(start.frames_min), 3, limits::kInitialFrames, "",
   "frames collected before the first hypothesis selection for a map; more: later and safer"},
  {POLHODE_OPTION(start.chi2_gap_commit), 9.0, 1000.0, "",
   "cost margin (chi-square) by which rivals of the chosen hypothesis, such as its depth-reversed solution, must be worse; 25: 5 sigma"},
  {POLHODE_OPTION(start.chi2_gap_convexity), 4.0, 1000.0, "",
   "smaller cost margin, accepted when the convexity cue agrees; at most start.chi2_gap_commit"},

  {POLHODE_OPTION(localise.inliers_min), 6, 200, "",
   "a frame with fewer inliers has no pose"},
  {POLHODE_OPTION(localise.ransac_iterations_max), 10, 5000, "",
   "pose hypotheses of one RANSAC at most"},
  {POLHODE_OPTION(localise.search_floor_px), 1.0, 50.0, "px",
   "least radius of the guided search about a landmark's predicted place"},

  {POLHODE_OPTION(map.keyframes_max), 8, limits::kKeyframes, "",
   "keyframes held at most; when full, the most redundant one goes"},
  {POLHODE_OPTION(map.keyframe_rotation_min_rad), 0.02, 0.5, "rad",
   "body rotation from the nearest keyframe that makes a new one; doubled when half of keyframes_max are held"},
  {POLHODE_OPTION(map.keyframe_tracked_min), 0.1, 0.95, "",
   "a keyframe comes sooner when a smaller fraction of the last one's landmarks is tracked"},
  {POLHODE_OPTION(map.window_keyframes), 3, 30, "",
   "keyframes that the windowed adjustment moves; more: longer jobs"},
  {POLHODE_OPTION(map.adjustment_observations_max), 1000,
   static_cast<int>(limits::kAdjustmentObservations), "",
   "observations of one adjustment at most: the best-seen landmarks take part, the others follow"},
  {POLHODE_OPTION(map.adjustment_iterations_max), 1, 100, "",
   "iterations of one adjustment at most"},
  {POLHODE_OPTION(map.landmark_parallax_min_rad), 0.005, 0.5, "rad",
   "least angle between the rays of a new landmark; larger: fewer landmarks, better depths"},

  {POLHODE_OPTION(shape.outlier_radius_spacings), 1.0, 50.0, "point spacings",
   "radius of the outlier test, in median distances of neighbouring points"},
  {POLHODE_OPTION(shape.outlier_neighbours_min), 1, 100, "",
   "points with fewer neighbours in that radius are removed"},
  {POLHODE_OPTION(shape.voxel_spacings), 0.2, 20.0, "point spacings",
   "edge of a voxel, whose points are replaced by their mean; larger: fewer points"},
  {POLHODE_OPTION(shape.plane_inlier_min), 0.01, 1.0, "",
   "a plane holds at least this fraction of the points; lower: smaller faces, more false ones"},
  {POLHODE_OPTION(shape.plane_iterations_max), 10, 10000, "",
   "RANSAC hypotheses of one plane or cylinder"},

  {POLHODE_OPTION(motion.mode), 0, 1, "",
   "dynamics: rigid-body fit where the poses support it, else local fits; paper: rates from pairs of poses"},
  {POLHODE_OPTION(motion.dynamics), 0, 1, "",
   "what moves the target; torque_free: nothing; orbit: gravity, the observer being on a circular orbit"},
  {POLHODE_OPTION(motion.window_poses_max), 4, limits::kMotionPoses, "",
   "poses of a local fit of the rate at most"},
  {POLHODE_OPTION(motion.window_angle_max_rad), 0.1, 3.0, "rad",
   "body rotation over that window at most; larger: less noise, more error of the polynomial"},
  {POLHODE_OPTION(motion.fit_poses_max), 16, limits::kMotionPoses, "",
   "poses of the rigid-body fit at most; when full, every other one of the older half goes"},
  {POLHODE_OPTION(motion.forgetting_s), 0.0, 1000000.0, "s",
   "older poses leave the rigid-body fit; 0: none does; for a torque that changes the rate slowly"},
  {POLHODE_OPTION(motion.mean_motion_rad_s), 0.00001, 0.01, "rad/s",
   "mean motion of the observer's circular orbit; used with dynamics = orbit, as q_IH and the epoch"},
  {POLHODE_OPTION(motion.q_IH_w), -1.0, 1.0, "",
   "quaternion that takes Hill's frame (radial, along track, normal) to inertial axes at the epoch; norm 1"},
  {POLHODE_OPTION(motion.q_IH_x), -1.0, 1.0, "", "as q_IH_w"},
  {POLHODE_OPTION(motion.q_IH_y), -1.0, 1.0, "", "as q_IH_w"},
  {POLHODE_OPTION(motion.q_IH_z), -1.0, 1.0, "", "as q_IH_w"},
  {POLHODE_OPTION(motion.orbit_epoch_ns), 0, kInt64Max, "ns",
   "time stamp at which q_IH holds"},

  {POLHODE_OPTION(bus.apid_first), 1, 2031, "",
   "APID (application process id) of the motion packet; the other packets follow, commands have + 15"},
  {POLHODE_OPTION(bus.housekeeping_every_frames), 1, 100000, "frames",
   "from one housekeeping packet to the next"},
  {POLHODE_OPTION(bus.model_every_frames), 1, 100000, "frames",
   "from one model packet to the next, and at least between sets of predictions"},
  {POLHODE_OPTION(bus.shape_every_frames), 1, 100000, "frames",
   "from one shape packet to the next, and at least between estimates; a fifth of that before the first"},
  {POLHODE_OPTION(bus.event_window_frames), 1, 100000, "frames",
   "window in which only a burst of events of one id is sent; the rest is counted"},
  {POLHODE_OPTION(bus.cloud_chunks_per_frame), 1, 4, "",
   "packets of a requested cloud in one frame"},

  {POLHODE_OPTION(jobs.delay_frames), 0, 60, "frames",
   "from the issue of a job for the second core to the step that takes its result; 0: one frame, but windows of the map are adjusted within the step"},
  {POLHODE_OPTION(jobs.delay_of_all_frames), 0, 60, "frames",
   "the same at most of an adjustment of the whole map, where keyframes are as far apart; 0, beside delay_frames = 0: no job leaves its step"},

  {POLHODE_OPTION(budget.frame_ms), 0.0, 10000.0, "ms",
   "time allowed for a step; longer ones are counted; 0: no limit"},
  {POLHODE_OPTION(budget.total_mb), 32, 16384, "MiB",
   "memory of the whole process; a plan that needs more is refused at start"},
  {POLHODE_OPTION(budget.general_mb), 2, 4096, "MiB",
   "pool for files and for what belongs to no other pool"},
  {POLHODE_OPTION(budget.step_mb), 4, 4096, "MiB",
   "pool for library calls within a step"},
  {POLHODE_OPTION(budget.jobs_mb), 4, 4096, "MiB",
   "pool for library calls of jobs"},
  {POLHODE_OPTION(budget.reserve_mb), 1, 4096, "MiB",
   "what a full pool draws on; when it is used up, the run ends with exit status 3"},

  {POLHODE_OPTION(scale.known_length_m), 0.001, 1000.0, "m",
   "distance between two points of the target; needs points_px and frame_timestamp_ns"},
  {POLHODE_OPTION(scale.points_px), -0.5, 16384.0, "px",
   "its two ends [[u, v], [u, v]] as seen in that frame, lens distortion included"},
  {POLHODE_OPTION(scale.range_m), 0.01, 100000.0, "m",
   "range finder's reading to the nearest surface on the boresight; needs frame_timestamp_ns"},
  {POLHODE_OPTION(scale.range_sigma_m), 0.0, 1000.0, "m",
   "1-sigma of range_m"},
  {POLHODE_OPTION(scale.frame_timestamp_ns), 0, kInt64Max, "ns",
   "time stamp of the frame that the length or the range belongs to"},
  {POLHODE_OPTION(scale.known_diameter_m), 0.001, 1000.0, "m",
   "diameter of the round body; the program finds the cylinder by itself"},
  {POLHODE_OPTION(scale.known_edge_m), 0.001, 1000.0, "m",
   "longest edge of the flat faces, which the program finds by itself; with another reading at hand, the edge that fits it"},

  {POLHODE_OPTION(camera.width_px), 32, limits::kImageSide, "px", "image width"},
  {POLHODE_OPTION(camera.height_px), 32, limits::kImageSide, "px", "image height"},
  {POLHODE_OPTION(camera.fu_px), 10.0, 1000000.0, "px",
   "focal length along u (to the right)"},
  {POLHODE_OPTION(camera.fv_px), 10.0, 1000000.0, "px",
   "focal length along v (down)"},
  {POLHODE_OPTION(camera.cu_px), -8192.0, 16384.0, "px",
   "principal point, u; the top-left pixel's centre is (0, 0)"},
  {POLHODE_OPTION(camera.cv_px), -8192.0, 16384.0, "px", "principal point, v"},
  {POLHODE_OPTION(camera.k1), -10.0, 10.0, "", "radial distortion, r^2"},
  {POLHODE_OPTION(camera.k2), -100.0, 100.0, "", "radial distortion, r^4"},
  {POLHODE_OPTION(camera.p1), -1.0, 1.0, "", "tangential distortion, as OpenCV's p1"},
  {POLHODE_OPTION(camera.p2), -1.0, 1.0, "", "tangential distortion, as OpenCV's p2"},
  {POLHODE_OPTION(camera.line_time_ns), -10000000.0, 10000000.0, "ns",
   "rolling shutter: time from one row to the next below it, negative where it reads upwards; the stamp is the middle row's; 0: global shutter"},
};
// clang-format on
#undef POLHODE_OPTION
#undef POLHODE_FIELD

template <typename T>
std::string number_text(T value) {
  char text[32];
  std::to_chars_result end = std::to_chars(text, text + sizeof text, value);
  if constexpr (std::is_floating_point_v<T>) {
    // Shortest form that reads back, but 100000 rather than 1e+05: easier to read, up to 9 digits.
    if (value >= 1.0 && value < 1e9) {
      end = std::to_chars(text, text + sizeof text, value, std::chars_format::fixed);
    }
  }
  std::string out(text, end.ptr);
  // A floating value keeps a point or an exponent, so that it reads back as one.
  if (std::is_floating_point_v<T> && out.find_first_of(".en") == std::string::npos) {
    out += ".0";
  }
  return out;
}

std::string text_of(bool value) { return value ? "true" : "false"; }
std::string text_of(int value) { return number_text(value); }
std::string text_of(std::int64_t value) { return number_text(value); }
std::string text_of(std::uint64_t value) { return number_text(value); }
std::string text_of(double value) { return number_text(value); }
template <typename Choice>
requires std::is_enum_v<Choice> std::string text_of(Choice choice) {
  const auto& words = choices_of(choice);
  const auto at = static_cast<std::size_t>(choice);  // any number in a damaged table
  return at < words.size() ? "\"" + std::string(words[at]) + "\"" : std::to_string(at);
}
std::string text_of(const PointPair& pair) {
  return "[[" + text_of(pair[0][0]) + ", " + text_of(pair[0][1]) + "], [" + text_of(pair[1][0]) +
         ", " + text_of(pair[1][1]) + "]]";
}

template <typename T>
requires std::is_arithmetic_v<T>
bool in_range(const ParameterRow& row, T value) {
  const auto number = static_cast<double>(value);
  return number >= row.low && number <= row.high;  // false for NaN
}
template <typename Choice>
requires std::is_enum_v<Choice>
bool in_range(const ParameterRow& /*row*/, Choice choice) {
  return static_cast<std::size_t>(choice) < choices_of(choice).size();
}
bool in_range(const ParameterRow& row, const PointPair& pair) {
  return in_range(row, pair[0][0]) && in_range(row, pair[0][1]) && in_range(row, pair[1][0]) &&
         in_range(row, pair[1][1]);
}

Error bad(std::string message) { return Error{ErrorCode::kBadParameter, std::move(message)}; }

std::optional<Error> check_points(const Parameters& parameters) {
  const ScaleOptions& scale = parameters.scale;
  if (scale.points_px[0] == scale.points_px[1]) {
    return bad("scale.points_px = " + text_of(scale.points_px) +
               ": the two ends coincide, allowed are two different points");
  }
  const CameraParameters& camera = parameters.camera;
  for (const std::array<double, 2>& point : scale.points_px) {
    const bool inside = point[0] <= camera.width_px - 0.5 && point[1] <= camera.height_px - 0.5;
    if (camera.width_px > 0 && !inside) {
      return bad("scale.points_px = " + text_of(scale.points_px) + ": outside the image, allowed " +
                 "u -0.5 .. " + text_of(camera.width_px - 0.5) + ", v -0.5 .. " +
                 text_of(camera.height_px - 0.5));
    }
  }
  return std::nullopt;
}

/// Checks only the given lengths, and the values that belong to them.
std::optional<Error> check_scale(const Parameters& parameters) {
  const ScaleOptions& scale = parameters.scale;
  struct Given {
    bool given;
    std::string_view key;
  };
  const bool length = scale.known_length_m != 0.0;
  const bool range = scale.range_m != 0.0;
  for (const auto& [given, key] : {Given{length, "scale.known_length_m"},
                                   Given{length, "scale.points_px"},
                                   Given{range, "scale.range_m"},
                                   Given{range, "scale.range_sigma_m"},
                                   Given{length || range, "scale.frame_timestamp_ns"},
                                   Given{scale.known_diameter_m != 0.0, "scale.known_diameter_m"},
                                   Given{scale.known_edge_m != 0.0, "scale.known_edge_m"}}) {
    if (!given) {
      continue;
    }
    if (auto problem = check_row(*find_parameter(key), parameters)) {
      return problem;
    }
  }
  return length ? check_points(parameters) : std::nullopt;
}

std::optional<Error> check_orbit(const MotionOptions& motion) {
  const double norm = std::hypot(std::hypot(motion.q_IH_w, motion.q_IH_x),
                                 std::hypot(motion.q_IH_y, motion.q_IH_z));
  if (motion.dynamics != DynamicsKind::kOrbit || std::abs(norm - 1.0) < bus::kNormTolerance) {
    return std::nullopt;
  }
  return bad("motion.q_IH_w and its x, y, z: norm " + text_of(norm) + ", allowed 0.999 .. 1.001");
}

std::optional<Error> check_section(const Parameters& parameters, bool camera) {
  for (const ParameterRow& row : kRows) {
    if (row.key.starts_with("scale.") || row.key.starts_with("camera.") != camera) {
      continue;
    }
    if (auto problem = check_row(row, parameters)) {
      return problem;
    }
  }
  return std::nullopt;
}

}  // namespace

std::span<const ParameterRow> parameter_table() { return kRows; }

const ParameterRow* find_parameter(std::string_view key) {
  for (const ParameterRow& row : kRows) {
    if (row.key == key) {
      return &row;
    }
  }
  return nullptr;
}

bool has_no_default(std::string_view key) {
  return key.starts_with("camera.") || key.starts_with("scale.");
}

std::string value_text(const ParameterRow& row, const Parameters& parameters) {
  return std::visit([&](auto where) { return text_of(where(readable(parameters))); }, row.member);
}

std::string range_text(const ParameterRow& row) {
  if (std::holds_alternative<Member<bool>>(row.member)) {
    return "true, false";
  }
  const auto words = [](const auto& choices) {
    std::string text;
    for (const std::string_view choice : choices) {
      text += (text.empty() ? "\"" : ", \"") + std::string(choice) + "\"";
    }
    return text;
  };
  if (std::holds_alternative<Member<MotionMode>>(row.member)) {
    return words(choices_of(MotionMode{}));
  }
  if (std::holds_alternative<Member<DynamicsKind>>(row.member)) {
    return words(choices_of(DynamicsKind{}));
  }
  if (std::holds_alternative<Member<double>>(row.member) ||
      std::holds_alternative<Member<PointPair>>(row.member)) {
    return text_of(row.low) + " .. " + text_of(row.high);
  }
  return text_of(static_cast<std::int64_t>(row.low)) + " .. " +
         text_of(static_cast<std::int64_t>(row.high));
}

std::optional<Error> check_row(const ParameterRow& row, const Parameters& parameters) {
  const bool good = std::visit(
      [&](auto where) { return in_range(row, where(readable(parameters))); }, row.member);
  if (good) {
    return std::nullopt;
  }
  return bad(std::string(row.key) + " = " + value_text(row, parameters) +
             ": out of range, allowed " + range_text(row));
}

std::optional<Error> check_without_camera(const Parameters& parameters) {
  if (auto problem = check_section(parameters, false)) {
    return problem;
  }
  const InitialOptions& start = parameters.start;
  if (start.chi2_gap_convexity > start.chi2_gap_commit) {
    return bad("start.chi2_gap_convexity = " + text_of(start.chi2_gap_convexity) +
               ": out of range, allowed 4.0 .. " + text_of(start.chi2_gap_commit) +
               " (start.chi2_gap_commit)");
  }
  if (auto problem = check_orbit(parameters.motion)) {
    return problem;
  }
  return check_scale(parameters);
}

std::optional<Error> check(const Parameters& parameters) {
  if (auto problem = check_section(parameters, true)) {
    return problem;
  }
  return check_without_camera(parameters);
}

}  // namespace polhode
