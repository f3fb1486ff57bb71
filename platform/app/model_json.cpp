#include "app/model_json.hpp"

#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "output_file.hpp"

namespace polhode::platform {
namespace {

using Json = nlohmann::ordered_json;

Json to_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json sigmas(const Eigen::Matrix3d& covariance) {
  return to_json(Eigen::Vector3d(covariance.diagonal().cwiseMax(0.0).cwiseSqrt()));
}

const char* name(Observability o) {
  switch (o) {
    case Observability::kObserved:
      return "observed";
    case Observability::kWeak:
      return "weak";
    case Observability::kUnobserved:
      break;
  }
  return "unobserved";
}

Json to_json(const SineFit& fit) {
  if (!fit.observed) {
    return nullptr;
  }
  return {{"offset_rad_s", fit.offset},
          {"sigma_offset_rad_s", fit.sigma_offset},
          {"amplitude_rad_s", fit.amplitude},
          {"sigma_amplitude_rad_s", fit.sigma_amplitude},
          {"period_s", fit.period_s},
          {"sigma_period_s", fit.sigma_period_s},
          {"phase_rad", fit.phase_rad},
          {"sigma_phase_rad", fit.sigma_phase_rad},
          {"rms_rad_s", fit.rms}};
}

Json drift(const MotionModel& model) {
  if (!model.drift_valid) {
    return nullptr;
  }
  Json axes = Json::array();
  for (int i = 0; i < 3; ++i) {
    axes.push_back({{"axis_T", to_json(Eigen::Vector3d(model.mass_centre_axes_T.col(i)))},
                    {"observability", name(model.mass_centre_axes[static_cast<std::size_t>(i)])}});
  }
  return {{"v_C", to_json(model.drift.v_C)},
          {"sigma_v_C", sigmas(model.drift.covariance_v_C)},
          {"speed", model.drift.speed},
          {"centre_of_mass_T", to_json(model.drift.c_T)},
          {"sigma_centre_of_mass_T", sigmas(model.drift.covariance_c_T)},
          {"centre_of_mass_axes", axes},
          {"chi2_per_dof", model.drift.chi2_per_dof}};
}

Json describe(const MotionModel& model) {
  return {{"poses", model.poses},
          {"span_s", model.span_s},
          {"mean_w_T_rad_s", to_json(model.mean_w_T_rad_s)},
          {"mean_rate_rad_s", model.mean_rate_rad_s},
          {"rotation_period_s",
           model.rotation_period_s > 0.0 ? Json(model.rotation_period_s) : Json(nullptr)},
          {"w_T_sines",
           {{"x", to_json(model.sines[0])},
            {"y", to_json(model.sines[1])},
            {"z", to_json(model.sines[2])}}},
          {"translation", drift(model)}};
}

}  // namespace

void write_model_json(const std::filesystem::path& file,
                      std::span<const PoseSample> samples,
                      double body_radius,
                      bool scale_known) {
  Json out{{"mode", "paper"},
           {"frame", "T: the target's body frame of motion_smoothed.csv and shape.json"},
           {"length_unit", scale_known ? "m" : "map unit"}};
  std::vector<SineSample> workspace(std::min(samples.size(), kSineSamplesMax + 1));
  const auto model = paper_model(
      samples.first(std::min(samples.size(), kSineSamplesMax + 1)), body_radius, workspace);
  if (model) {
    out["model"] = describe(model.value());
  } else {
    out["model"] = nullptr;
    out["reason"] = "too few poses to say how the target moves";
  }
  // Principal axes, inertia ratios and a prediction need rigid-body dynamics; without that fit they
  // are not known.
  out["principal_axes_T"] = nullptr;
  out["inertia_ratios"] = nullptr;
  out["prediction_horizon_s"] = nullptr;
  OutputFile stream(file);
  stream.write(out.dump(2) + "\n");
  stream.close();
}

}  // namespace polhode::platform
