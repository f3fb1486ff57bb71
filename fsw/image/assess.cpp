#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/median.hpp"
#include "image/quality.hpp"

namespace polhode {
namespace {

using Entry = QualityHistory::Entry;
using History = FixedVector<Entry, QualityHistory::kFrames>;

// With fewer good frames there is no comparison.
constexpr std::size_t kFramesMin = 2;
// Surplus of frames with a fault over those without, beyond which it is a property of the scene or
// the camera. Chosen; larger skips more frames of such a scene, smaller uses a third bad frame in a
// row.
constexpr int kPersistent = 3;
// Bound on that surplus: after six frames without it a property is a fault again. Chosen: with
// fewer an intermittent property would be a fault each time.
constexpr int kPersistenceMax = 8;

struct Typical {
  double median = 0.0;
  double spread = 0.0;  ///< one sigma by the median of absolute deviations
};

Typical typical(const History& frames, double Entry::*field) {
  std::array<double, QualityHistory::kFrames> held{};
  const std::span values = std::span(held).first(frames.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = frames[i].*field;
  }
  Typical t;
  t.median = median(values);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = std::abs(frames[i].*field - t.median);
  }
  t.spread = 1.4826 * median(values);  // sigma of a normal distribution by its deviations' median
  return t;
}

struct Finding {
  bool found = false;
  bool grave = false;  ///< the frame is useless
  double measure = 0.0;
  double limit = 0.0;
};

/// Drop of light of a failed exposure, which is immediate. A rotating body dims over several
/// frames: by at most a third from one to the next, in ten sequences with frames 3 to 10 deg apart.
Finding find_dark(const ImageLevels& now, const History& frames, const ImageOptions& options) {
  if (now.dark) {
    return {.found = true, .grave = true, .measure = now.bright_level, .limit = options.dark_level};
  }
  if (frames.size() < kFramesMin) {
    return {};
  }
  const double mean = typical(frames, &Entry::mean_level).median;
  const double bright = typical(frames, &Entry::bright_level).median;
  // Mean level down by a factor of 4 and bright level by 2.5. Chosen, beyond a rotating body's
  // third; larger parts take shadows for faults, smaller ones miss partial exposures.
  constexpr double kMeanPart = 0.25;
  constexpr double kBrightPart = 0.4;
  const double limit = kBrightPart * bright;
  const bool sudden = now.mean_level < kMeanPart * mean && now.bright_level < limit;
  return {.found = sudden, .grave = sudden, .measure = now.bright_level, .limit = limit};
}

/// Flat: less contrast than the bright level of an image that is just not dark.
Finding find_flat(const ImageLevels& now, const ImageOptions& options) {
  const double contrast = now.bright_level - now.dim_level;
  const bool flat = contrast < options.dark_level;
  return {.found = flat, .grave = flat, .measure = contrast, .limit = options.dark_level};
}

/// Compares with the lit part before, as over-exposure lights the sensor's noise, too. Three times
/// the right exposure saturates a third to nine tenths of the lit pixels.
Finding find_saturated(const ImageLevels& now, const History& frames) {
  constexpr double kGlint = 0.25;  // glints saturate up to this part of the lit pixels
  constexpr double kMargin = 1.2;  // with it below the least of over-exposure, a third
  // Without a comparison. Chosen: only images with nothing else, as panels saturate.
  constexpr double kAlone = 0.9;
  const bool alone = frames.size() < kFramesMin;
  const double lit = alone ? now.lit_fraction : typical(frames, &Entry::lit_fraction).median;
  const double before = alone ? 0.0 : typical(frames, &Entry::saturated_fraction).median;
  const double limit = alone ? kAlone * lit : before + kMargin * kGlint * lit;
  const bool found = now.saturated_fraction > limit;
  return {.found = found, .grave = found, .measure = now.saturated_fraction, .limit = limit};
}

/// Frozen: all counted rows are the previous frame's.
Finding find_frozen(const RepeatedRows& rows) {
  const bool frozen = rows.repeated > 0 && rows.fresh == 0;
  return {.found = frozen,
          .grave = frozen,
          .measure = static_cast<double>(rows.repeated),
          .limit = 0.0};
}

/// Torn: runs of repeated and of fresh rows. A noise-free sequence of a static scene has both in
/// each frame.
Finding find_torn(const RepeatedRows& rows) {
  // Least rows of each kind. Chosen; fewer do no harm to features.
  constexpr int kRowsMin = 4;
  // Most changes between runs. A block of old rows has two, two blocks have four. Chosen; larger
  // takes noise-free scenes.
  constexpr int kChangesMax = 4;
  const bool torn = std::min(rows.repeated, rows.fresh) >= kRowsMin && rows.changes <= kChangesMax;
  return {.found = torn,
          .grave = torn,
          .measure = static_cast<double>(rows.repeated),
          .limit = kRowsMin};
}

/// Bit errors: more traces than the scene's, by 6 sigma of its last frames and a fixed number for
/// glints. A few single pixels do no harm: they fall on few landmarks, and on other ones in each
/// frame.
Finding find_bit_errors(const BitErrorTraces& now, const History& frames) {
  if (frames.size() < kFramesMin) {
    return {};
  }
  // All 120 good frames of two scenes stay within 6 sigma, most bit errors do not (decision 0003).
  constexpr double kSigmas = 6.0;
  // Least spread, as a part of the median: that of few frames may be too small by chance. Chosen.
  constexpr double kMedianPart = 0.25;
  // Harmless share of flipped highest bits, one pixel in 3000. With flips of other bits, most of
  // which are no outliers, it is eight times as many.
  constexpr double kHarmless = 3e-4;
  // Of the pixels: a thirtieth of the harmless share. Fewer additional ones are no fault.
  constexpr double kUnseen = 1e-5;
  // Tiles and lines by which glints may vary. Chosen; larger misses short broken parts.
  constexpr double kTilesUnseen = 2.0;
  constexpr double kLinesUnseen = 0.5;
  // `grain`: counts of single pixels scatter at least by the root of their number (Poisson).
  const auto traces =
      [&](double value, double Entry::*field, double grain, double floor, double harmless) {
        const Typical t = typical(frames, field);
        const double spread = std::max(t.spread, std::sqrt(grain * std::max(t.median, grain)));
        const double limit = t.median + std::max(kSigmas * spread, kMedianPart * t.median) + floor;
        return Finding{.found = value > limit,
                       .grave = value > limit + harmless,
                       .measure = value,
                       .limit = limit};
      };
  const Finding tiles = traces(now.rough_tiles, &Entry::rough_tiles, 0.0, kTilesUnseen, 0.0);
  const Finding lines = traces(now.lines, &Entry::lines, 0.0, kLinesUnseen, 0.0);
  if (tiles.found || lines.found) {
    return lines.found ? lines : tiles;
  }
  return traces(
      now.impulse_fraction, &Entry::impulse_fraction, 1.0 / now.pixels, kUnseen, kHarmless);
}

/// Blurred: far less sharp than the frames before. The finest blobs are gone, the others displaced
/// along the motion.
Finding find_blurred(const ImageLevels& now, const History& frames) {
  if (frames.size() < kFramesMin) {
    return {};
  }
  // Sharp images have 0.5 to 1; without fine texture 0.25 is left. Chosen between; larger degrades
  // frames of changing texture, smaller misses blur.
  constexpr double kPart = 0.6;
  const double limit = kPart * typical(frames, &Entry::sharpness).median;
  return {.found = now.sharpness < limit, .grave = false, .measure = now.sharpness, .limit = limit};
}

/// Rows that repeat in each frame are of the scene, and the frame is whole. With other persistent
/// faults the image is still usable: a degraded frame, pose only.
FrameDecision decide(FrameFault fault, const Finding& finding, bool persists, bool nothing_to_see) {
  const bool usual = persists && !nothing_to_see && fault != FrameFault::kFrozen;
  if (finding.grave && !usual) {
    return FrameDecision::kSkip;
  }
  return fault == FrameFault::kTorn ? FrameDecision::kUse : FrameDecision::kCare;
}

void remember(const ImageQuality& q, History* frames) {
  if (frames->full()) {
    frames->erase(0);
  }
  (void)frames->push_back({.bright_level = q.levels.bright_level,
                           .mean_level = q.levels.mean_level,
                           .saturated_fraction = q.levels.saturated_fraction,
                           .lit_fraction = q.levels.lit_fraction,
                           .sharpness = q.levels.sharpness,
                           .impulse_fraction = q.bit_errors.impulse_fraction,
                           .rough_tiles = static_cast<double>(q.bit_errors.rough_tiles),
                           .lines = static_cast<double>(q.bit_errors.lines)});
}

}  // namespace

