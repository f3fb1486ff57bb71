#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/median.hpp"
#include "image/quality.hpp"

namespace polhode {
namespace {

using Entry = QualityHistory::Entry;
using History = FixedVector<Entry, QualityHistory::kFrames>;

// Below this many good frames there is nothing to compare with.
constexpr std::size_t kFramesMin = 2;
// Seen this much oftener than not, a fault is the scene's or the camera's way.
constexpr int kInsistent = 3;
constexpr int kInsistenceMax = 8;

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
  t.spread = 1.4826 * median(values);
  return t;
}

struct Finding {
  bool found = false;
  bool grave = false;  ///< the frame is of no use
  double measure = 0.0;
  double limit = 0.0;
};

/// A body that turns loses light over several frames (in the steepest of ten sequences a third from
/// one to the next, 3 to 10 deg apart); a failed exposure loses it at once. The median level goes
/// down by 4 and the bright one by 2.5.
Finding find_dark(const ImageLevels& now, const History& frames, const ImageOptions& options) {
  if (now.dark) {
    return {.found = true, .grave = true, .measure = now.bright_level, .limit = options.dark_level};
  }
  if (frames.size() < kFramesMin) {
    return {};
  }
  const double mean = typical(frames, &Entry::mean_level).median;
  const double bright = typical(frames, &Entry::bright_level).median;
  const bool sudden = now.mean_level < 0.25 * mean && now.bright_level < 0.4 * bright;
  return {.found = sudden, .grave = sudden, .measure = now.bright_level, .limit = 0.4 * bright};
}

/// Nothing stands out: less contrast than a picture needs not to be dark.
Finding find_flat(const ImageLevels& now, const ImageOptions& options) {
  const double contrast = now.bright_level - now.dim_level;
  const bool flat = contrast < options.dark_level;
  return {.found = flat, .grave = flat, .measure = contrast, .limit = options.dark_level};
}

/// Glints take up to a quarter of what is lit. Three times the right exposure takes a third to nine
/// tenths of what was lit before; it lights the sensor's noise, too, so that before is what counts.
Finding find_saturated(const ImageLevels& now, const History& frames) {
  constexpr double kGlint = 0.25;
  constexpr double kAlone = 0.9;
  const bool alone = frames.size() < kFramesMin;
  const double lit = alone ? now.lit_fraction : typical(frames, &Entry::lit_fraction).median;
  const double before = alone ? 0.0 : typical(frames, &Entry::saturated_fraction).median;
  const double limit = alone ? kAlone * lit : before + 1.2 * kGlint * lit;
  const bool found = now.saturated_fraction > limit;
  return {.found = found, .grave = found, .measure = now.saturated_fraction, .limit = limit};
}

/// All rows that tell anything are the previous frame's.
Finding find_frozen(const RepeatedRows& rows) {
  const bool frozen = rows.repeated > 0 && rows.fresh == 0;
  return {.found = frozen,
          .grave = frozen,
          .measure = static_cast<double>(rows.repeated),
          .limit = 0.0};
}

/// Both kinds of rows in a few runs. In a noise-free or compressed sequence of a static scene this
/// comes with each frame.
Finding find_torn(const RepeatedRows& rows) {
  constexpr int kRowsMin = 4;
  constexpr int kChangesMax = 4;
  const bool torn = std::min(rows.repeated, rows.fresh) >= kRowsMin && rows.changes <= kChangesMax;
  return {.found = torn,
          .grave = torn,
          .measure = static_cast<double>(rows.repeated),
          .limit = kRowsMin};
}

/// More traces than the scene has of its own, by 6 sigma of its last frames; one pixel in 100,000,
/// two tiles, half a line on top, as much as glints come and go by. Single pixels fewer than one in
/// 3000 do no harm: they fall on few landmarks and on no two frames alike.
Finding find_bit_errors(const BitErrorTraces& now, const History& frames) {
  if (frames.size() < kFramesMin) {
    return {};
  }
  constexpr double kSigmas = 6.0;
  constexpr double kHarmless =
      3e-4;  // highest bits: with the others, of which most do not stand out, eight times as many
  constexpr double kUnseen =
      1e-5;  // of the pixels: a thirtieth of what is harmless; so few more are no fault
  // `grain`: what is counted one by one scatters by the root of its number at least.
  const auto traces =
      [&](double value, double Entry::*field, double grain, double floor, double harmless) {
        const Typical t = typical(frames, field);
        const double spread = std::max(t.spread, std::sqrt(grain * std::max(t.median, grain)));
        const double limit = t.median + std::max(kSigmas * spread, 0.25 * t.median) + floor;
        return Finding{.found = value > limit,
                       .grave = value > limit + harmless,
                       .measure = value,
                       .limit = limit};
      };
  const Finding tiles = traces(now.rough_tiles, &Entry::rough_tiles, 0.0, 2.0, 0.0);
  const Finding lines = traces(now.lines, &Entry::lines, 0.0, 0.5, 0.0);
  if (tiles.found || lines.found) {
    return lines.found ? lines : tiles;
  }
  return traces(
      now.impulse_fraction, &Entry::impulse_fraction, 1.0 / now.pixels, kUnseen, kHarmless);
}

/// Three fifths of the sharpness of the frames before: the finest blobs are gone, the others
/// displaced along the motion. Sharp pictures have 0.5 to 1; 0.25 is left where no fine texture is.
Finding find_blurred(const ImageLevels& now, const History& frames) {
  if (frames.size() < kFramesMin) {
    return {};
  }
  const double limit = 0.6 * typical(frames, &Entry::sharpness).median;
  return {.found = now.sharpness < limit, .grave = false, .measure = now.sharpness, .limit = limit};
}

/// Rows that repeat with each frame are the scene's, and the frame is whole; other faults that
/// insist leave a picture that shows something, to be used with care.
FrameDecision decide(FrameFault fault, const Finding& finding, bool insists, bool nothing_to_see) {
  const bool usual = insists && !nothing_to_see && fault != FrameFault::kFrozen;
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

FrameVerdict judge_quality(const ImageQuality& quality,
                           const ImageOptions& options,
                           QualityHistory* history) {
  // In the order of precedence among what is equally bad: a frozen dark frame is frozen, a torn
  // bright one is torn, and one that is at full scale all over is flat because it is saturated.
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
    int& insistence = history->insistence[static_cast<std::size_t>(fault)];
    const bool insists = insistence >= kInsistent;
    insistence = std::clamp(insistence + (finding.found ? 1 : -1), 0, kInsistenceMax);
    if (!finding.found) {
      continue;
    }
    verdict.faults =
        static_cast<std::uint16_t>(verdict.faults | 1U << static_cast<unsigned>(fault));
    const FrameDecision decision = decide(fault, finding, insists, nothing_to_see);
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
  history->frames.clear();
  history->insistence.fill(0);
}

FrameVerdict assess(const cv::Mat& gray, const ImageOptions& options, QualityHistory* history) {
  const ImageQuality quality{.levels = measure_levels(gray, options),
                             .bit_errors = find_bit_errors(gray, history),
                             .rows = compare_rows(gray, options, *history)};
  gray.copyTo(history->previous);
  const FrameVerdict verdict = judge_quality(quality, options, history);
  if (verdict.decision != FrameDecision::kSkip) {
    remember_rows(gray, history);
    cv::dilate(history->roughness,
               history->roughness_good,
               cv::Mat(),
               cv::Point(-1, -1),
               2);  // as far as a tile's content moves from one frame to the next
  }
  return verdict;
}

}  // namespace polhode
