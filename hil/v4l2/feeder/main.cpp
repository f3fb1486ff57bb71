// Plays a sequence into the test camera, and faults with it: the side of the sensor.
//   filecam_feed --sequence SEQ [--frames N] [--interval SECONDS] [--script FILE] [--light L]
// Each frame is written when a buffer waits for it. Its time stamp marks the end of the frame: the
// sequence's (mid-exposure) plus half of the exposure that the camera is set to.
// With --light the pixels follow exposure and gain, too (sensor.hpp), frames are taken one by one
// as the reader waits for them, and stamped when they are; a line a frame tells what the sensor
// did. A script has one line a fault, "FRAME WHAT [ARGUMENT]", done before that frame:
//   damage | skip N | fatal | disconnect SECONDS | pause SECONDS | kill FILE (with a process
//   number) | light L
// Before a fault the feeder waits until the reader has all earlier frames and waits for more, so
// that what is lost is what the fault loses.
#include <fcntl.h>
#include <fmt/format.h>
#include <linux/videodev2.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>
#include <vector>

#include "camera/replay/file_camera.hpp"
#include "camera/replay/sequence.hpp"
#include "hil/v4l2/feeder/sensor.hpp"
#include "hil/v4l2/filecam/feed_format.h"

namespace {

using polhode::platform::FileCamera;
using polhode::platform::Sequence;

struct Fault {
  std::string what;
  std::string argument;
};
using Script = std::multimap<std::size_t, Fault>;

Script read_script(const std::string& file) {
  Script script;
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line)) {
    std::istringstream words(line);
    std::size_t frame = 0;
    Fault fault;
    if (words >> frame >> fault.what) {
      words >> fault.argument;
      script.emplace(frame, fault);
    }
  }
  return script;
}

void sleep_s(double duration_s) {
  const auto whole = static_cast<time_t>(duration_s);
  const timespec duration{
      .tv_sec = whole,
      .tv_nsec = static_cast<long>(1e9 * (duration_s - static_cast<double>(whole)))};
  ::nanosleep(&duration, nullptr);
}

class TestCamera {
 public:
  TestCamera() : file_(::open("/dev/filecam_in", O_RDWR | O_CLOEXEC)) {
    if (file_ < 0) {
      throw std::runtime_error(fmt::format("/dev/filecam_in: {}", std::strerror(errno)));
    }
  }
  ~TestCamera() { ::close(file_); }
  TestCamera(const TestCamera&) = delete;
  TestCamera& operator=(const TestCamera&) = delete;

  filecam_state state() const {
    filecam_state state{};
    if (::read(file_, &state, sizeof state) != sizeof state) {
      throw std::runtime_error(std::strerror(errno));
    }
    return state;
  }
  void send(const filecam_header& header, std::span<const std::uint8_t> pixels = {}) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(&header);
    message_.assign(begin, begin + sizeof header);
    message_.insert(message_.end(), pixels.begin(), pixels.end());
    if (::write(file_, message_.data(), message_.size()) != static_cast<ssize_t>(message_.size())) {
      throw std::runtime_error(fmt::format("the frame was not taken: {}", std::strerror(errno)));
    }
  }
  void command(filecam_command what) {
    filecam_header header{};
    header.command = static_cast<__u32>(what);
    send(header);
  }

  /// Until a stream runs, or none does; given up after a while.
  void wait_for(bool streaming) const {
    wait([&](const filecam_state& s) { return (s.streaming != 0) == streaming; });
  }
  /// Until the reader has given all buffers back and so waits for a frame.
  void wait_for_idle_reader() const {
    wait([](const filecam_state& s) { return s.streaming != 0 && s.queued >= kBuffers; });
  }

 private:
  static constexpr __u32 kBuffers = 4;  // the live run's default

  template <typename Condition>
  void wait(Condition condition) const {
    constexpr int kTriesMax = 60000;
    for (int i = 0; i < kTriesMax; ++i) {
      if (condition(state())) {
        return;
      }
      sleep_s(0.005);
    }
    throw std::runtime_error("waited in vain for the reader");
  }

  int file_;
  std::vector<std::uint8_t> message_;
};

/// Significant bits of a 16-bit pixel in the camera's format.
unsigned bits_of(__u32 pixel_format) {
  return pixel_format == V4L2_PIX_FMT_Y10 ? 10U : pixel_format == V4L2_PIX_FMT_Y12 ? 12U : 16U;
}

