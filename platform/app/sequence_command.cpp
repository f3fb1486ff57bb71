#include "app/sequence_command.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "camera/replay/sequence.hpp"
#include "quote.hpp"

namespace polhode::platform {
namespace {

std::string fields_json(const SequenceTables& tables) {
  std::vector<std::string> fields;
  for (const auto& [name, value] : tables.sensor.fields) {
    fields.push_back(json_text(name) + ": " + json_text(value));
  }
  return fmt::format("{{{}}}", fmt::join(fields, ", "));
}

std::string warnings_json(const std::vector<std::string>& warnings) {
  std::vector<std::string> texts;
  for (const std::string& warning : warnings) {
    texts.push_back(json_text(warning));
  }
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

}  // namespace

void print_sequence(const SequenceArguments& arguments) {
  const SequenceTables tables =
      read_tables(arguments.sequence, arguments.any_lens ? LensNeed::kAny : LensNeed::kNumbers);
  const CameraParameters& camera = tables.sensor.camera;
  const std::array<double, 4> pinhole = {camera.fu_px, camera.fv_px, camera.cu_px, camera.cv_px};
  const std::array<double, 4> distortion = {camera.k1, camera.k2, camera.p1, camera.p2};
  fmt::print("{{\"resolution\": [{}, {}], \"intrinsics_known\": {}, \"intrinsics\": [{}],\n",
             camera.width_px,
             camera.height_px,
             tables.sensor.intrinsics_known,
             fmt::join(pinhole, ", "));
  fmt::print("\"distortion_coefficients\": [{}], \"line_time_ns\": {}, \"rate_hz\": {},\n",
             fmt::join(distortion, ", "),
             camera.line_time_ns,
             tables.sensor.rate_hz ? fmt::format("{}", *tables.sensor.rate_hz) : "null");
  fmt::print("\"fields\": {},\n\"warnings\": {},\n\"frames\": [",
             fields_json(tables),
             warnings_json(tables.warnings));
  std::string_view before = "\n";
  for (const SequenceFrame& frame : tables.frames) {
    fmt::print("{}[{}, {}]", before, frame.timestamp_ns, json_text(frame.file));
    before = ",\n";
  }
  fmt::print("]}}\n");
}

}  // namespace polhode::platform
