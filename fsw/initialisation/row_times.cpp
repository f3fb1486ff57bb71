#include "initialisation/row_times.hpp"

#include "features/row_times.hpp"

namespace polhode {
namespace {

struct TimedPoint {
  Eigen::Vector2d seen = Eigen::Vector2d::Zero();  ///< normalised
  double time_s = 0.0;                             ///< of its row, since the newest frame's
};

TimedPoint timed(const TrackPoint& point, const CameraModel& camera, const TrackTable& table) {
  const CollectedFrame& frame = table.frames[static_cast<std::size_t>(point.frame)];
  const Feature& f = feature_of(point, table);
  const std::int64_t since_ns = frame.timestamp_ns - table.frames.back().timestamp_ns;
  return {.seen = undistort(camera, {f.u_px, f.v_px}),
          .time_s = 1e-9 * static_cast<double>(since_ns) +
                    row_delay_s(camera, static_cast<double>(f.v_px))};
}

ImageMotion motion_to_newest(const CameraModel& camera, const TrackTable& table) {
  FixedVector<MovingPoint, limits::kFeatures> points;
  const auto newest = static_cast<std::int32_t>(table.frames.size()) - 1;
  for (const Track& track : table.tracks) {
    const std::size_t count = track.points.size();
    if (count < 2 || track.points[count - 1].frame != newest) {
      continue;
    }
    const TimedPoint now = timed(track.points[count - 1], camera, table);
    const TimedPoint before = timed(track.points[count - 2], camera, table);
    const double interval_s = now.time_s - before.time_s;
    if (interval_s > 0.0) {
      (void)points.push_back(
          {.normalised = now.seen, .velocity_per_s = (now.seen - before.seen) / interval_s});
    }
  }
  return fit_image_motion(points.view());
}

}  // namespace

void to_frame_time(const CameraModel& camera, TrackTable* table) {
  const std::size_t count = table->frames.size();
  if (camera.line_time_s == 0.0 || count < 2) {
    return;
  }
  const ImageMotion motion = motion_to_newest(camera, *table);
  to_frame_time(camera, motion, &table->frames[count - 1].features);
  if (count == 2) {
    to_frame_time(camera, motion, &table->frames[0].features);
  }
}

}  // namespace polhode
