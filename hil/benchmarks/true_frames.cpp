#include "true_frames.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include "camera/replay/file_camera.hpp"
#include "geometry/epipolar.hpp"
#include "image/image.hpp"

namespace polhode::benchmark {
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

TrueFrames read_true_frames(const std::string& folder) {
  const platform::Sequence sequence = platform::open_sequence(folder);
  const auto truth = read_truth(folder + "/truth.csv");
  TrueFrames frames;
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

JudgedMatches match_frames(const TrueFrames& frames,
                           std::size_t a,
                           std::size_t b,
                           const Features& of_a,
                           const Features& of_b) {
  static const auto matches = std::make_unique<FeatureMatches>();
  const Eigen::Matrix3d E = essential_matrix(relative_pose(frames.pose[a], frames.pose[b]));
  match_mutual(of_a.view(), of_b.view(), 0.8, matches.get());
  JudgedMatches judged;
  judged.matches = static_cast<int>(matches->size());
  for (const FeatureMatch& m : *matches) {
    const double off_px = frames.camera.focal_px() *
                          std::abs(sampson_error(E,
                                                 of_a[static_cast<std::size_t>(m.a)].normalised,
                                                 of_b[static_cast<std::size_t>(m.b)].normalised));
    if (off_px < kRight_px) {
      judged.off_px.push_back(off_px);
    }
  }
  return judged;
}

}  // namespace polhode::benchmark
