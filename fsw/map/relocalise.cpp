#include <vector>

#include "map/descriptor_table.hpp"
#include "map/localise.hpp"

namespace polhode {

namespace {

/// Matches features to the nearest landmarks of `table`, then solves for a pose.
Result<bool> relocalise_among(const DescriptorTable& table,
                              const LocaliseInput& input,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out) {
  if (table.landmark.empty()) {
    return ErrorCode::kTooFewObservations;
  }
  const std::vector<Neighbours> found = nearest_rows(table, *input.features);
  out->matches.clear();
  const double ratio2 = input.ratio_max * input.ratio_max;
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (found[f].nearest < 0) {
      continue;
    }
    const std::int32_t landmark = table.landmark[static_cast<std::size_t>(found[f].nearest)];
    // The second best is no rival if it is another view of the same landmark.
    const bool rival = found[f].second >= 0 &&
                       table.landmark[static_cast<std::size_t>(found[f].second)] != landmark;
    const bool clear = !rival || static_cast<double>(found[f].distance2_nearest) <=
                                     ratio2 * static_cast<double>(found[f].distance2_second);
    if (clear && found[f].distance2_nearest <= static_cast<float>(kDistance2Max)) {
      const Feature& feature = (*input.features)[f];
      (void)out->matches.push_back({.landmark = LandmarkId{landmark},
                                    .feature = static_cast<std::int32_t>(f),
                                    .u_px = feature.u_px,
                                    .v_px = feature.v_px,
                                    .normalised = feature.normalised,
                                    .sigma_px = static_cast<double>(feature.sigma_px),
                                    .inlier = false});
    }
  }
  return localise_matched(input, scratch, out);
}

}  // namespace

Result<bool> relocalise(const LocaliseInput& input, LocaliseScratch* scratch, LocalisedFrame* out) {
  const auto all = [](const Landmark&) { return true; };
  return relocalise_among(views_of(*input.map, 0, all), input, scratch, out);
}

Result<bool> relocalise_elsewhere(const LocaliseInput& input,
                                  const Pose& found,
                                  LocaliseScratch* scratch,
                                  LocalisedFrame* out) {
  const auto hidden = [&](const Landmark& landmark) {
    Eigen::Vector2d pixel;
    return !should_be_seen(landmark, found, *input.camera, &pixel);
  };
  return relocalise_among(views_of(*input.map, 0, hidden), input, scratch, out);
}

}  // namespace polhode
