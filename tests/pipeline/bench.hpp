// A component in memory of its own, and pictures to feed it.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "base/rng.hpp"
#include "geometry/pose.hpp"
#include "geometry/so3.hpp"
#include "pipeline/component.hpp"

namespace polhode::bench {

inline constexpr int kWidth = 320;
inline constexpr int kHeight = 240;
inline constexpr double kFocal_px = 600.0;

using Picture = std::vector<std::uint8_t>;

inline Parameters parameters() {
  Parameters p;
  p.camera = {.width_px = kWidth,
              .height_px = kHeight,
              .fu_px = kFocal_px,
              .fv_px = kFocal_px,
              .cu_px = 160.0,
              .cv_px = 120.0};
  p.jobs = {
      .delay_frames = 0,
      .delay_of_all_frames = 0};  // all within the step: a test shows frames, and runs no jobs
  return p;
}

/// Memory as a caller would acquire it: aligned to 64 octets, filled with what others left there.
class Memory {
 public:
  explicit Memory(std::size_t octets)
      : octets_(octets),
        data_(static_cast<std::byte*>(::operator new (octets, std::align_val_t{64}))) {
    std::fill(data_.get(), data_.get() + octets, std::byte{0xA5});
  }
  [[nodiscard]] std::span<std::byte> view() const { return {data_.get(), octets_}; }

 private:
  struct Free {
    void operator()(std::byte* data) const { ::operator delete (data, std::align_val_t{64}); }
  };
  std::size_t octets_;
  std::unique_ptr<std::byte, Free> data_;
};

inline Frame frame_of(std::int64_t timestamp_ns,
                      const Picture& picture,
                      int width_px = kWidth,
                      int height_px = kHeight) {
  return {.timestamp_ns = timestamp_ns,
          .image = {.data = picture.data(),
                    .width_px = width_px,
                    .height_px = height_px,
                    .stride_bytes = width_px}};
}

/// A frame that the camera could not deliver whole.
inline Frame unreadable(std::int64_t timestamp_ns) {
  return {.timestamp_ns = timestamp_ns, .image = {}, .readable = false};
}

/// A component that was made without trouble.
struct Bench {
  explicit Bench(const Parameters& p = parameters()) : memory(memory_needed(p).total) {
    Result<Component*> made = Component::create(memory.view(), p);
    EXPECT_TRUE(made.ok());
    component = made.value();
  }
  const StepOutput& show(const Picture& picture) {
    return component->step({.frame = frame_of(++time_s * kSecond_ns, picture)});
  }

  static constexpr std::int64_t kSecond_ns = 1'000'000'000;
  Memory memory;
  Component* component = nullptr;
  std::int64_t time_s = 0;
};

inline Picture uniform(int level) {
  return Picture(kWidth * kHeight, static_cast<std::uint8_t>(level));
}

inline Picture noise(std::uint64_t seed) {
  Rng rng(seed, 151);
  Picture picture(kWidth * kHeight);
  for (std::uint8_t& pixel : picture) {
    pixel = static_cast<std::uint8_t>(rng.below(256));
  }
  return picture;
}

/// Something else than the target: blots of some 8 px all over the picture.
inline Picture clutter(std::uint64_t seed) {
  constexpr int kGrain_px = 8;
  constexpr int kColumns = kWidth / kGrain_px + 2;
  constexpr int kRows = kHeight / kGrain_px + 2;
  Rng rng(seed, 153);
  std::vector<double> level(static_cast<std::size_t>(kColumns * kRows));
  for (double& one : level) {
    one = 20.0 + 200.0 * rng.uniform();
  }
  Picture picture(kWidth * kHeight);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) {
      const auto at = static_cast<std::size_t>((v / kGrain_px) * kColumns + u / kGrain_px);
      const double right = static_cast<double>(u % kGrain_px) / kGrain_px;
      const double down = static_cast<double>(v % kGrain_px) / kGrain_px;
      const double upper = level[at] + right * (level[at + 1] - level[at]);
      const double lower =
          level[at + kColumns] + right * (level[at + kColumns + 1] - level[at + kColumns]);
      picture[static_cast<std::size_t>(v * kWidth + u)] =
          static_cast<std::uint8_t>(upper + down * (lower - upper));
    }
  }
  return picture;
}

