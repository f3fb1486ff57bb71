#include "camera/replay/sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <system_error>
#include <utility>

#include "camera/replay/decode.hpp"
#include "camera/replay/depth.hpp"
#include "camera/replay/file_octets.hpp"
#include "camera/replay/sensor_yaml.hpp"
#include "camera/replay/stamps.hpp"
#include "errors.hpp"
#include "input_text.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kFramesMax =
    10'000'000;  // four days at 30 frames a second: more is a mistake

constexpr std::string_view kImport =  // what a user with a video or photographs needs
    "tools/import_sequence.py SOURCE SEQ makes a sequence of videos, pictures and bags";

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) {
    return {};
  }
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// data.csv line by line; every message names the file and the line.
class FrameTable {
 public:
  explicit FrameTable(const fs::path& file)
      : file_(file), text_(read_text(file, kTableOctetsMax)) {}

  std::vector<SequenceFrame> read() {
    std::vector<SequenceFrame> frames;
    std::string_view line;
    while (frames.size() < kFramesMax && lines_.next(&line)) {
      const std::string_view content = trimmed(line);
      if (!content.empty() && content.front() != '#') {
        frames.push_back(parse(content));
        check_order(frames);
      }
    }
    if (frames.empty()) {
      throw UnusableInput(fmt::format("{}: the sequence has no frames", file_.string()));
    }
    return frames;
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw UnusableInput(fmt::format("{}:{}: {}", file_.string(), lines_.number(), what));
  }

  SequenceFrame parse(std::string_view content) const {
    const std::size_t comma = content.find(',');
    if (comma == std::string_view::npos) {
      fail(fmt::format("'{}' is not 'timestamp [ns],filename'", cited(content)));
    }
    const std::string_view stamp = trimmed(content.substr(0, comma));
    const std::string_view rest = content.substr(comma + 1);
    const std::string_view name =
        trimmed(rest.substr(0, rest.find(',')));  // further columns are others' matter
    SequenceFrame frame;
    const auto [end, error] =
        std::from_chars(stamp.data(), stamp.data() + stamp.size(), frame.timestamp_ns);
    if (error != std::errc{} || end != stamp.data() + stamp.size() || frame.timestamp_ns < 0) {
      fail(fmt::format("timestamp [ns]: '{}', allowed are whole numbers 0 .. 9223372036854775807",
                       cited(stamp)));
    }
    const fs::path relative(name);
    const bool leaves = std::find(relative.begin(), relative.end(), "..") != relative.end();
    if (name.empty() || relative.is_absolute() || leaves) {
      fail(fmt::format("filename: '{}', allowed is a file inside the folder data", cited(name)));
    }
    frame.file = std::string(name);
    return frame;
  }

  void check_order(const std::vector<SequenceFrame>& frames) const {
    if (frames.size() < 2) {
      return;
    }
    const std::int64_t before = frames[frames.size() - 2].timestamp_ns;
    const std::int64_t now = frames.back().timestamp_ns;
    if (now <= before) {
      fail(fmt::format(
          "timestamp [ns]: {} {} (the frame before has {}), allowed are increasing ones",
          now,
          now == before ? "repeats" : "runs back",
          before));
    }
  }

  fs::path file_;
  std::string text_;
  TextLines lines_{text_};
};

/// The first image whose header can be read must have the camera's size. Single bad files are the
/// frame loop's matter.
/// @return that header.
ImageHeader check_first_image(const Sequence& sequence) {
  std::vector<std::uint8_t> octets;
  Refusal first_refusal;
  for (const SequenceFrame& frame : sequence.frames) {
    const fs::path file = sequence.image_folder / frame.file;
    ImageHeader header;
    Refusal refusal = read_file(file, octets, frame_octets_max(sequence.camera));
    if (!refusal) {
      refusal = read_header(octets, header);
    }
    if (refusal) {
      first_refusal = first_refusal ? first_refusal : file.string() + ": " + *refusal;
      continue;
    }
    const CameraParameters& camera = sequence.camera;
    if (header.width_px != camera.width_px || header.height_px != camera.height_px) {
      throw UnusableInput(
          fmt::format("{}: image is {}x{}, but sensor.yaml says resolution: [{}, {}]",
                      file.string(),
                      header.width_px,
                      header.height_px,
                      camera.width_px,
                      camera.height_px));
    }
    return header;
  }
  throw UnusableInput(fmt::format("none of the {} images can be read; the first: {}",
                                  sequence.frames.size(),
                                  first_refusal.value_or("")));
}

