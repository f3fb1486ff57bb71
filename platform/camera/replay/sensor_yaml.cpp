#include "camera/replay/sensor_yaml.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "camera/lens_warnings.hpp"
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
      root_ = YAML::Load(read_text(file, kSettingsBytesMax));
    } catch (const YAML::Exception& problem) {
      fail(fmt::format("not YAML: {}", problem.what()));
    }
    if (!root_.IsMap()) {
      fail("not a table of fields");
    }
    if (root_["<<"]) {
      fail("<<: merge keys are not read; write out the fields that they stand for");
    }
    std::set<std::string> fields;
    for (const auto& field : root_) {
      if (field.first.IsScalar() && !fields.insert(field.first.Scalar()).second) {
        fail(fmt::format("{}: field is there twice", cited(field.first.Scalar())));
      }
    }
  }

  [[noreturn]] void fail(const std::string& what) const { throw UnusableInput(named(what)); }

  /// A word that must be the one that we understand.
  void expect_word(const char* field, const char* word) const {
    const YAML::Node node = required(field);
    if (!node.IsScalar() || node.Scalar() != word) {
      fail(fmt::format("{}: '{}', allowed is '{}'", field, text(node), word));
    }
  }

  [[nodiscard]] bool is_word(const char* field, const char* word) const {
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

  [[nodiscard]] double number(const char* field) const {
    const YAML::Node node = required(field);
    double value = 0.0;
    if (!YAML::convert<double>::decode(node, value)) {
      fail(fmt::format("{}: '{}' is not a number", field, text(node)));
    }
    return value;
  }

  /// A number above zero; none where the field is missing.
  /// @param problem  description of another content, in one line; empty where there is none
  [[nodiscard]] std::optional<double> positive(const char* field, std::string* problem) const {
    const YAML::Node node = root_[field];
    double value = 0.0;
    if (!node) {
      return std::nullopt;
    }
    if (!YAML::convert<double>::decode(node, value) || !(value > 0.0) || !std::isfinite(value)) {
      *problem = fmt::format("{}: '{}' is not a number above 0", field, text(node));
      return std::nullopt;
    }
    return value;
  }

  /// Is there such a field, with another value than 0, null or false?
  [[nodiscard]] bool is_set(const std::string& field) const {
    const YAML::Node node = root_[field];
    bool yes = true;
    double number = 1.0;
    return node && !node.IsNull() && !(YAML::convert<bool>::decode(node, yes) && !yes) &&
           !(YAML::convert<double>::decode(node, number) && number == 0.0);
  }

  /// Names of the fields as they stand.
  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& field : root_) {
      if (field.first.IsScalar()) {
        names.push_back(field.first.Scalar());
      }
    }
    return names;
  }

  [[nodiscard]] std::map<std::string, std::string> single_values() const {
    std::map<std::string, std::string> values;
    for (const auto& field : root_) {
      if (field.first.IsScalar() && field.second.IsScalar()) {
        values.emplace(field.first.Scalar(), field.second.Scalar());
      }
    }
    return values;
  }

  [[nodiscard]] std::string named(const std::string& what) const {
    return fmt::format("{}: {}", file_.string(), what);
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
  file.check("line_time_ns", "camera.line_time_ns", camera);
}

/// Time from row to row; 0 where the file has none.
double line_time_ns(const SensorFile& file) {
  return file.is_set("line_time_ns") ? file.number("line_time_ns") : 0.0;
}

/// Letters and digits alone, in lower case, for the comparison of names in foreign files.
std::string plain(const std::string& name) {
  std::string letters;
  for (const char c : name) {
    if (std::isalnum(static_cast<unsigned char>(c)) != 0) {
      letters += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    }
  }
  return letters;
}

/// How cameras' drivers and calibrations name the time from row to row, or a shutter that has one.
bool indicates_row_times(const SensorFile& file, const std::string& field) {
  const std::string name = plain(field);
  const auto begins = [&](const char* word) { return name.rfind(word, 0) == 0; };
  const auto contains = [&](const char* word) { return name.find(word) != std::string::npos; };
  if (name == "shutter" || begins("shuttertype") || begins("shuttermode")) {
    const auto values = file.single_values();
    const auto value = values.find(field);
    return value != values.end() && plain(value->second).find("rolling") != std::string::npos;
  }
  return file.is_set(field) &&
         (contains("rollingshutter") || contains("readouttime") || begins("linetime") ||
          begins("linedelay") || begins("lineperiod") || begins("rowtime") || begins("rowdelay"));
}

/// A shutter that reads row after row, whose time from row to row is not known.
std::string rolling_shutter(const SensorFile& file) {
  constexpr const char* kLimit =
      "a rolling shutter: rows are taken as of one time, so that a fast body is sheared and poses "
      "are off by more than their sigma; line_time_ns, from one row to the next, gives them their "
      "times (docs/known_limits.md)";
  if (line_time_ns(file) != 0.0) {
    return "";
  }
  const std::vector<std::string> names = file.names();
  const auto found = std::find_if(names.begin(), names.end(), [&](const std::string& name) {
    return indicates_row_times(file, name);
  });
  return found == names.end() ? "" : fmt::format("{}: {}", cited(*found), kLimit);
}

/// Adds warnings about fields that are usable but likely to be wrong.
void add_warnings(const SensorFile& file, Sensor* sensor) {
  std::string problem;
  sensor->rate_hz = file.positive("rate_hz", &problem);
  std::string shape_problem;
  const double pixel_aspect = file.positive("pixel_aspect", &shape_problem).value_or(1.0);
  std::vector<std::string> warnings = lens_warnings(sensor->camera, pixel_aspect);
  warnings.push_back(problem);
  warnings.push_back(shape_problem);
  warnings.push_back(rolling_shutter(file));
  for (const std::string& warning : warnings) {
    if (!warning.empty()) {
      sensor->warnings.push_back(file.named(warning));
    }
  }
}

/// fu, fv, cu, cv; where the file leaves them to be estimated, a guess that an estimate begins
/// with.
std::vector<double> pinhole_of(const SensorFile& file,
                               const std::vector<double>& size,
                               const std::filesystem::path& path,
                               LensNeed need) {
  if (!file.is_word("intrinsics", "auto")) {
    return file.numbers("intrinsics", 4);
  }
  if (need == LensNeed::kNumbers) {
    file.fail(
        fmt::format("intrinsics: 'auto', allowed are 4 numbers; estimate them on the ground by "
                    "tools/import_sequence.py {} --intrinsics auto",
                    path.parent_path().parent_path().parent_path().string()));
  }
  const double focal_px = std::max(size[0], size[1]);
  return {focal_px, focal_px, 0.5 * (size[0] - 1.0), 0.5 * (size[1] - 1.0)};
}

}  // namespace

Sensor read_sensor_yaml(const std::filesystem::path& path, LensNeed need) {
  const SensorFile file(path);
  file.expect_word("camera_model", "pinhole");
  file.expect_word("distortion_model", "radial-tangential");
  const std::vector<double> size = file.numbers("resolution", 2);
  const std::vector<double> pinhole = pinhole_of(file, size, path, need);
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
                                .p2 = distortion[3],
                                .line_time_ns = line_time_ns(file)};
  check_all(file, camera);
  const std::string disorder = wrong_order(camera);
  if (!disorder.empty()) {
    file.fail(disorder);
  }
  Sensor sensor{.camera = camera,
                .intrinsics_known = !file.is_word("intrinsics", "auto"),
                .rate_hz = std::nullopt,
                .fields = file.single_values(),
                .warnings = {}};
  add_warnings(file, &sensor);
  return sensor;
}

}  // namespace polhode::platform
