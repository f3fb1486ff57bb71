// Metres per map unit from a known dimension of the shape that was found.
#pragma once

#include <optional>

#include "base/result.hpp"
#include "shape/scale.hpp"
#include "shape/shape.hpp"

namespace polhode {

/// From the diameter of the round body.
/// @param shape  in map units.
/// @errors BadParameter (diameter_m not positive), NoConsensus (no cylinder was found), Degenerate
/// (it is
/// under kLengthSigmasMin of its sigmas).
Result<ScaleEstimate> scale_from_diameter(const Shape& shape, double diameter_m);

/// From an edge of the flat faces: of the box where there is one and both ends were found, else of
/// the planes' rectangles.
/// @param expected_metres_per_mu  from another reading: the edge that fits it best is taken, else
/// the longest one.
/// @errors BadParameter (edge_m not positive), NoConsensus (no plane was found), Degenerate (as
/// above, or the longest edge may be one whose ends were not found).
Result<ScaleEstimate> scale_from_edge(const Shape& shape,
                                      double edge_m,
                                      std::optional<double> expected_metres_per_mu);

}  // namespace polhode