/// Bits of the largest level in 16-bit pictures: 10, 12, 14 or 16. By a few pictures of the
/// sequence: where they say their bits, levels are of so many only if none is larger, as PNG asks
/// writers to shift them up. 16 for other pictures.
int depth_of(const Sequence& sequence) {
  constexpr std::size_t kLookedAt = 5;  // evenly over the sequence: the first ones may be dark
  const std::size_t step = std::max<std::size_t>(1, sequence.frames.size() / kLookedAt);
  std::vector<std::uint8_t> octets;
  DecodedImage image;
  unsigned largest = 0;
  int said = 0;
  for (std::size_t i = 0; i < sequence.frames.size(); i += step) {
    ImageHeader header;
    if (read_file(sequence.image_folder / sequence.frames[i].file,
                  octets,
                  frame_octets_max(sequence.camera)) ||
        read_header(octets, header) || header.width_px != sequence.camera.width_px ||
        header.height_px != sequence.camera.height_px) {
      continue;
    }
    if (header.format != PixelFormat::kGray16 || header.significant_bits == kFullDepth_bits) {
      return kFullDepth_bits;
    }
    if (!decode(octets, image)) {
      largest = std::max(largest, largest_level(image));
      said = std::max(said, header.significant_bits);
    }
  }
  if (largest == 0) {
    return kFullDepth_bits;  // black, or none could be read
  }
  said = std::min(said, kFullDepth_bits);  // of a damaged file, it may be any octet
  const int found = depth_for(largest);
  return said == 0 || found == kFullDepth_bits ? found : std::max(found, said);
}

std::vector<std::int64_t> stamps_of(const Sequence& sequence) {
  std::vector<std::int64_t> stamps_ns;
  for (const SequenceFrame& frame : sequence.frames) {
    stamps_ns.push_back(frame.timestamp_ns);
  }
  return stamps_ns;
}

std::size_t largest_file(const Sequence& sequence) {
  const std::size_t allowed = frame_octets_max(sequence.camera);
  std::size_t largest = 0;
  for (const SequenceFrame& frame : sequence.frames) {
    std::error_code absent;
    const std::uintmax_t octets = fs::file_size(sequence.image_folder / frame.file, absent);
    if (!absent && octets <= allowed) {
      largest = std::max(largest, static_cast<std::size_t>(octets));
    }
  }
  return largest;
}

}  // namespace

std::size_t frame_octets_max(const CameraParameters& camera) {
  constexpr std::size_t kPerPixel = 9;
  constexpr std::size_t kBeside = std::size_t{1} << 20U;
  return kPerPixel * static_cast<std::size_t>(camera.width_px) *
             static_cast<std::size_t>(camera.height_px) +
         kBeside;
}

Sequence open_sequence(const fs::path& path, int depth_bits) {
  const fs::path camera = path / "mav0" / "cam0";
  std::error_code problem;
  if (!fs::is_directory(path, problem)) {
    const bool absent = !problem || problem == std::errc::no_such_file_or_directory;
    const bool file = fs::is_regular_file(path, problem);
    throw UnusableInput(
        file ? fmt::format("{}: a file, no such folder; {}", path.string(), kImport)
             : fmt::format("{}: {}", path.string(), absent ? "no such folder" : problem.message()));
  }
  if (is_absent(camera / "data.csv")) {
    throw UnusableInput(fmt::format(
        "{}: not an image sequence: mav0/cam0/data.csv is missing; {}", path.string(), kImport));
  }
  Sensor sensor = read_sensor_yaml(camera / "sensor.yaml");
  Sequence sequence{.path = path,
                    .image_folder = camera / "data",
                    .camera = sensor.camera,
                    .frames = FrameTable(camera / "data.csv").read(),
                    .warnings = std::move(sensor.warnings)};
  sequence.decoder_octets = check_first_image(sequence).decoder_octets;
  sequence.depth_bits = depth_bits == 0 ? depth_of(sequence) : depth_bits;
  sequence.file_octets_max = largest_file(sequence);
  const std::vector<std::string> doubts =
      doubts_about_stamps(stamps_of(sequence), sensor.rate_hz, camera / "data.csv");
  sequence.warnings.insert(sequence.warnings.end(), doubts.begin(), doubts.end());
  return sequence;
}

}  // namespace polhode::platform
