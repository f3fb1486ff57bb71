// The frame's answer: motion state, observations, packets, jobs.
#pragma once

#include "pipeline/component.hpp"

namespace polhode {

/// Fills `state->answer`. Every accepted frame gets exactly one motion packet, valid or not.
void publish(FrameUse use, std::int64_t timestamp_ns, Component::State* state);

}  // namespace polhode