FrameVerdict assess_quality(const ImageQuality& quality,
                            const ImageOptions& options,
                            QualityHistory* history) {
  // In order of precedence (decision 0002): a frozen dark frame is frozen, a torn bright one is
  // torn, and one that is at full scale all over is saturated, not flat.
  const std::array<std::pair<FrameFault, Finding>, kFrameFaults - 1> findings{
      {{FrameFault::kFrozen, find_frozen(quality.rows)},
       {FrameFault::kDark, find_dark(quality.levels, history->frames, options)},
       {FrameFault::kTorn, find_torn(quality.rows)},
       {FrameFault::kSaturated, find_saturated(quality.levels, history->frames)},
       {FrameFault::kFlat, find_flat(quality.levels, options)},
       {FrameFault::kBitErrors, find_bit_errors(quality.bit_errors, history->frames)},
       {FrameFault::kBlurred, find_blurred(quality.levels, history->frames)}}};
  const bool nothing_to_see =
      quality.levels.dark ||
      quality.levels.bright_level - quality.levels.dim_level < options.dark_level;
  FrameVerdict verdict;
  for (const auto& [fault, finding] : findings) {
    int& persistence = history->persistence[static_cast<std::size_t>(fault)];
    const bool persists = persistence >= kPersistent;
    persistence = std::clamp(persistence + (finding.found ? 1 : -1), 0, kPersistenceMax);
    if (!finding.found) {
      continue;
    }
    verdict.faults =
        static_cast<std::uint16_t>(verdict.faults | 1U << static_cast<unsigned>(fault));
    const FrameDecision decision = decide(fault, finding, persists, nothing_to_see);
    if (decision > verdict.decision) {
      verdict.decision = decision;
      verdict.fault = fault;
      verdict.measure = static_cast<float>(finding.measure);
      verdict.limit = static_cast<float>(finding.limit);
    }
  }
  if (verdict.decision != FrameDecision::kSkip) {
    remember(quality, &history->frames);
  }
  return verdict;
}

void clear(QualityHistory* history) {
  history->previous.release();
  history->roughness_good.release();
  history->row_levels_good.release();
  history->lines_known.release();
  history->frames.clear();
  history->persistence.fill(0);
}

FrameVerdict assess(const cv::Mat& gray, const ImageOptions& options, QualityHistory* history) {
  const ImageQuality quality{.levels = measure_levels(gray, options),
                             .bit_errors = find_bit_errors(gray, history),
                             .rows = compare_rows(gray, options, *history)};
  gray.copyTo(history->previous);
  const FrameVerdict verdict = assess_quality(quality, options, history);
  if (verdict.decision != FrameDecision::kSkip) {
    remember_rows(gray, history);
    cv::dilate(history->roughness,
               history->roughness_good,
               cv::Mat(),
               cv::Point(-1, -1),
               2);  // 5 x 5 tiles: the content of a tile moves up to 32 px to the next frame
  }
  return verdict;
}

}  // namespace polhode
