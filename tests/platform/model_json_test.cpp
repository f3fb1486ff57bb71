#include "app/model_json.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "app/servicer_attitude.hpp"
#include "errors.hpp"
#include "temporary_folder.hpp"

namespace polhode::platform::model_json_test {
namespace {

nlohmann::json written(const RigidModel& model,
                       const MotionOptions& options = {},
                       std::span<const PoseSample> samples = {},
                       double scale_sigma = 0.0,
                       const CameraFinding& camera = {}) {
  const TemporaryFolder folder;
  write_model_json(folder.path() / "model.json",
                   {.samples = samples,
                    .model = model,
                    .options = options,
                    .scale_known = scale_sigma > 0.0,
                    .scale_sigma = scale_sigma,
                    .camera = camera});
  std::ifstream in(folder.path() / "model.json");
  return nlohmann::json::parse(in);
}

/// Sure of all its unknowns; comes nearer by a hundredth of a unit a second.
RigidModel accepted(const Eigen::Vector3d& w_T_rad_s) {
  RigidModel model;
  model.status = ModelStatus::kAccepted;
  model.translation_known = true;
  model.reference.w_T_rad_s = w_T_rad_s;
  model.path << 0.0, 0.0, 10.0, 0.0, 0.0, -0.01, 0.1, 0.2, 0.3;
  model.mass_centre_sigma = 0.5;
  model.covariance.diagonal().setConstant(1e-10);
  return model;
}

// verifies: MAP-11
TEST(ModelJson, PredictionsHoldTheErrorsOfAContradictedCamera) {
  const RigidModel model = accepted({0.0, 0.0, 0.05});
  CameraFinding camera;
  const auto u = static_cast<std::size_t>(Deviation::kPrincipalU);
  camera.contradicted[u] = 1;
  camera.value[static_cast<Eigen::Index>(u)] = 0.03;
  const nlohmann::json sure = written(model)["prediction"][0];
  const nlohmann::json widened = written(model, {}, {}, 0.0, camera)["prediction"][0];
  EXPECT_LT(sure["sigma_att_rad"].get<double>(), 1e-3);
  EXPECT_NEAR(widened["sigma_att_rad"].get<double>(), 0.03, 1e-4);
  const auto p_CT = widened["p_CT"].get<std::vector<double>>();
  const double range = std::hypot(p_CT[0], p_CT[1], p_CT[2]);
  EXPECT_NEAR(widened["sigma_pos"].get<double>(), 0.03 * range, 1e-4);
}

TEST(ModelJson, OfARefusedModelHasNoNumbersOfDynamicsAndReportsWhy) {
  RigidModel model;
  model.status = ModelStatus::kResidualsTooLarge;
  const nlohmann::json json = written(model);
  EXPECT_EQ(json["mode"], "dynamics");
  EXPECT_NE(json["fit"]["status"].get<std::string>().find("refused"), std::string::npos);
  EXPECT_TRUE(json["principal_axes_T"].is_null());
  EXPECT_TRUE(json["inertia_ratios"].is_null());
  EXPECT_TRUE(json["prediction_horizon_s"].is_null());
  EXPECT_TRUE(json["prediction"].empty());
  EXPECT_FALSE(json.contains("w_T_rad_s"));
}

// verifies: MOT-07
TEST(ModelJson, ShowsNoNumberOfWhatIsUnobserved) {
  RigidModel model = accepted({0.0, 0.0, 0.05});
  model.covariance.diagonal().segment<5>(6).setConstant(2.25);
  model.covariance(19, 19) = 0.25;  // the mass centre along the axis: as before
  const nlohmann::json json = written(model);
  EXPECT_TRUE(json["inertia_ratios"]["largest_over_least"]["value"].is_null());
  EXPECT_EQ(json["inertia_ratios"]["largest_over_least"]["observability"], "unobserved");
  EXPECT_TRUE(json["periods_s"]["spin"]["value"].is_null());
  EXPECT_NEAR(json["periods_s"]["rotation"]["value"].get<double>(), 125.66, 0.01);
  for (const auto& axis : json["principal_axes_T"]) EXPECT_TRUE(axis["axis_T"].is_null());
  const auto& centre = json["translation"]["centre_of_mass"];
  EXPECT_EQ(centre[0]["observability"], "observed");
  EXPECT_TRUE(centre[2]["value"].is_null());
  EXPECT_EQ(json["prediction"].size(), 10U);
  EXPECT_EQ(json["prediction"][1]["ahead_s"], 10.0);
  EXPECT_NEAR(json["prediction"][1]["v_C"][2].get<double>(), -0.01, 1e-9);
}

// verifies: BUS-08
TEST(ModelJson, LengthsInMetresCarryTheErrorOfTheScale) {
  const RigidModel model = accepted({0.01, 0.02, 0.05});
  constexpr double kScaleSigma = 0.05;
  const nlohmann::json json = written(model, {}, {}, kScaleSigma);
  const nlohmann::json exact = written(model);
  const auto norm = [](const nlohmann::json& v) {
    return std::hypot(v[0].get<double>(), v[1].get<double>(), v[2].get<double>());
  };
  for (std::size_t i = 0; i < json["prediction"].size(); ++i) {
    const auto& row = json["prediction"][i];
    const auto& before = exact["prediction"][i];
    for (const auto& [value, sigma] :
         {std::pair{"p_CT", "sigma_pos"}, std::pair{"v_C", "sigma_vel"}}) {
      const double by_scale = kScaleSigma * norm(row[value]);
      EXPECT_GE(row[sigma].get<double>(), by_scale * (1.0 - 1e-9)) << sigma;
      EXPECT_LE(row[sigma].get<double>(),
                std::hypot(by_scale, before[sigma].get<double>()) * (1.0 + 1e-9))
          << sigma;
    }
    EXPECT_EQ(row["sigma_att_rad"], before["sigma_att_rad"]);
  }
  EXPECT_GE(json["translation"]["sigma_v_C"][2].get<double>(), kScaleSigma * 0.01 * (1.0 - 1e-9));
  for (const auto& axis : json["translation"]["centre_of_mass"]) {
    EXPECT_GE(axis["sigma"].get<double>(), kScaleSigma * std::abs(axis["value"].get<double>()));
  }
}

/// Turning about the optical axis while moving along it, a second from pose to pose.
std::vector<PoseSample> spinning_poses() {
  std::vector<PoseSample> poses;
  for (int i = 0; i < 40; ++i) {
    PoseSample sample;
    sample.timestamp_ns = std::int64_t{1'000'000'000} * i;
    sample.pose.R_CT = Eigen::AngleAxisd(0.1 * i, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    sample.pose.p_CT = {0.0, 0.0, 10.0 - 0.01 * i};
    sample.covariance = 1e-6 * PoseCovariance::Identity();
    poses.push_back(sample);
  }
  return poses;
}

TEST(ModelJson, ThePapersModelHasSigmas_UnlessItsPosesAreTheDynamicsOwn) {
  const std::vector<PoseSample> poses = spinning_poses();
  RigidModel model;
  model.status = ModelStatus::kAccepted;
  model.of_map = false;
  const nlohmann::json measured = written(model, {}, poses)["model"];
  EXPECT_GT(measured["translation"]["sigma_v_C"][2].get<double>(), 0.0);
  EXPECT_FALSE(measured.contains("sigmas"));
  model.of_map = true;
  const nlohmann::json own = written(model, {}, poses)["model"];
  EXPECT_EQ(own["translation"]["v_C"], measured["translation"]["v_C"]);
  EXPECT_TRUE(own["translation"]["sigma_v_C"].is_null());
  EXPECT_TRUE(own["translation"]["chi2_per_dof"].is_null());
  EXPECT_TRUE(own.contains("sigmas"));
}

TEST(ModelJson, InPaperModeHasNoFit) {
  MotionOptions options;
  options.mode = MotionMode::kPaper;
  const nlohmann::json json = written({}, options);
  EXPECT_EQ(json["mode"], "paper");
  EXPECT_TRUE(json["fit"].is_null());
}

TEST(ServicerAttitude, WithoutAFileIsHeld) {
  const TemporaryFolder folder;
  const auto attitude = ServicerAttitude::of_sequence(folder.path());
  EXPECT_FALSE(attitude.attitude_at(5).has_value());
}

TEST(ServicerAttitude, IsInterpolatedAndHeldAtItsEnds) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "servicer_attitude.csv")
      << "#timestamp_ns,q_IC_w,q_IC_x,q_IC_y,q_IC_z\n100,1,0,0,0\n200,0.5,0,0,0.8660254037844386\n";
  const auto attitude = ServicerAttitude::of_sequence(folder.path());
  EXPECT_NEAR(attitude.q_IC(150).z(), 0.5, 1e-12);  // half of 120 deg about z
  EXPECT_EQ(attitude.attitude_at(50), (std::array<double, 4>{1.0, 0.0, 0.0, 0.0}));
  EXPECT_NEAR(attitude.q_IC(300).w(), 0.5, 1e-12);
}

TEST(ServicerAttitude, ThatCannotBeReadIsRefusedWithItsLine) {
  for (const char* rows :
       {"100,1,0,0\n", "100,2,0,0,0\n", "100,1,0,0,0\n100,1,0,0,0\n", "x,1,0,0,0\n", "#\n"}) {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "servicer_attitude.csv") << rows;
    EXPECT_THROW((void)ServicerAttitude::of_sequence(folder.path()), UnusableInput) << rows;
  }
}

}  // namespace
}  // namespace polhode::platform::model_json_test
