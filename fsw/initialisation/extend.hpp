// Extends a hypothesis to further frames and tracks.
#pragma once

#include <span>

#include "initialisation/hypothesis.hpp"

namespace polhode {

/// Pose of one more frame from the points known so far. Initial values are the nearest posed frame
/// and the constant-rate continuation of the two nearest. Keeps the better result.
/// @return false, with the frame left unposed, when too few points are observed or neither
/// converges.
bool pose_frame(std::span<const TrackObservation> observations,
                std::span<const double> times_s,
                int frame,
                InitialHypothesis* hypothesis);

/// Points of the tracks that are not known yet and are seen in two posed frames or more.
void add_points(std::span<const TrackObservation> observations, InitialHypothesis* hypothesis);

/// Poses up to `rounds` frames on either side of those that are posed, adding points after each
/// round.
/// @return false when no frame was added.
bool extend(std::span<const TrackObservation> observations,
            std::span<const double> times_s,
            int rounds,
            InitialHypothesis* hypothesis);

}  // namespace polhode
