#include "recording/export.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "camera/replay/encode_png.hpp"
#include "errors.hpp"
#include "output_file.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

void prepare(const fs::path& folder) {
  std::error_code problem;
  if (fs::exists(folder) && (!fs::is_directory(folder) || !fs::is_empty(folder))) {
    throw UnusableInput(fmt::format("{}: is there and not empty", folder.string()));
  }
  fs::create_directories(folder / "mav0/cam0/data", problem);
  if (problem) {
    throw UnusableInput(
        fmt::format("{}: cannot be created: {}", folder.string(), problem.message()));
  }
}

/// `key = value` lines of the run's parameters; the rest is kept as it is.
std::map<std::string, std::string> values_of(std::string_view text) {
  std::map<std::string, std::string> values;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const std::size_t equals = line.find(" = ");
    if (equals != std::string_view::npos && line.front() != '#') {
      values.emplace(line.substr(0, equals), line.substr(equals + 3));
    }
  }
  return values;
}

constexpr std::string_view kOwnStructure = "mask.file";

/// Of the comment that begin_text() leaves for a file; empty where the run had none.
std::string digest_of(std::string_view name, std::string_view text) {
  const std::string mark = fmt::format("\n# {} ", name);
  const std::size_t at = text.find(mark);
  if (at == std::string_view::npos) {
    return {};
  }
  const std::string_view rest = text.substr(at + mark.size());
  return std::string(rest.substr(0, rest.find('\n')));
}

std::string sensor_yaml(const std::map<std::string, std::string>& values, double rate_hz) {
  const auto value = [&](const char* key) {
    const auto found = values.find(key);
    return found == values.end() ? std::string("0.0") : found->second;
  };
  return fmt::format(
      "sensor_type: camera\nrate_hz: {:.6g}\nresolution: [{}, {}]\ncamera_model: pinhole\n"
      "intrinsics: [{}, {}, {}, {}]\ndistortion_model: radial-tangential\n"
      "distortion_coefficients: [{}, {}, {}, {}]\nline_time_ns: {}\n",
      rate_hz,
      value("camera.width_px"),
      value("camera.height_px"),
      value("camera.fu_px"),
      value("camera.fv_px"),
      value("camera.cu_px"),
      value("camera.cv_px"),
      value("camera.k1"),
      value("camera.k2"),
      value("camera.p1"),
      value("camera.p2"),
      value("camera.line_time_ns"));
}

class Exporter {
 public:
  explicit Exporter(const fs::path& folder)
      : folder_(folder), table_(folder / "mav0/cam0/data.csv") {
    table_.write("#timestamp [ns],filename\n");
  }

  void take(const Record& record) {
    switch (record.header.kind) {
      case RecordKind::kBegin:
        begin_.assign(record.content.begin(), record.content.end());
        break;
      case RecordKind::kFrame:
        take_frame(record);
        break;
      case RecordKind::kDropped:
        (record.header.reason == DropReason::kNotRecorded ? report_.not_recorded
                                                          : report_.dropped) += record.header.count;
        break;
      case RecordKind::kCommand:
        waiting_commands_.push_back(record.content);
        break;
      case RecordKind::kCheckpoint:
        report_.has_checkpoint = true;
        write_file(folder_ / "checkpoint",
                   {reinterpret_cast<const char*>(record.content.data()), record.content.size()});
        break;
    }
  }

