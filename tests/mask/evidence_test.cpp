// What is known of each pixel, and in which pixels.
#include "mask/evidence.hpp"

#include <gtest/gtest.h>

namespace polhode {
namespace {

const cv::Size kSize(160, 120);
const cv::Rect kBody(50, 40, 60, 40);

cv::Mat body() {
  cv::Mat outline(kSize, CV_8UC1, cv::Scalar(0));
  outline(kBody).setTo(255);
  return outline;
}

/// For the target within the body, against it beside.
EvidenceState evidence_of_body(int step) {
  EvidenceState state;
  size_evidence(kSize, 1, &state);
  state.total.setTo(-2.0);
  state.total(kBody).setTo(3.0);
  size_evidence(kSize, step, &state);
  return state;
}

float at(const EvidenceState& state, int row, int column) {
  return state.total.at<float>(row / state.step, column / state.step);
}

TEST(SizeEvidence, KnowsNothing_OfTheFirstPicture_OrOneOfAnotherSize) {
  EvidenceState state;
  size_evidence(kSize, 2, &state);
  EXPECT_EQ(state.total.size(), kSize / 2);
  EXPECT_EQ(cv::countNonZero(state.total), 0);
  state.total.setTo(1.0);
  size_evidence({90, 71}, 2, &state);
  EXPECT_EQ(state.total.size(), cv::Size(45, 36));  // the last row is in a cell of its own
  EXPECT_EQ(cv::countNonZero(state.total), 0);
  state.total.setTo(1.0);
  size_evidence({45, 36}, 1, &state);  // as many, of another picture
  EXPECT_EQ(state.step, 1);
  EXPECT_EQ(cv::countNonZero(state.total), 0);
}

TEST(SizeEvidence, KeepsWhatIsKnown_CoarserAndFinerAgain) {
  EvidenceState state = evidence_of_body(2);
  EXPECT_EQ(state.step, 2);
  for (const int step : {2, 1}) {
    size_evidence(kSize, step, &state);
    EXPECT_EQ(state.total.size(), kSize / step);
    EXPECT_EQ(at(state, 60, 80), 3.0F);
    EXPECT_EQ(at(state, 40, 50), 3.0F);
    EXPECT_EQ(at(state, 39, 49), -2.0F);
  }
}

TEST(RememberOutline, TakesWhatItHoldsAlong_AndForgetsWhatItLeavesOut) {
  for (const int step : {1, 2}) {
    EvidenceState state = evidence_of_body(step);
    const auto set = [&](const cv::Rect& box, double value) {
      state.total(cv::Rect(box.tl() / step, box.size() / step)).setTo(value);
    };
    set({0, 0, 20, 20}, 2.0);     // outside of the outline, for the target
    set({80, 60, 10, 10}, -1.0);  // inside, contradicted by motion alone
    remember_outline(body(), &state);
    EXPECT_EQ(at(state, 10, 10), 0.0F);
    EXPECT_EQ(at(state, 10, 150), -2.0F);
    EXPECT_EQ(at(state, 55, 65), 3.0F);
    EXPECT_FLOAT_EQ(at(state, 65, 85), 0.7F);
  }
}

}  // namespace
}  // namespace polhode
