#include "features/detect.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "features/descriptor.hpp"
#include "features/orientation.hpp"
#include "features/region.hpp"
#include "features/workspace.hpp"

namespace polhode {
namespace {

/// Largest enlargement. The finest texture of a small region lies under the detector's smallest
/// blob. At twice the size three times as many features repeat. At three times no more do, but
/// their positions are better. More adds interpolation, not texture (decision 0020).
constexpr double kEnlargeMax = 3.0;

/// Assumed blur of the working image, in its pixels. An enlarged one has more. A small value puts
/// the finest levels closer together, which finds more features than the true blur, with better
/// positions.
constexpr double kImageBlur_px = 0.6;

struct Context {
  const sift::ScaleSpace& space;
  const sift::Region& region;
  const CameraModel& camera;
  const FeatureOptions& options;
};

/// Place, size and sigma in the camera's image.
Feature to_feature(const sift::Blob& blob, const Context& context) {
  const double octave = static_cast<double>(1 << blob.octave);
  const sift::Region& region = context.region;
  Feature f;
  f.u_px = static_cast<float>(region.u_px(static_cast<double>(blob.x) * octave));
  f.v_px = static_cast<float>(region.v_px(static_cast<double>(blob.y) * octave));
  f.scale_px = static_cast<float>(octave * static_cast<double>(sift::sigma_of_level(blob.level)) /
                                  region.size.factor_u);
  f.normalised = undistort(context.camera, {f.u_px, f.v_px});
  // Radius up to which pixel noise limits a blob's position. Chosen, near the finest (1.6 px).
  // Above it the variance grows as the radius.
  constexpr double kFineRadius_px = 2.0;
  const double coarseness = std::max(1.0, static_cast<double>(f.scale_px) / kFineRadius_px);
  f.sigma_px = static_cast<float>(context.options.sigma_px * std::sqrt(coarseness));
  return f;
}

/// One feature for each orientation of the blob, up to `count_max`.
void add_features(const sift::Blob& blob,
                  const Context& context,
                  std::size_t count_max,
                  Features* features) {
  const auto nearest = static_cast<std::size_t>(std::lround(blob.level));
  const sift::Plane& level = context.space.level[static_cast<std::size_t>(blob.octave)][nearest];
  const float sigma_px = sift::sigma_of_level(blob.level);
  sift::Orientations orientations;
  sift::find_orientations(level, blob.x, blob.y, sigma_px, &orientations);
  Feature f = to_feature(blob, context);
  for (const float angle_rad : orientations) {
    if (features->size() >= count_max) {
      return;
    }
    f.angle_rad = angle_rad;
    f.descriptor = sift::compute_descriptor(
        level, {.x = blob.x, .y = blob.y, .sigma_px = sigma_px, .angle_rad = angle_rad});
    (void)features->push_back(f);
  }
}

/// Takes the strongest of each cell first, then the second strongest, and so on.
void add_in_turn(const sift::BlobGrid& grid,
                 const Context& context,
                 std::size_t count_max,
                 Features* features) {
  for (std::size_t rank = 0; rank < sift::BlobGrid::kPerCell && features->size() < count_max;
       ++rank) {
    FixedVector<const sift::Blob*, sift::BlobGrid::kSide * sift::BlobGrid::kSide> of_rank;
    for (const sift::BlobGrid::Cell& cell : grid.cells) {
      if (rank < cell.size()) {
        (void)of_rank.push_back(&cell[rank]);
      }
    }
    // Deterministic: equal contrasts are ordered by position.
    std::sort(of_rank.begin(), of_rank.end(), [](const sift::Blob* a, const sift::Blob* b) {
      return a->contrast != b->contrast ? a->contrast > b->contrast
                                        : (a->y != b->y ? a->y < b->y : a->x < b->x);
    });
    for (const sift::Blob* blob : of_rank) {
      add_features(*blob, context, count_max, features);
    }
  }
}

}  // namespace

void detect_features(const MaskedImage& image,
                     const CameraModel& camera,
                     const FeatureOptions& options,
                     FeatureWorkspace* workspace,
                     Features* features) {
  const TargetMask& mask = *image.mask;
  features->clear();
  // Least side of a region. Enlarged three times it has 48 px; the smallest descriptor spans 18.
  // Chosen.
  constexpr int kSide_px_min = 16;
  if (mask.region_px.width < kSide_px_min || mask.region_px.height < kSide_px_min) {
    return;
  }
  const sift::Region region{
      .mask = &mask,
      .size = sift::working_size(mask.region_px, options.working_pixels_max, kEnlargeMax)};
  sift::ScaleSpace& space = workspace->space;
  const sift::Plane base = sift::lay_out_scale_space(region.size.width, region.size.height, &space);
  if (space.octaves == 0) {
    return;
  }
  sift::resample(
      *image.gray, mask.region_px, sift::light_of_gray(options.gamma), &workspace->resample, base);
  sift::fill_scale_space(kImageBlur_px, &space);
  sift::find_blobs(space,
                   region,
                   static_cast<float>(options.contrast_min * sift::kFullScale),
                   &workspace->rows,
                   &workspace->blobs);
  const Context context{.space = space, .region = region, .camera = camera, .options = options};
  const std::size_t count_max =
      std::min(static_cast<std::size_t>(options.count_max), features->capacity());
  add_in_turn(workspace->blobs, context, count_max, features);
}

}  // namespace polhode
