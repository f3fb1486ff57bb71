// Growing a hypothesis: poses of further frames and points of further tracks.
#pragma once

#include <span>

#include "initialisation/hypothesis.hpp"

namespace polhode {

/// Pose of one more frame from the points known so far; starts from its neighbours' poses and from
/// their constant-rate continuation, keeps the best.
/// @return false, with the frame left unposed, when fewer than `points_min` points are seen or less
/// than half fit.
bool pose_frame(std::span<const StartSighting> sightings,
                std::span<const double> times_s,
                int frame,
                StartHypothesis* hypothesis);

/// Points of the tracks that are not known yet and are seen in two posed frames or more.
void add_points(std::span<const StartSighting> sightings, StartHypothesis* hypothesis);

/// Poses frames outwards from those that are posed, `rounds` to each side, adding points as it
/// goes.
/// @return false when no frame was added.
bool extend(std::span<const StartSighting> sightings,
            std::span<const double> times_s,
            int rounds,
            StartHypothesis* hypothesis);

}  // namespace polhode
