#include "initialisation/align.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

namespace polhode {
namespace {

using Turn = AlignmentWorkspace::Turn;

// Correlation of two views of one spot, in a frame where it was detected and in one where it was
// not. The latter has no other support.
constexpr double kZnccDetected = 0.75;
constexpr double kZnccMissed = 0.9;
// Three sigma of a detection.
constexpr double kMovedMax_px = 1.5;
// Error that a view adds to the image noise: interpolation, relief within the window.
constexpr double kViewSigma_px = 0.08;
// Frames in a row that may miss a track.
constexpr int kGapMax = 3;
// Frames from the middle view in which a track is searched for without a detection: over more than
// 20 in all, shading that moves over a surface looks like motion (decision 0107).
constexpr std::size_t kFollowMax = 10;
// Two detections so near each other are one spot.
constexpr double kSameSpot_px = 1.5;

/// A track that is being aligned.
struct Alignment {
  const InitialImages& images;
  std::span<const TrackPlaces> places;
  std::size_t track = 0;
  std::size_t middle = 0;  ///< frame of the view that the others are registered to
  /// Shift of the middle view by its row time. Over few frames rows and motion are nearly the same,
  /// so one shift serves all.
  Eigen::Vector2d row_shift = Eigen::Vector2d::Zero();
  Neighbours neighbours = {};
};

double to_normalised(double px, const CameraModel& camera) { return px / camera.focal_px(); }

struct Spot {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  double sigma_px = 0.0;
};

/// Searches another frame for the patch of the middle view, about `guess.place_px`.
std::optional<Spot> find_again(const Crop& crop,
                               const LocalMotion& guess,
                               double zncc_min,
                               const PatchTemplate& patch) {
  const auto found = register_patch(patch, crop, guess.affine, crop.to_crop(guess.place_px));
  if (!found || found->zncc < zncc_min) {
    return std::nullopt;
  }
  const Spot spot{.px = crop.to_image(found->place),
                  .sigma_px = crop.reduction * std::hypot(found->sigma, kViewSigma_px)};
  const bool is_near = (spot.px - guess.place_px).norm() <= kMovedMax_px * crop.reduction;
  return is_near ? std::optional(spot) : std::nullopt;
}

/// The observation, moved to where the middle view is found; unchanged where the alignment is less
/// certain than the detection.
std::optional<InitialObservation> aligned(const Alignment& a,
                                          const InitialObservation& detected,
                                          const PatchTemplate& patch) {
  const auto frame = static_cast<std::size_t>(detected.frame);
  const CameraModel& camera = a.images.camera;
  const Eigen::Vector2d place_px = a.places[a.track].px[frame].cast<double>();
  LocalMotion guess =
      local_motion(a.places, a.neighbours, a.track, a.middle, frame).value_or(LocalMotion{});
  guess.place_px = place_px;
  const auto spot = find_again(*a.images.crop(frame), guess, kZnccDetected, patch);
  if (!spot) {
    return std::nullopt;
  }
  InitialObservation moved = detected;
  const double sigma = to_normalised(spot->sigma_px, camera);
  if (sigma < detected.sigma_normalised) {
    moved.normalised += undistort(camera, spot->px) - undistort(camera, place_px);
    moved.sigma_normalised = sigma;
  }
  return moved;
}

/// Has another track already been aligned to this spot? Tracks there that have not had their turn
/// are marked kSame on the way.
bool is_taken(const Alignment& a, std::size_t frame, const Spot& spot, AlignmentWorkspace* w) {
  for (std::size_t i = 0; i < a.places.size(); ++i) {
    if (i == a.track || w->turns[i] == Turn::kSame || !a.places[i].has(frame) ||
        (a.places[i].px[frame].cast<double>() - spot.px).norm() > kSameSpot_px) {
      continue;
    }
    if (w->turns[i] == Turn::kAligned) {
      return true;
    }
    w->turns[i] = Turn::kSame;
  }
  return false;
}

/// The track's observation in a frame that missed it.
std::optional<InitialObservation> followed(const Alignment& a,
                                           std::size_t frame,
                                           AlignmentWorkspace* w) {
  const CameraModel& camera = a.images.camera;
  const std::size_t away = frame > a.middle ? frame - a.middle : a.middle - frame;
  if (away > kFollowMax) {
    return std::nullopt;
  }
  const auto guess = local_motion(a.places, a.neighbours, a.track, a.middle, frame);
  if (!guess) {
    return std::nullopt;
  }
  const auto spot = find_again(*a.images.crop(frame), *guess, kZnccMissed, w->patch);
  if (!spot || is_taken(a, frame, *spot, w)) {
    return std::nullopt;
  }
  return InitialObservation{.frame = static_cast<int>(frame),
                            .normalised = undistort(camera, spot->px) + a.row_shift,
                            .sigma_normalised = to_normalised(spot->sigma_px, camera)};
}

/// The track's observation in one frame, or nothing.
std::optional<InitialObservation> observe(const Alignment& a,
                                          const InitialTrack& track,
                                          std::size_t frame,
                                          AlignmentWorkspace* w) {
  const InitialObservation* const detected = find_frame(track, static_cast<int>(frame));
  const Crop* const crop = a.images.crop(frame);
  if (crop == nullptr || crop->reduction != a.images.crop(a.middle)->reduction) {
    return detected != nullptr ? std::optional(*detected) : std::nullopt;
  }
  return detected != nullptr ? aligned(a, *detected, w->patch) : followed(a, frame, w);
}

void align_track(const InitialImages& images,
                 std::size_t frames,
                 std::span<InitialTrack> tracks,
                 std::size_t t,
                 AlignmentWorkspace* w) {
  InitialTrack& track = tracks[t];
  InitialObservation middle = track.observations[track.observations.size() / 2];
  Alignment a{.images = images,
              .places = std::span(images.places).first(tracks.size()),
              .track = t,
              .middle = static_cast<std::size_t>(middle.frame)};
  const Crop* const reference = images.crop(a.middle);
  const Eigen::Vector2d place_px = a.places[t].px[a.middle].cast<double>();
  if (reference == nullptr || !make_template(*reference, reference->to_crop(place_px), &w->patch)) {
    return;
  }
  a.row_shift = middle.normalised - undistort(images.camera, place_px);
  a.neighbours = nearest_tracks(a.places, t, a.middle);
  // The middle view defines the spot: it has the error of a view only.
  middle.sigma_normalised = std::min(
      middle.sigma_normalised, to_normalised(reference->reduction * kViewSigma_px, images.camera));
  std::array<std::optional<InitialObservation>, limits::kInitialFrames> found;
  found[a.middle] = middle;
  int missed = 0;
  for (std::size_t f = a.middle; f-- > 0 && missed <= kGapMax;) {
    found[f] = observe(a, track, f, w);
    missed = found[f] ? 0 : missed + 1;
  }
  missed = 0;
  for (std::size_t f = a.middle + 1; f < frames && missed <= kGapMax; ++f) {
    found[f] = observe(a, track, f, w);
    missed = found[f] ? 0 : missed + 1;
  }
  track.observations.clear();
  for (const std::optional<InitialObservation>& o : found) {
    if (o) {
      (void)track.observations.push_back(*o);
    }
  }
}

}  // namespace

void align_tracks(const InitialImages& images,
                  std::size_t frames,
                  std::span<InitialTrack> tracks,
                  AlignmentWorkspace* w) {
  std::fill(w->turns.begin(), w->turns.end(), Turn::kWaits);
  // The longest first: of two tracks of one spot the longer stays. Lengths are those of the
  // detections, as alignment changes them.
  FixedVector<std::size_t, limits::kInitialTracks> lengths;
  for (const InitialTrack& track : tracks) {
    (void)lengths.push_back(track.observations.size());
  }
  for (std::size_t length = frames; length >= 2; --length) {
    for (std::size_t t = 0; t < tracks.size(); ++t) {
      if (lengths[t] == length && w->turns[t] == Turn::kWaits) {
        w->turns[t] = Turn::kAligned;
        align_track(images, frames, tracks, t, w);
      }
    }
  }
  for (std::size_t t = 0; t < tracks.size(); ++t) {
    if (w->turns[t] == Turn::kSame) {
      tracks[t].observations.clear();
    }
  }
}

}  // namespace polhode
