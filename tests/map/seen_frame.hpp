// A mapped body and one image of it, as the functions of map/track.hpp take them.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "map/track.hpp"
#include "synthetic_map.hpp"

namespace polhode::synthetic {

struct SeenFrame {
  std::unique_ptr<MapState> state = std::make_unique<MapState>();
  CameraModel model = camera();
  LocaliseOptions localise;
  TrackOptions tracks;
  MapOptions options;
  cv::Mat gray;
  Picture image;

  [[nodiscard]] MapInput input() const {
    return {.gray = &gray,
            .features = image.features.get(),
            .camera = &model,
            .localise = &localise,
            .tracks = &tracks,
            .options = &options,
            .features_max = limits::kFeatures,
            .seed = 1};
  }
};

}  // namespace polhode::synthetic
