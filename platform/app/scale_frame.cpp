#include "app/scale_frame.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <string_view>

#include "errors.hpp"
#include "pipeline/parameter_table.hpp"
#include "print_stderr.hpp"
#include "shape/scale_state.hpp"

namespace polhode::platform {

void check_scale_frame(const Configuration& configuration, const Sequence& sequence) {
  constexpr std::string_view kKey = "scale.frame_timestamp_ns";
  const ScaleOptions& scale = configuration.parameters.scale;
  const auto& frames = sequence.frames;
  const auto found =
      std::ranges::lower_bound(frames, scale.frame_timestamp_ns, {}, &SequenceFrame::timestamp_ns);
  const bool there = found != frames.end() && found->timestamp_ns == scale.frame_timestamp_ns;
  if (!names_frame(scale) || there) {
    return;
  }
  const auto row = find_parameter(kKey) - parameter_table().data();
  const std::string problem = fmt::format(
      "{}: {} = {}: no frame of the sequence has this time; the first has {}, the last {}",
      configuration.origins[static_cast<std::size_t>(row)],
      kKey,
      scale.frame_timestamp_ns,
      frames.front().timestamp_ns,
      frames.back().timestamp_ns);
  const bool dropped = found != frames.begin() && found != frames.end();
  if (!dropped) {
    throw UnusableInput(problem);
  }
  print_stderr("polhode: {}: lengths stay in map units\n", problem);
}

}  // namespace polhode::platform
