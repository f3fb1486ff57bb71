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

// A map is begun with the third or fourth frame, and flow, matching and adjustments follow it.
constexpr int kFrames = 8;
constexpr double kTurn_rad = 0.05;
constexpr double kPart = 0.35;  ///< of the picture's lesser side, the ball's radius
constexpr std::int64_t kInterval_ns = 100'000'000;

/// A ball with round patches of all sizes, seen from afar.
class PatchedBall {
 public:
  explicit PatchedBall(const CameraParameters& camera)
      : width_(camera.width_px),
        height_(camera.height_px),
        radius_px_(kPart * std::min(camera.width_px, camera.height_px)),
        picture_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_)) {
    Rng rng(1, 6201);
    for (Patch& patch : patches_) {
      patch.middle = Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
      patch.cosine_edge = std::cos(0.05 + 0.2 * rng.uniform());
      patch.height = (rng.uniform() < 0.5 ? -1.0 : 1.0) * (30.0 + 40.0 * rng.uniform());
    }
  }

  ImageView turned_by(double angle_rad) {
    const Eigen::Matrix3d R = so3_exp(Eigen::Vector3d(0.1, 1.0, 0.05).normalized() * angle_rad);
    for (int v = 0; v < height_; ++v) {
      for (int u = 0; u < width_; ++u) {
        const double x = (u - 0.5 * width_) / radius_px_;
        const double y = (v - 0.5 * height_) / radius_px_;
        const double z2 = 1.0 - x * x - y * y;
        const auto i = static_cast<std::size_t>(v) * static_cast<std::size_t>(width_) +
                       static_cast<std::size_t>(u);
        picture_[i] =
            z2 > 0.0 ? level_at(R.transpose() * Eigen::Vector3d(x, y, -std::sqrt(z2))) : 0;
      }
    }
    return {.data = picture_.data(), .width_px = width_, .height_px = height_, .stride_octets = width_};
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

  int width_;
  int height_;
  double radius_px_;
  std::array<Patch, 150> patches_;
  std::vector<std::uint8_t> picture_;
};

}  // namespace

int warm_up(const ComponentMemory& memory, const Parameters& parameters) {
  Result<Component*> made = Component::create(memory.span(), parameters);
  POLHODE_ASSERT(made.ok(), 0);  // the run's own component is made of the same
  Component* const component = made.value();
  PatchedBall ball(parameters.camera);
  Worker worker({.own_thread = false});
  int poses = 0;
  for (int i = 0; i < kFrames; ++i) {
    const Frame frame{.timestamp_ns = (i + 1) * kInterval_ns, .image = ball.turned_by(i * kTurn_rad)};
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
