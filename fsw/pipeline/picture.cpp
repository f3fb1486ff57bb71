#include "pipeline/picture.hpp"

namespace polhode {

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
    detect_features(s->gray, s->mask, s->camera, s->parameters.features, &s->features);
    s->features_ready = true;
    stage_done(Stage::kFeatures, *s);
  }
}

}  // namespace polhode