/// A ball of radius 1 with patches of all sizes on it, seen against black.
class Ball {
 public:
  explicit Ball(std::uint64_t seed) {
    Rng rng(seed, 152);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector3d n =
          Eigen::Vector3d(rng.normal(), rng.normal(), rng.normal()).normalized();
      const double reach = 0.04 + 0.12 * rng.uniform() * rng.uniform();
      patches_.push_back(
          {n, std::cos(reach), (rng.uniform() < 0.5 ? -1.0 : 1.0) * (30.0 + 40.0 * rng.uniform())});
      for (std::size_t cell = 0; cell < near_.size(); ++cell) {
        const double chord = 2.0 * std::sin(0.5 * reach);
        if ((middle_of(cell) - n).norm() <= chord + kHalfDiagonal) {
          near_[cell].push_back(patches_.size() - 1);
        }
      }
    }
  }

  [[nodiscard]] Picture seen_from(const Pose& pose) const {
    return seen_by_rows([&](int) { return pose; });
  }

  /// Each row sees the pose of its own time.
  template <typename PoseOfRow>
  [[nodiscard]] Picture seen_by_rows(const PoseOfRow& pose_of_row) const {
    Picture picture(kWidth * kHeight, 0);
    for (int v = 0; v < kHeight; ++v) {
      const Pose pose = pose_of_row(v);
      for (int u = 0; u < kWidth; ++u) {
        const Eigen::Vector3d ray =
            Eigen::Vector3d((u - 160.0) / kFocal_px, (v - 120.0) / kFocal_px, 1.0).normalized();
        const double along = ray.dot(pose.p_CT);
        const double under_root = along * along - pose.p_CT.squaredNorm() + 1.0;
        if (under_root > 0.0) {
          const Eigen::Vector3d p_C = (along - std::sqrt(under_root)) * ray;
          picture[static_cast<std::size_t>(v * kWidth + u)] =
              level_at(pose.R_CT.transpose() * (p_C - pose.p_CT));
        }
      }
    }
    return picture;
  }

 private:
  struct Patch {
    Eigen::Vector3d middle;
    double cosine_edge;
    double height;
  };

  /// Cells of a grid over the cube about the ball: of 500 patches only those near a cell reach it.
  static constexpr int kCells = 16;
  static constexpr double kSide = 2.0 / kCells;
  static constexpr double kHalfDiagonal = 0.87 * kSide;  // half of sqrt(3), rounded up

  [[nodiscard]] static std::size_t cell_of(const Eigen::Vector3d& n) {
    const auto along = [](double x) {
      return static_cast<std::size_t>(
          std::clamp(static_cast<int>((x + 1.0) / kSide), 0, kCells - 1));
    };
    return (along(n.x()) * kCells + along(n.y())) * kCells + along(n.z());
  }
  [[nodiscard]] static Eigen::Vector3d middle_of(std::size_t cell) {
    const auto along = [](std::size_t i) {
      return (static_cast<double>(i % kCells) + 0.5) * kSide - 1.0;
    };
    return {along(cell / (kCells * kCells)), along(cell / kCells), along(cell)};
  }

  [[nodiscard]] std::uint8_t level_at(const Eigen::Vector3d& n) const {
    double level = 120.0;
    for (const std::size_t near : near_[cell_of(n)]) {
      const Patch& patch = patches_[near];
      const double inside = (n.dot(patch.middle) - patch.cosine_edge) / (1.0 - patch.cosine_edge);
      level += inside > 0.0 ? patch.height * inside * inside * (3.0 - 2.0 * inside) : 0.0;
    }
    return static_cast<std::uint8_t>(std::clamp(level, 40.0, 250.0));
  }
  std::vector<Patch> patches_;
  std::vector<std::vector<std::size_t>> near_ =
      std::vector<std::vector<std::size_t>>(kCells * kCells * kCells);
};

inline constexpr double kTurn_rad = 0.07;  ///< of the turning ball from frame to frame, 4 deg

/// Where the turning ball is at a frame, or between two.
inline Pose turning(double frame) {
  const Eigen::Vector3d axis = Eigen::Vector3d(0.2, 1.0, 0.1).normalized();
  return {.R_CT = so3_exp(kTurn_rad * frame * axis), .p_CT = {0.05, -0.02, 8.0}};
}

/// What the camera sees of it, frame by frame.
inline std::vector<Picture> images_of_turning(int frames) {
  const Ball ball(3);
  std::vector<Picture> pictures;
  for (int i = 0; i < frames; ++i) {
    pictures.push_back(ball.seen_from(turning(i)));
  }
  return pictures;
}

/// The first of them, one step each.
inline void show_first(const std::vector<Picture>& pictures, int frames, Bench* b) {
  for (int i = 0; i < frames; ++i) {
    (void)b->show(pictures[static_cast<std::size_t>(i)]);
  }
}

inline Eigen::Matrix3d rotation_of(const MotionState& m) {
  return Eigen::Quaterniond(m.q_CT[0], m.q_CT[1], m.q_CT[2], m.q_CT[3]).toRotationMatrix();
}

}  // namespace polhode::bench
