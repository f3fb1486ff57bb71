#include "pipeline/picture.hpp"

#include <algorithm>

namespace polhode {
namespace {

constexpr int kCountLeast = 50;  // as a configuration may say

}  // namespace

void stage_done(Stage stage, const Component::State& s) {
  if (s.hook != nullptr) {
    s.hook(s.hook_context, stage);
  }
}

void forget_picture(Component::State* s) {
  s->features_ready = false;
  s->features.clear();
  s->localised.matches.clear();
}

FrameUse take_picture(const Frame& frame, Component::State* s) {
  if (!frame.readable || frame.image.data == nullptr) {
    return FrameUse::kUnreadable;
  }
  if (frame.image.width_px != s->camera.width_px || frame.image.height_px != s->camera.height_px) {
    return FrameUse::kWrongSize;
  }
  import_frame(frame.image, &s->gray);
  const ImageQuality quality = assess(s->gray, s->parameters.image);
  stage_done(Stage::kImage, *s);
  if (quality.dark) {
    return FrameUse::kDark;
  }
  find_target(s->gray, s->parameters.mask, &s->mask);
  stage_done(Stage::kMask, *s);
  return FrameUse::kUsed;
}

void ensure_features(Component::State* s) {
  if (!s->features_ready) {
    FeatureOptions options = s->parameters.features;
    if (s->steps_to_shed > 0) {  // half the pixels, and as many features as those give
      options.working_pixels_max /= 2;
      options.count_max = std::max(kCountLeast, options.count_max / 2);
    }
    detect_features(s->gray, s->mask, s->camera, options, &s->feature_workspace, &s->features);
    s->features_ready = true;
    stage_done(Stage::kFeatures, *s);
  }
}

}  // namespace polhode
