#include "features/resting.hpp"

#include <gtest/gtest.h>

#include <memory>

namespace polhode::resting_test {
namespace {

constexpr float kWord_px = 100.0F;  // u and v of what rests

std::unique_ptr<Features> features_at(std::initializer_list<float> u_px, float scale_px = 1.5F) {
  auto features = std::make_unique<Features>();
  for (const float u : u_px) {
    Feature feature;
    feature.u_px = u;
    feature.v_px = kWord_px;
    feature.scale_px = scale_px;
    (void)features->push_back(feature);
  }
  return features;
}

RestingPlaces one_place() {
  RestingPlaces resting;
  add_place(kWord_px, kWord_px, &resting);
  return resting;
}

TEST(RestingPlaces, AreTheSameWithinAPixel) {
  RestingPlaces resting = one_place();
  add_place(kWord_px + 0.5F, kWord_px, &resting);
  EXPECT_EQ(resting.places.size(), 1U);
  add_place(kWord_px + 1.5F, kWord_px, &resting);
  EXPECT_EQ(resting.places.size(), 2U);
}

TEST(RestingPlaces, ThatFindNoRoomAreNotRemembered) {
  RestingPlaces resting;
  for (std::size_t i = 0; i <= RestingPlaces::kPlaces; ++i) {
    add_place(2.0F * static_cast<float>(i), 0.0F, &resting);
  }
  EXPECT_TRUE(resting.places.full());
  EXPECT_FALSE(is_resting(2.0F * static_cast<float>(RestingPlaces::kPlaces), 0.0F, resting));
}

TEST(LeaveOutResting, RemovesWhatADescriptorTakesInOfThem) {
  RestingPlaces resting = one_place();
  const auto small = features_at({kWord_px, kWord_px + 8.0F, kWord_px + 10.0F});
  leave_out_resting(&resting, small.get());  // 6 sigmas of 1.5 px: 9 px
  ASSERT_EQ(small->size(), 1U);
  EXPECT_EQ((*small)[0].u_px, kWord_px + 10.0F);
  const auto coarse = features_at({kWord_px + 10.0F}, 2.0F);
  leave_out_resting(&resting, coarse.get());
  EXPECT_TRUE(coarse->empty());
}

TEST(LeaveOutResting, LeavesAllWhereNothingRests) {
  RestingPlaces resting;
  const auto features = features_at({1.0F, 2.0F, 3.0F});
  leave_out_resting(&resting, features.get());
  EXPECT_EQ(features->size(), 3U);
}

/// Images until a place is dropped, of which each `every`-th shows it; 0: none does.
int images_until_dropped(int every, int seen_before = 0) {
  RestingPlaces resting = one_place();
  int images = 0;
  for (; images < 1000 && !resting.places.empty(); ++images) {
    const bool seen = images < seen_before || (every != 0 && images % every == 0);
    const auto features = seen ? features_at({kWord_px}) : features_at({});
    leave_out_resting(&resting, features.get());
  }
  return images - seen_before;
}

TEST(LeaveOutResting, DropsAPlaceAtWhichMostImagesShowNothing) {
  EXPECT_EQ(images_until_dropped(0), 10);
  EXPECT_EQ(images_until_dropped(0, 100), 30) << "hidden for a while after a long time";
  EXPECT_LT(images_until_dropped(3), 60) << "the body's spots pass there";
  EXPECT_EQ(images_until_dropped(1), 1000) << "it stays while it is seen";
}

}  // namespace
}  // namespace polhode::resting_test
