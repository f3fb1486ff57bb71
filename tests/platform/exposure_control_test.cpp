#include "app/exposure_control.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "pipeline/state.hpp"

namespace polhode::platform::exposure_control_test {
namespace {

constexpr double kGainFactor = 16.0;

/// A linear camera with V4L2's units before a body of one brightness.
class LinearCamera final : public LiveCamera {
 public:
  explicit LinearCamera(double light_per_s) : light_per_s_(light_per_s) {}

  Arrival next(int /*timeout_ms*/, Frame* /*frame*/) override { return Arrival::kNothing; }
  [[nodiscard]] std::int64_t available_ns() const override { return 0; }
  [[nodiscard]] const CameraCounters& counters() const override { return counters_; }
  [[nodiscard]] std::string_view state() const override { return {}; }
  void set_exposure(std::int64_t exposure_ns, double gain) override {
    setting.exposure_ns = exposure_ns / 100'000 * 100'000;
    setting.gain = gain;
    ++times_set;
  }
  [[nodiscard]] CameraExposure exposure() const override { return setting; }

  [[nodiscard]] double level() const {
    return 1e-9 * static_cast<double>(setting.exposure_ns) * light_per_s_ *
           (1.0 + (kGainFactor - 1.0) * setting.gain);
  }
  [[nodiscard]] SeenTarget seen(double image_motion_px_s = 0.0) const {
    SeenTarget seen{.levels = {}, .image_motion_px_s = image_motion_px_s};
    seen.levels[static_cast<std::size_t>(255.0 * std::min(1.0, level()))] = 1000;
    return seen;
  }

  CameraExposure setting{.settable = true,
                         .exposure_ns = 10'000'000,
                         .exposure_min_ns = 100'000,
                         .exposure_max_ns = 33'000'000,
                         .has_gain = true,
                         .gain = 0.0};
  int times_set = 0;

