// docs/library.md shows this program; the test of the installation builds and runs it.
#include <polhode/pipeline/component.hpp>

#include <cstdio>
#include <vector>

int main() {
  polhode::Parameters parameters;  // the defaults work on any target
  parameters.camera = {.width_px = 640, .height_px = 480, .fu_px = 900, .fv_px = 900, .cu_px = 319.5, .cv_px = 239.5};
  parameters.jobs = {.delay_frames = 0, .delay_of_all_frames = 0};  // no second thread: a step does all its work
  struct alignas(64) Line { std::byte bytes[64]; };
  std::vector<Line> memory(polhode::memory_needed(parameters).total / 64 + 1);  // acquired once
  auto made = polhode::Component::create(std::as_writable_bytes(std::span(memory)), parameters);
  if (!made) return std::puts(made.error().message.c_str()), 1;
  polhode::Component& component = *made.value();
  const std::vector<std::uint8_t> pixels(640 * 480);  // a camera's frame
  for (std::int64_t frame = 0; frame < 3; ++frame) {
    const polhode::ImageView image{.data = pixels.data(), .width_px = 640, .height_px = 480, .stride_bytes = 640};
    const polhode::StepOutput& out = component.step({.frame = {.timestamp_ns = frame * 100'000'000, .image = image}});
    std::printf("%zu octets for the bus, pose %s\n", out.packets.size(), out.motion.pose_valid ? "known" : "unknown");
  }
}
