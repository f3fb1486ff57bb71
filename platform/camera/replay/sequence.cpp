#include "camera/replay/sequence.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <functional>
#include <string_view>
#include <system_error>
#include <utility>

#include "camera/replay/decode.hpp"
#include "camera/replay/depth.hpp"
#include "camera/replay/file_bytes.hpp"
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
  explicit FrameTable(const fs::path& file) : file_(file), text_(read_text(file, kTableBytesMax)) {}

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
          "timestamp [ns]: {} {} (the frame before has {}), allowed are increasing ones; "
          "tools/import_sequence.py SEQ NEW judges all stamps together: it leaves single ones out "
          "and tells a clock that was set or wrapped",
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
  std::vector<std::uint8_t> bytes;
  Refusal first_refusal;
  for (const SequenceFrame& frame : sequence.frames) {
    const fs::path file = sequence.image_folder / frame.file;
    ImageHeader header;
    Refusal refusal = read_file(file, bytes, frame_bytes_max(sequence.camera));
    if (!refusal) {
      refusal = read_header(bytes, header);
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

/// Statistics of the levels of a few images of a sequence.
struct LevelsSeen {
  unsigned largest = 0;     ///< in 16-bit images
  int declared_bits = 0;    ///< as those files declare them; 0: they do not
  bool full_depth = false;  ///< one declares all 16 bits
  std::size_t lit = 0;      ///< images that are not black
  std::size_t with_mosaic = 0;
  MosaicCells cells{};  ///< summed over these
};

void look_at(const DecodedImage& image, LevelsSeen* seen) {
  const bool is_deep = image.header.format == PixelFormat::kGray16;
  if (is_deep && image.header.significant_bits == kFullDepth_bits) {
    seen->full_depth = true;
  } else if (is_deep) {  // one of 8 bits is no sample of the others
    seen->largest = std::max(seen->largest, largest_level(image));
    seen->declared_bits = std::max(seen->declared_bits, image.header.significant_bits);
  }
  const bool lit = std::any_of(
      image.pixels.begin(), image.pixels.end(), [](std::uint8_t byte) { return byte != 0; });
  seen->lit += lit ? 1 : 0;
  if (const auto cells = mosaic_of(image)) {
    ++seen->with_mosaic;
    std::transform(
        cells->begin(), cells->end(), seen->cells.begin(), seen->cells.begin(), std::plus<>());
  }
}

LevelsSeen levels_seen(const Sequence& sequence) {
  constexpr std::size_t kLookedAt = 5;  // evenly over the sequence: the first ones may be dark
  const std::size_t step = std::max<std::size_t>(1, sequence.frames.size() / kLookedAt);
  std::vector<std::uint8_t> bytes;
  DecodedImage image;
  LevelsSeen seen;
  for (std::size_t i = 0; i < sequence.frames.size(); i += step) {
    ImageHeader header;
    if (read_file(sequence.image_folder / sequence.frames[i].file,
                  bytes,
                  frame_bytes_max(sequence.camera)) ||
        read_header(bytes, header) || header.width_px != sequence.camera.width_px ||
        header.height_px != sequence.camera.height_px) {
      continue;
    }
    if (!decode(bytes, image)) {
      look_at(image, &seen);
    }
  }
  return seen;
}

/// Bits of the largest level in 16-bit images: 8, 10, 12, 14 or 16; 16 for other images. Bits that
/// the files declare count only if no level is larger: PNG requires writers to shift levels up.
int depth_of(const LevelsSeen& seen) {
  if (seen.full_depth || seen.largest == 0) {
    return kFullDepth_bits;
  }
  const int declared_bits =
      std::min(seen.declared_bits, kFullDepth_bits);  // of a damaged file, it may be any byte
  const int found = depth_for(seen.largest);
  return declared_bits == 0 || found == kFullDepth_bits ? found : std::max(found, declared_bits);
}

void choose_levels(const PixelChoices& choices, Sequence* sequence) {
  const LevelsSeen seen = levels_seen(*sequence);
  sequence->depth_bits = choices.depth_bits == 0 ? depth_of(seen) : choices.depth_bits;
  const double contrast =
      contrast_of(seen.cells) / static_cast<double>(std::max<std::size_t>(1, seen.with_mosaic));
  const bool found = seen.with_mosaic > 0 && seen.with_mosaic == seen.lit &&
                     contrast >= kMosaicContrastMin;  // the same pattern in all
  sequence->mosaic =
      choices.mosaic == MosaicChoice::kLevel || (choices.mosaic == MosaicChoice::kFind && found);
  if (found) {
    sequence->warnings.push_back(sequence->image_folder.string() + ": " +
                                 mosaic_remark(contrast, choices.mosaic));
  }
}

std::vector<std::int64_t> stamps_of(const std::vector<SequenceFrame>& frames) {
  std::vector<std::int64_t> stamps_ns;
  for (const SequenceFrame& frame : frames) {
    stamps_ns.push_back(frame.timestamp_ns);
  }
  return stamps_ns;
}

std::size_t largest_file(const Sequence& sequence) {
  const std::size_t allowed = frame_bytes_max(sequence.camera);
  std::size_t largest = 0;
  for (const SequenceFrame& frame : sequence.frames) {
    std::error_code absent;
    const std::uintmax_t bytes = fs::file_size(sequence.image_folder / frame.file, absent);
    if (!absent && bytes <= allowed) {
      largest = std::max(largest, static_cast<std::size_t>(bytes));
    }
  }
  return largest;
}

}  // namespace

std::size_t frame_bytes_max(const CameraParameters& camera) {
  constexpr std::size_t kPerPixel = 9;
  constexpr std::size_t kBeside = std::size_t{1} << 20U;
  return kPerPixel * static_cast<std::size_t>(camera.width_px) *
             static_cast<std::size_t>(camera.height_px) +
         kBeside;
}

SequenceTables read_tables(const fs::path& path, LensNeed need) {
  const fs::path camera = path / "mav0" / "cam0";
  std::error_code problem;
  if (!fs::is_directory(path, problem)) {
    const bool absent = !problem || problem == std::errc::no_such_file_or_directory;
    const bool file = fs::is_regular_file(path, problem);
    throw UnusableInput(
        fs::is_symlink(path, problem) && absent
            ? fmt::format("{}: a link to {}, which is not there",
                          path.string(),
                          fs::read_symlink(path, problem).string())
        : file
            ? fmt::format("{}: a file, no such folder; {}", path.string(), kImport)
            : fmt::format("{}: {}", path.string(), absent ? "no such folder" : problem.message()));
  }
  if (is_absent(camera / "data.csv")) {
    throw UnusableInput(fmt::format(
        "{}: not an image sequence: mav0/cam0/data.csv is missing; {}", path.string(), kImport));
  }
  SequenceTables tables{.sensor = read_sensor_yaml(camera / "sensor.yaml", need),
                        .frames = FrameTable(camera / "data.csv").read(),
                        .warnings = {}};
  tables.warnings = tables.sensor.warnings;
  const std::vector<std::string> warnings =
      stamp_warnings(stamps_of(tables.frames), tables.sensor.rate_hz, camera / "data.csv");
  tables.warnings.insert(tables.warnings.end(), warnings.begin(), warnings.end());
  const std::string readout =
      readout_warning(stamps_of(tables.frames),
                      tables.sensor.camera.line_time_ns * (tables.sensor.camera.height_px - 1));
  if (!readout.empty()) {
    tables.warnings.push_back(
        fmt::format("{}: line_time_ns: {}", (camera / "sensor.yaml").string(), readout));
  }
  return tables;
}

Sequence open_sequence(const fs::path& path, const PixelChoices& choices) {
  SequenceTables tables = read_tables(path);
  Sequence sequence{.path = path,
                    .image_folder = path / "mav0" / "cam0" / "data",
                    .camera = tables.sensor.camera,
                    .frames = std::move(tables.frames),
                    .warnings = std::move(tables.warnings)};
  sequence.decoder_bytes = check_first_image(sequence).decoder_bytes;
  choose_levels(choices, &sequence);
  sequence.file_bytes_max = largest_file(sequence);
  return sequence;
}

}  // namespace polhode::platform