 private:
  double light_per_s_;
  CameraCounters counters_;
};

void settle(LinearCamera* camera, double image_motion_px_s = 0.0) {
  for (int i = 0; i < 12; ++i) {
    const CameraExposure next =
        next_setting(camera->seen(image_motion_px_s), camera->setting, kGainFactor);
    camera->set_exposure(next.exposure_ns, next.gain);
  }
}

TEST(ExposureControl, BringsATargetToItsLevel_FromTooDarkAndFromTooBright) {
  for (const double level_at_start : {0.05, 0.3, 2.0, 10.0}) {
    LinearCamera camera(level_at_start / 0.01);
    settle(&camera);
    EXPECT_NEAR(camera.level(), 0.8, 0.1) << level_at_start;
    EXPECT_LE(camera.setting.exposure_ns, camera.setting.exposure_max_ns);
  }
}

TEST(ExposureControl, ExposesShorterWithMoreGain_WhenTheTargetMovesFast) {
  LinearCamera still(40.0);
  LinearCamera fast(40.0);
  settle(&still);
  settle(&fast, 100.0);  // 0.5 px in 5 ms
  EXPECT_NEAR(fast.level(), 0.8, 0.1);
  EXPECT_LE(fast.setting.exposure_ns, 5'000'000);
  EXPECT_GT(fast.setting.gain, still.setting.gain);
}

TEST(ExposureControl, LeavesAGainAloneThatTheDeviceHasNot) {
  LinearCamera camera(200.0);
  camera.setting.has_gain = false;
  settle(&camera);
  EXPECT_EQ(camera.setting.gain, 0.0);
  EXPECT_NEAR(camera.level(), 0.8, 0.1);
}

/// Published and stored state of a frame.
struct Stepped {
  explicit Stepped(FrameUse use) : state(std::make_unique<Component::State>()) { out.use = use; }
  StepOutput out;
  std::unique_ptr<Component::State> state;
};

TEST(ExposureControl, GoesUpAfterDarkFrames_DownAfterSaturatedOnes_AndNowhereAfterDamagedOnes) {
  for (const auto& [use, factor] : {std::pair{FrameUse::kDark, 2.0},
                                    std::pair{FrameUse::kSaturated, 0.5},
                                    std::pair{FrameUse::kUnreadable, 1.0}}) {
    const Stepped stepped(use);
    LinearCamera camera(1.0);
    ExposureControl control({.enabled = true, .gain_factor_max = kGainFactor});
    for (int frame = 0; frame < 4; ++frame) {
      control.after(stepped.out, view_of(*stepped.state), camera);
    }
    EXPECT_NEAR(static_cast<double>(camera.setting.exposure_ns), factor * 1e7, 1e5);
    EXPECT_EQ(control.changes(), factor == 1.0 ? 0U : 1U);
  }
}

/// After four frames in which the component saw this image.
unsigned changes_after(FrameUse use, const cv::Mat& image, bool behind, LinearCamera* camera) {
  Stepped stepped(use);
  Component::State& s = *stepped.state;
  s.picture.gray = image;
  find_target(image, s.configuration.parameters.mask, &s.picture.mask);
  s.picture.mask_state.behind = behind;
  ExposureControl control({.enabled = true, .gain_factor_max = kGainFactor});
  for (int frame = 0; frame < 4; ++frame) {
    control.after(stepped.out, view_of(s), *camera);
  }
  return control.changes();
}

TEST(ExposureControl, GoesDown_WhenTheImageIsBrightAllOver_AndLearnsNothingWhereItIsGrayAllOver) {
  for (const auto& [level, changes] :
       {std::pair{253, 1U}, std::pair{235, 1U}, std::pair{90, 0U}, std::pair{8, 0U}}) {
    LinearCamera camera(1.0);
    const cv::Mat even(48, 64, CV_8UC1, cv::Scalar(level));
    EXPECT_EQ(changes_after(FrameUse::kFlat, even, false, &camera), changes) << level;
    EXPECT_EQ(camera.setting.exposure_ns < 10'000'000, changes == 1U) << level;
  }
}

TEST(ExposureControl, GoesUp_WhenTheBodyPassesForEmptySpace) {
  cv::Mat image(48, 64, CV_8UC1, cv::Scalar(0));
  image(cv::Rect(16, 12, 32, 24)).setTo(6);  // not dark, and under the mask's level
  LinearCamera camera(1.0);
  EXPECT_EQ(changes_after(FrameUse::kUsed, image, false, &camera), 1U);
  EXPECT_NEAR(static_cast<double>(camera.setting.exposure_ns), 2e7, 1e5);
  EXPECT_EQ(changes_after(FrameUse::kUsed, image, true, &camera), 0U)
      << "not found before something bright";
  const cv::Mat pedestal(48, 64, CV_8UC1, cv::Scalar(6));
  LinearCamera other(1.0);
  EXPECT_EQ(changes_after(FrameUse::kFlat, pedestal, false, &other), 1U);
  EXPECT_GT(other.setting.exposure_ns, 10'000'000);
}

TEST(ExposureControl, LeavesAShortExposureWithGainAlone_AfterADamagedFrame) {
  const Stepped stepped(FrameUse::kTorn);
  LinearCamera camera(1.0);
  camera.setting.exposure_ns = 2'000'000;
  camera.setting.gain = 0.5;
  ExposureControl control({.enabled = true, .gain_factor_max = kGainFactor});
  for (int frame = 0; frame < 4; ++frame) {
    control.after(stepped.out, view_of(*stepped.state), camera);
  }
  EXPECT_EQ(camera.times_set, 0);
}

TEST(ExposureControl, WaitsForASettingToTakeEffect_AndMayBeSwitchedOff) {
  const Stepped stepped(FrameUse::kDark);
  LinearCamera camera(1.0);
  ExposureControl control({.enabled = true, .gain_factor_max = kGainFactor});
  ExposureControl off({.enabled = false, .gain_factor_max = kGainFactor});
  for (int frame = 0; frame < 8; ++frame) {
    control.after(stepped.out, view_of(*stepped.state), camera);
    off.after(stepped.out, view_of(*stepped.state), camera);
  }
  EXPECT_EQ(camera.times_set, 2);
  camera.setting.settable = false;
  for (int frame = 0; frame < 8; ++frame) {
    control.after(stepped.out, view_of(*stepped.state), camera);
  }
  EXPECT_EQ(camera.times_set, 2);
}

}  // namespace
}  // namespace polhode::platform::exposure_control_test
