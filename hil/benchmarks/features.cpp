// Features against OpenCV's on sequences with truth: how many pairs of spots are found again, how
// many of the matches lie on the true epipolar line, how near to it, and what a frame costs. Usage:
// bench_features SEQUENCE...   (folders with mav0 and truth.csv)
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "camera/replay/file_camera.hpp"
#include "features/match.hpp"
#include "features/workspace.hpp"
#include "geometry/epipolar.hpp"
#include "image/image.hpp"
#include "opencv_sift.hpp"

namespace {

using namespace polhode;

constexpr std::array<std::size_t, 3> kGaps{1, 2, 3};  // frames between the two of a pair
constexpr double kRight_px = 1.5;

/// Processor time, seconds.
double now_s() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::map<std::int64_t, Pose> read_truth(const std::string& file) {
  std::map<std::int64_t, Pose> truth;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream values(line);
    std::int64_t timestamp_ns = 0;
    Pose pose;
    double w = 1.0;
    double x = 0.0;
    double y = 0.0;
    double z = 0.0;
    values >> timestamp_ns >> pose.p_CT.x() >> pose.p_CT.y() >> pose.p_CT.z() >> w >> x >> y >> z;
    pose.R_CT = Eigen::Quaterniond(w, x, y, z).normalized().toRotationMatrix();
    truth[timestamp_ns] = pose;
  }
  return truth;
}

struct Frames {
  CameraModel camera;
  std::vector<cv::Mat> gray;
  std::vector<Pose> pose;
};

Frames read_frames(const std::string& folder) {
  const platform::Sequence sequence = platform::open_sequence(folder);
  const auto truth = read_truth(folder + "/truth.csv");
  Frames frames;
  frames.camera = to_model(sequence.camera);
  platform::FileCamera camera(sequence);
  Frame frame;
  while (camera.next(frame)) {
    const auto pose = truth.find(frame.timestamp_ns);
    if (frame.readable && pose != truth.end()) {
      cv::Mat gray;
      import_frame(frame.image, &gray);
      frames.gray.push_back(gray);
      frames.pose.push_back(pose->second);
    }
  }
  return frames;
}

struct Tally {
  int matches = 0;
  int pairs = 0;
  std::vector<double> off_px;  ///< of matches within kRight_px
};

struct Outcome {
  double detect_s = 0.0;
  double features = 0.0;
  std::array<Tally, kGaps.size()> of_gap;
};

using Detect = void (*)(
    const cv::Mat&, const TargetMask&, const CameraModel&, const FeatureOptions&, Features*);

void detect_own(const cv::Mat& gray,
                const TargetMask& mask,
                const CameraModel& camera,
                const FeatureOptions& options,
                Features* features) {
  static const auto workspace = std::make_unique<FeatureWorkspace>();
  detect_features(gray, mask, camera, options, workspace.get(), features);
}

Outcome run(const Frames& frames, Detect detect) {
  Outcome outcome;
  std::vector<std::unique_ptr<Features>> found;
  for (const cv::Mat& gray : frames.gray) {
    TargetMask mask;
    find_target(gray, {}, &mask);
    found.push_back(std::make_unique<Features>());
    const double begin_s = now_s();
    detect(gray, mask, frames.camera, {}, found.back().get());
    outcome.detect_s += now_s() - begin_s;
    outcome.features += static_cast<double>(found.back()->size());
  }
  const auto matches = std::make_unique<FeatureMatches>();
  for (std::size_t g = 0; g < kGaps.size(); ++g) {
    for (std::size_t a = 0; a + kGaps[g] < found.size(); a += 2) {
      const std::size_t b = a + kGaps[g];
      const Eigen::Matrix3d E = essential_matrix(relative_pose(frames.pose[a], frames.pose[b]));
      match_mutual(found[a]->view(), found[b]->view(), 0.8, matches.get());
      Tally& tally = outcome.of_gap[g];
      ++tally.pairs;
      tally.matches += static_cast<int>(matches->size());
      for (const FeatureMatch& m : *matches) {
        const double off_px =
            frames.camera.focal_px() *
            std::abs(sampson_error(E,
                                   (*found[a])[static_cast<std::size_t>(m.a)].normalised,
                                   (*found[b])[static_cast<std::size_t>(m.b)].normalised));
        if (off_px < kRight_px) {
          tally.off_px.push_back(off_px);
        }
      }
    }
  }
  return outcome;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) {
    return NAN;
  }
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

void print(const char* name, const Frames& frames, const Outcome& outcome) {
  const auto count = static_cast<double>(frames.gray.size());
  std::printf("  %-7s %6.1f ms %5.0f features;",
              name,
              1e3 * outcome.detect_s / count,
              outcome.features / count);
  for (std::size_t g = 0; g < kGaps.size(); ++g) {
    const Tally& t = outcome.of_gap[g];
    std::printf("  +%zu: %5.1f %3.0f%% %.3f %.3f",
                kGaps[g],
                static_cast<double>(t.off_px.size()) / std::max(1, t.pairs),
                100.0 * static_cast<double>(t.off_px.size()) / std::max(1, t.matches),
                quantile(t.off_px, 0.5),
                quantile(t.off_px, 0.8));
  }
  std::printf("\n");
}

}  // namespace

int main(int count, char** words) {
  std::printf(
      "per gap of frames: right matches a pair, right of all, median and 80 %% distance from the "
      "line, px\n");
  for (int i = 1; i < count; ++i) {
    const Frames frames = read_frames(words[i]);
    std::printf("%s: %zu frames\n", words[i], frames.gray.size());
    print("opencv", frames, run(frames, benchmark::detect_features_opencv));
    print("own", frames, run(frames, detect_own));
  }
  return 0;
}
