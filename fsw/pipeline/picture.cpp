#include "pipeline/picture.hpp"

#include <algorithm>
#include <utility>

#include "mask/behind.hpp"
#include "pipeline/frame_uses.hpp"

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
  s->pyramid.built = false;
  s->verdict = {};
  s->localised.matches.clear();
}

void forget_pictures(Component::State* s) {
  clear(&s->mask_state);
  clear(&s->quality);
}

namespace {

FrameUse use_of(const FrameVerdict& verdict) {
  const FrameFaultRow* const fault = row_of(verdict.fault);
  return verdict.decision == FrameDecision::kSkip && fault != nullptr ? fault->skipped
                                                                      : FrameUse::kUsed;
}

}  // namespace

FrameUse bring_picture(const Frame& frame, Component::State* s) {
  if (!frame.readable || frame.image.data == nullptr) {
    return FrameUse::kUnreadable;
  }
  if (frame.image.width_px != s->camera.width_px || frame.image.height_px != s->camera.height_px) {
    return FrameUse::kWrongSize;
  }
  if (std::exchange(s->reference.gray_to_come, false)) {
    std::swap(s->gray, s->reference.gray);
  }
  import_frame(frame.image, &s->gray);
  return FrameUse::kUsed;
}

FrameUse take_picture(const Frame& frame, Component::State* s) {
  const FrameUse brought = bring_picture(frame, s);
  if (brought != FrameUse::kUsed) {
    return brought;
  }
  s->verdict = assess(s->gray, s->parameters.image, &s->quality);
  stage_done(Stage::kImage, *s);
  const FrameUse use = use_of(s->verdict);
  return use;
}

MaskPrior mask_prior(const Pose& pose, Component::State* s) {
  // Enough to outline a body by those that have proved themselves alone.
  constexpr int kConfirmedMin = 30;
  int proved = 0;
  for (const bool all : {false, true}) {
    s->prior_points_px.clear();
    for (const Landmark& landmark : s->map.landmarks) {
      Eigen::Vector2d pixel;
      if (landmark.used && (all || confirmed(landmark)) &&
          should_be_seen(landmark, pose, s->camera, &pixel)) {
        (void)s->prior_points_px.push_back(cv::Point2d(pixel.x(), pixel.y()));
        proved += all ? 0 : 1;
      }
    }
    if (proved >= kConfirmedMin) {
      break;
    }
  }
  return {.points_px = s->prior_points_px.view(),
          .radius_px = s->map.radius_mu * s->camera.focal_px() / pose.p_CT.z()};
}

void look_for_target(const std::optional<PosePrediction>& predicted, Component::State* s) {
  const MaskOptions& options = s->parameters.mask;
  find_target(s->gray, options, &s->mask);
  MaskPrior prior;
  if (s->mode == Mode::kTracking && options.tells_background() && rim_is_lit(s->mask.cells) &&
      predicted) {
    prior = mask_prior(predicted->pose, s);
  }
  follow_target(s->gray, prior, options, &s->mask_state, &s->mask);
  stage_done(Stage::kMask, *s);
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
