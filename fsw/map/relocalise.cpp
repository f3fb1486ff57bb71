#include <vector>

#include "map/localise.hpp"
#include "solve/neighbours.hpp"

namespace polhode {

namespace {

struct DescriptorTable {
  std::vector<std::uint8_t> octets;
  std::vector<std::int32_t> landmark;  ///< slot, per row
};

/// Views of the landmarks that take part, at most kRowsMax: of more every second landmark, or every
/// third, stands for the rest.
template <typename TakesPart>
DescriptorTable views_of(const Map& map, const TakesPart& takes_part) {
  constexpr std::size_t kRowsMax = 4000;  // 600 x 3200 distances take 7 ms
  std::size_t rows = 0;
  for (const Landmark& landmark : map.landmarks) {
    rows += landmark.used && takes_part(landmark) ? landmark.views.size() : 0;
  }
  const std::size_t stride = rows / kRowsMax + 1;
  DescriptorTable table;
  std::size_t counted = 0;
  for (std::size_t i = 0; i < map.landmarks.size(); ++i) {
    if (!map.landmarks[i].used || !takes_part(map.landmarks[i]) || counted++ % stride != 0) {
      continue;
    }
    for (const LandmarkView& view : map.landmarks[i].views) {
      table.octets.insert(table.octets.end(), view.descriptor.begin(), view.descriptor.end());
      table.landmark.push_back(static_cast<std::int32_t>(i));
    }
  }
  return table;
}

/// Features and the landmarks of `table` that look most alike, then a pose from them.
Result<bool> relocalise_among(const DescriptorTable& table,
                              const LocaliseInput& input,
                              LocaliseScratch* scratch,
                              LocalisedFrame* out) {
  if (table.landmark.empty()) {
    return ErrorCode::kTooFewObservations;
  }
  std::vector<std::uint8_t> queries;
  for (const Feature& feature : *input.features) {
    queries.insert(queries.end(), feature.descriptor.begin(), feature.descriptor.end());
  }
  std::vector<Neighbours> found(input.features->size());
  nearest_descriptors(table.octets, queries, found);
  out->matches.clear();
  const double ratio2 = input.ratio_max * input.ratio_max;
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (found[f].nearest < 0) {
      continue;
    }
    const std::int32_t landmark = table.landmark[static_cast<std::size_t>(found[f].nearest)];
    // The second best may be another view of the same landmark: then it is no rival.
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
  return relocalise_among(views_of(*input.map, all), input, scratch, out);
}

Result<bool> relocalise_elsewhere(const LocaliseInput& input,
                                  const Pose& found,
                                  LocaliseScratch* scratch,
                                  LocalisedFrame* out) {
  const auto hidden = [&](const Landmark& landmark) {
    Eigen::Vector2d pixel;
    return !should_be_seen(landmark, found, *input.camera, &pixel);
  };
  return relocalise_among(views_of(*input.map, hidden), input, scratch, out);
}

}  // namespace polhode
