#include "camera/replay/sensor_yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <set>
#include <string>
#include <vector>

#include "errors.hpp"
#include "input_text.hpp"
#include "pipeline/parameter_table.hpp"

namespace polhode::platform {
namespace {

/// One sensor.yaml: every message starts with its path.
class SensorFile {
 public:
  explicit SensorFile(const std::filesystem::path& file) : file_(file) {
    try {
      root_ = YAML::Load(read_text(file, kSettingsOctetsMax));
    } catch (const YAML::Exception& problem) {
      fail(fmt::format("not YAML: {}", problem.what()));
    }
    if (!root_.IsMap()) {
      fail("not a table of fields");
    }
    std::set<std::string> fields;
    for (const auto& field : root_) {
      if (field.first.IsScalar() && !fields.insert(field.first.Scalar()).second) {
        fail(fmt::format("{}: field is there twice", cited(field.first.Scalar())));
      }
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw UnusableInput(fmt::format("{}: {}", file_.string(), what));
  }

  /// A word that must be the one that we understand.
  void expect_word(const char* field, const char* word) const {
    const YAML::Node node = required(field);
    if (!node.IsScalar() || node.Scalar() != word) {
      fail(fmt::format("{}: '{}', allowed is '{}'", field, text(node), word));
    }
  }

  [[nodiscard]] bool holds_word(const char* field, const char* word) const {
    const YAML::Node node = root_[field];
    return node && node.IsScalar() && node.Scalar() == word;
  }

  [[nodiscard]] std::vector<double> numbers(const char* field, std::size_t count) const {
    const YAML::Node node = required(field);
    if (!node.IsSequence() || node.size() != count) {
      fail(fmt::format("{}: '{}', allowed are {} numbers", field, text(node), count));
    }
    std::vector<double> values;
    for (const YAML::Node& item : node) {
      double value = 0.0;
      if (!YAML::convert<double>::decode(item, value)) {
        fail(fmt::format("{}: '{}' is not a number", field, text(item)));
      }
      values.push_back(value);
    }
    return values;
  }

  [[nodiscard]] int whole(const char* field, double value) const {
    if (!(value >= 0.0 && value <= 1e9) || value != static_cast<int>(value)) {
      fail(fmt::format("{}: {} is not a whole number of pixels", field, value));
    }
    return static_cast<int>(value);
  }

  /// The ranges are those of the camera's parameters; the field's name is the file's.
  void check(const char* field, const char* key, const CameraParameters& camera) const {
    Parameters parameters;
    parameters.camera = camera;
    const ParameterRow& row = *find_parameter(key);
    if (check_row(row, parameters)) {
      fail(fmt::format("{}: {} is out of range, allowed {} {}",
                       field,
                       value_text(row, parameters),
                       range_text(row),
                       row.unit));
    }
  }

 private:
  [[nodiscard]] YAML::Node required(const char* field) const {
    YAML::Node node = root_[field];
    if (!node) {
      fail(fmt::format("{}: field is missing", field));
    }
    return node;
  }
  static std::string text(const YAML::Node& node) {
    YAML::Emitter out;
    out << YAML::Flow << node;
    return cited(out.c_str());
  }

  std::filesystem::path file_;
  YAML::Node root_;
};

void check_all(const SensorFile& file, const CameraParameters& camera) {
  file.check("resolution[0]", "camera.width_px", camera);
  file.check("resolution[1]", "camera.height_px", camera);
  file.check("intrinsics[0]", "camera.fu_px", camera);
  file.check("intrinsics[1]", "camera.fv_px", camera);
  file.check("intrinsics[2]", "camera.cu_px", camera);
  file.check("intrinsics[3]", "camera.cv_px", camera);
  file.check("distortion_coefficients[0]", "camera.k1", camera);
  file.check("distortion_coefficients[1]", "camera.k2", camera);
  file.check("distortion_coefficients[2]", "camera.p1", camera);
  file.check("distortion_coefficients[3]", "camera.p2", camera);
}

}  // namespace

CameraParameters read_sensor_yaml(const std::filesystem::path& path) {
  const SensorFile file(path);
  file.expect_word("camera_model", "pinhole");
  file.expect_word("distortion_model", "radial-tangential");
  const std::vector<double> size = file.numbers("resolution", 2);
  if (file.holds_word("intrinsics", "auto")) {
    file.fail(
        fmt::format("intrinsics: 'auto', allowed are 4 numbers; estimate them on the ground by "
                    "tools/import_sequence.py {} --intrinsics auto",
                    path.parent_path().parent_path().parent_path().string()));
  }
  const std::vector<double> pinhole = file.numbers("intrinsics", 4);
  const std::vector<double> distortion = file.numbers("distortion_coefficients", 4);
  const CameraParameters camera{.width_px = file.whole("resolution[0]", size[0]),
                                .height_px = file.whole("resolution[1]", size[1]),
                                .fu_px = pinhole[0],
                                .fv_px = pinhole[1],
                                .cu_px = pinhole[2],
                                .cv_px = pinhole[3],
                                .k1 = distortion[0],
                                .k2 = distortion[1],
                                .p1 = distortion[2],
                                .p2 = distortion[3]};
  check_all(file, camera);
  return camera;
}

}  // namespace polhode::platform
