#include "app/warm_up.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "base/assert.hpp"
#include "base/rng.hpp"
#include "geometry/so3.hpp"
#include "os/linux/memory/region.hpp"
#include "os/linux/worker.hpp"
#include "pipeline/component.hpp"

namespace polhode::platform {
namespace {

// A map is begun with the first hypothesis selection or soon after, and flow, matching and
// adjustments follow it; not with every camera: under very wide lenses and in small images none
// is, and the first map of the run itself takes longer.
constexpr int kFramesAfterSelection = 3;
constexpr double kTurn_rad = 0.05;
constexpr double kPart = 0.35;  ///< of the image's lesser side, the ball's radius
constexpr std::int64_t kInterval_ns = 100'000'000;

/// A ball of radius 1 with round patches of all sizes, straight ahead. As the camera sees it: under
/// parallel rays a map would not be begun.
class PatchedBall {
 public:
  explicit PatchedBall(const CameraParameters& camera)
      : camera_(camera),
        distance_(
            std::hypot(camera.fu_px / (kPart * std::min(camera.width_px, camera.height_px)), 1.0)),
        image_(static_cast<std::size_t>(camera.width_px) *
               static_cast<std::size_t>(camera.height_px)) {
    Rng rng(1, 6201);
    for (Patch& patch : patches_) {
      patch.middle = Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
      patch.cosine_edge = std::cos(0.05 + 0.2 * rng.uniform());
      patch.height = (rng.uniform() < 0.5 ? -1.0 : 1.0) * (30.0 + 40.0 * rng.uniform());
    }
  }

  ImageView turned_by(double angle_rad) {
    const Eigen::Matrix3d R_TC =
        so3_exp(Eigen::Vector3d(0.1, 1.0, 0.05).normalized() * angle_rad).transpose();
    std::size_t i = 0;
    for (int v = 0; v < camera_.height_px; ++v) {
      for (int u = 0; u < camera_.width_px; ++u) {
        const Eigen::Vector3d ray_C =
            Eigen::Vector3d(
                (u - camera_.cu_px) / camera_.fu_px, (v - camera_.cv_px) / camera_.fv_px, 1.0)
                .normalized();
        const double along = distance_ * ray_C.z();
        const double within = along * along - distance_ * distance_ + 1.0;
        const Eigen::Vector3d normal_C =
            (along - std::sqrt(std::max(within, 0.0))) * ray_C - Eigen::Vector3d(0, 0, distance_);
        image_[i++] = within > 0.0 ? level_at(R_TC * normal_C) : 0;
      }
    }
    return {.data = image_.data(),
            .width_px = camera_.width_px,
            .height_px = camera_.height_px,
            .stride_bytes = camera_.width_px};
  }

 private:
  struct Patch {
    Eigen::Vector3d middle;
    double cosine_edge;
    double height;
  };

  [[nodiscard]] std::uint8_t level_at(const Eigen::Vector3d& n) const {
    double level = 120.0;
    for (const Patch& patch : patches_) {
      level += n.dot(patch.middle) > patch.cosine_edge ? patch.height : 0.0;
    }
    return static_cast<std::uint8_t>(std::clamp(level, 40.0, 250.0));
  }

  CameraParameters camera_;
  double distance_;
  std::array<Patch, 150> patches_;
  std::vector<std::uint8_t> image_;
};

}  // namespace

int warm_up(const ComponentMemory& memory, const Parameters& parameters) {
  Result<Component*> made = Component::create(memory.span(), parameters);
  POLHODE_ASSERT(made.ok(), 0);  // the run's own component is made of the same
  Component* const component = made.value();
  PatchedBall ball(parameters.camera);
  Worker worker({.own_thread = false});
  int poses = 0;
  const int frames = parameters.start.frames_min + kFramesAfterSelection;
  for (int i = 0; i < frames; ++i) {
    const Frame frame{.timestamp_ns = (i + 1) * kInterval_ns,
                      .image = ball.turned_by(i * kTurn_rad)};
    const Jobs finished = worker.due(component->next_step());
    const PoolScope scope(Pool::kStep);
    const StepOutput& out = component->step({.frame = frame, .finished = finished});
    poses += out.motion.pose_valid ? 1 : 0;
    worker.submit(out.jobs);
  }
  const PoolScope scope(Pool::kStep);
  Component::destroy(component);
  return poses;
}

}  // namespace polhode::platform
