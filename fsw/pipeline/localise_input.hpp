#pragma once

#include "pipeline/state.hpp"

namespace polhode {

/// What the map's functions need of this frame.
inline LocaliseInput localise_input(const Component::State& s) {
  return {.map = &s.map,
          .features = &s.features,
          .camera = &s.camera,
          .options = &s.parameters.localise,
          .ratio_max = s.parameters.tracks.descriptor_ratio_max,
          .seed = s.parameters.seed,
          .stream = s.frame};
}

}  // namespace polhode
