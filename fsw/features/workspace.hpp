// Working memory of detection.
#pragma once

#include "features/blobs.hpp"
#include "features/resample.hpp"
#include "features/scale_space.hpp"

namespace polhode {

/// Contents mean nothing between calls.
struct FeatureWorkspace {
  sift::ResampleScratch resample;
  sift::ScaleSpace space;
  sift::LayerRows rows;
  sift::BlobGrid blobs;
};

}  // namespace polhode