/// Rows without padding, as the camera has them.
std::vector<std::uint8_t> pixels_of(const polhode::ImageView& image, __u32 pixel_format) {
  std::vector<std::uint8_t> pixels;
  if ((image.format == polhode::PixelFormat::kGray16) == (pixel_format == V4L2_PIX_FMT_GREY)) {
    throw std::runtime_error("the sequence has another depth than the camera's format");
  }
  const std::size_t row = static_cast<std::size_t>(image.width_px) *
                          (image.format == polhode::PixelFormat::kGray16 ? 2 : 1);
  for (int v = 0; v < image.height_px; ++v) {
    const std::uint8_t* from = image.data + v * image.stride_bytes;
    pixels.insert(pixels.end(), from, from + row);
  }
  const unsigned shift = 16U - bits_of(pixel_format);
  for (std::size_t i = 0; shift > 0 && i < pixels.size(); i += 2) {
    std::uint16_t value = 0;
    std::memcpy(&value, &pixels[i], sizeof value);
    value = static_cast<std::uint16_t>(value >> shift);
    std::memcpy(&pixels[i], &value, sizeof value);
  }
  return pixels;
}

/// Faults that come before the frame; the others change its header.
void play_fault(const Fault& fault, TestCamera& camera, filecam_header* header, Sensor* sensor) {
  if (fault.what == "light") {
    sensor->light = std::stod(fault.argument);
  } else if (fault.what == "damage") {
    header->flags |= FILECAM_FLAG_DAMAGED;
  } else if (fault.what == "skip") {
    header->sequence_skip = static_cast<__u32>(std::stoul(fault.argument));
  } else if (fault.what == "fatal") {
    camera.command(FILECAM_FATAL_ERROR);
    camera.wait_for(true);
  } else if (fault.what == "disconnect") {
    camera.command(FILECAM_DISCONNECT);
    sleep_s(std::stod(fault.argument));
    camera.command(FILECAM_CONNECT);
    camera.wait_for(true);
  } else if (fault.what == "pause") {
    sleep_s(std::stod(fault.argument));
  } else if (fault.what == "kill") {
    pid_t process = 0;
    std::ifstream(fault.argument) >> process;
    if (process <= 0 || ::kill(process, SIGKILL) != 0) {
      throw std::runtime_error("nobody to kill in " + fault.argument);
    }
    camera.wait_for(false);
    camera.wait_for(true);
  } else {
    throw std::runtime_error("no such fault: " + fault.what);
  }
}

struct Wish {
  std::size_t frames = SIZE_MAX;
  double interval_s = 0.0;
  double light = 0.0;  ///< 0: pixels as they are in the sequence
};

void feed(const Sequence& sequence, const Wish& request, const Script& script) {
  TestCamera camera;
  Sensor sensor;
  sensor.light = request.light;
  const bool exposes = request.light > 0.0;
  FileCamera files(sequence);
  polhode::Frame frame;
  camera.wait_for(true);
  for (std::size_t i = 0; i < request.frames && files.next(frame); ++i) {
    filecam_header header{};
    const auto [first, last] = script.equal_range(i);
    if (first != last || exposes) {
      camera.wait_for_idle_reader();
    }
    for (auto fault = first; fault != last; ++fault) {
      play_fault(fault->second, camera, &header, &sensor);
    }
    const filecam_state state = camera.state();
    auto pixels = pixels_of(frame.image, state.pixel_format);
    header.octets = static_cast<__u32>(pixels.size());
    header.timestamp_ns =
        static_cast<__u64>(frame.timestamp_ns) + std::uint64_t{state.exposure_100us} * 100'000 / 2;
    if (exposes) {
      sensor.expose(state, pixels);
      header.timestamp_ns = 0;  // now
      fmt::print("{} {}\n", i, sensor.account());
    }
    camera.send(header, pixels);
    sleep_s(request.interval_s);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Plays a sequence into the test camera"};
  std::string sequence;
  std::string script;
  Wish request;
  app.add_option("--sequence", sequence)->required();
  app.add_option("--script", script);
  app.add_option("--frames", request.frames);
  app.add_option("--interval", request.interval_s, "seconds to rest after each frame");
  app.add_option("--light",
                 request.light,
                 "of the scene: level of a pixel over the sequence's, at 10 ms and least gain");
  CLI11_PARSE(app, argc, argv);
  try {
    feed(polhode::platform::open_sequence(sequence), request, read_script(script));
  } catch (const std::exception& problem) {
    fmt::print(stderr, "filecam_feed: {}\n", problem.what());
    return 1;
  }
  return 0;
}