  ExportReport finish(const RecordedRun& run, const RecordingReader& reader) {
    if (report_.frames == 0) {
      throw UnusableInput(fmt::format("{}: the recording holds no frame that can be read",
                                      run.files.front().string()));
    }
    table_.close();
    const double span_s = 1e-9 * static_cast<double>(last_ns_ - first_ns_);
    const double rate_hz = span_s > 0.0 ? static_cast<double>(report_.frames - 1) / span_s : 1.0;
    write_file(folder_ / "mav0/cam0/sensor.yaml", sensor_yaml(values_of(begin_), rate_hz));
    write_file(folder_ / "config.toml", begin_);
    if (!commands_.empty()) {
      write_file(folder_ / "commands.csv", "#timestamp [ns],packet\n" + commands_);
    }
    report_.has_begin = run.begins;
    report_.bytes_lost = reader.bytes_lost();
    report_.files_lost = reader.files_lost();
    report_.own_structure_sha256 = digest_of(kOwnStructure, begin_);
    write_file(folder_ / "recording.json",
               fmt::format("{{\n  \"frames\": {},\n  \"unreadable\": {},\n  \"dropped\": {},\n"
                           "  \"not_recorded\": {},\n  \"out_of_time\": {},\n  \"commands\": {},\n "
                           " \"octets_lost\": {},\n"
                           "  \"files_lost\": {},\n"
                           "  \"own_structure_sha256\": \"{}\",\n"
                           "  \"starts_from_checkpoint\": {},\n  \"has_begin\": {},\n"
                           "  \"same_bytes\": {}\n}}\n",
                           report_.frames,
                           report_.unreadable,
                           report_.dropped,
                           report_.not_recorded,
                           report_.out_of_time,
                           report_.commands,
                           report_.bytes_lost,
                           report_.files_lost,
                           report_.own_structure_sha256,
                           report_.has_checkpoint,
                           report_.has_begin,
                           replays_to_the_same_bytes(report_)));
    return report_;
  }

 private:
  void take_frame(const Record& record) {
    const RecordHeader& header = record.header;
    if (report_.frames > 0 && header.timestamp_ns <= last_ns_) {
      ++report_.out_of_time;
      return;
    }
    const std::string name = fmt::format("{}.png", header.timestamp_ns);
    table_.write(fmt::format("{},{}\n", header.timestamp_ns, name));
    if (header.readable) {
      write_png(folder_ / "mav0/cam0/data" / name,
                {.data = record.content.data(),
                 .width_px = header.width_px,
                 .height_px = header.height_px,
                 .stride_bytes = header.width_px * (header.deep ? 2 : 1),
                 .format = header.deep ? PixelFormat::kGray16 : PixelFormat::kGray8});
    } else {
      ++report_.unreadable;
    }
    for (const std::vector<std::uint8_t>& packet : waiting_commands_) {
      commands_ += fmt::format("{},{:02x}\n", header.timestamp_ns, fmt::join(packet, ""));
      ++report_.commands;
    }
    waiting_commands_.clear();
    first_ns_ = report_.frames == 0 ? header.timestamp_ns : first_ns_;
    last_ns_ = header.timestamp_ns;
    ++report_.frames;
  }

  fs::path folder_;
  OutputFile table_;
  std::string begin_;
  std::string commands_;
  std::vector<std::vector<std::uint8_t>> waiting_commands_;
  std::int64_t first_ns_ = 0;
  std::int64_t last_ns_ = 0;
  ExportReport report_;
};

}  // namespace

std::string begin_text(std::string_view version,
                       const std::string& own_structure_sha256,
                       const std::string& parameters) {
  const auto comment = [](std::string_view name, const std::string& digest) {
    return digest.empty() ? std::string() : fmt::format("# {} {}\n", name, digest);
  };
  return fmt::format(
      "# polhode {}\n{}{}", version, comment(kOwnStructure, own_structure_sha256), parameters);
}

bool replays_to_the_same_bytes(const ExportReport& report) {
  return report.has_begin && report.not_recorded == 0 && report.out_of_time == 0 &&
         report.bytes_lost == 0 && report.files_lost == 0 && report.own_structure_sha256.empty();
}

std::string losses_of(const ExportReport& report) {
  std::vector<std::string> losses;
  const auto add = [&](std::uint64_t count, std::string_view what) {
    if (count > 0) {
      losses.push_back(fmt::format("{} {}", count, what));
    }
  };
  if (!report.has_begin) {
    losses.emplace_back("its beginning has been removed");
  }
  add(report.bytes_lost, "octets damaged");
  add(report.files_lost, "files missing or not to be read");
  add(report.not_recorded, "frames not recorded");
  add(report.out_of_time, "frames out of time");
  return fmt::format("{}", fmt::join(losses, ", "));
}

ExportReport export_run(const RecordedRun& run, const fs::path& folder) {
  prepare(folder);
  Exporter exporter(folder);
  RecordingReader reader(run);
  Record record;
  while (reader.next(&record)) {
    exporter.take(record);
  }
  return exporter.finish(run, reader);
}

}  // namespace polhode::platform
