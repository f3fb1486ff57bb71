#include "app/model_json.hpp"

#include <algorithm>
#include <vector>

#include "app/dynamics_json.hpp"
#include "motion/published.hpp"
#include "output_file.hpp"

namespace polhode::platform {
namespace {

Json sine_json(const SineFit& fit) {
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

Json drift(const MotionModel& model, double scale_sigma) {
  if (!model.drift_valid) {
    return nullptr;
  }
  Json axes = Json::array();
  for (int i = 0; i < 3; ++i) {
    axes.push_back({{"axis_T", to_json(Eigen::Vector3d(model.mass_centre_axes_T.col(i)))},
                    {"observability", name(model.mass_centre_axes[static_cast<std::size_t>(i)])}});
  }
  const DriftFit& d = model.drift;
  return {{"v_C", to_json(d.v_C)},
          {"sigma_v_C", sigmas(d.covariance_v_C + by_scale(d.v_C, scale_sigma))},
          {"speed", d.speed},
          {"centre_of_mass_T", to_json(d.c_T)},
          {"sigma_centre_of_mass_T", sigmas(d.covariance_c_T + by_scale(d.c_T, scale_sigma))},
          {"centre_of_mass_axes", axes},
          {"chi2_per_dof", d.chi2_per_dof}};
}

Json describe(const MotionModel& model, double scale_sigma) {
  return {{"poses", model.poses},
          {"span_s", model.span_s},
          {"mean_w_T_rad_s", to_json(model.mean_w_T_rad_s)},
          {"mean_rate_rad_s", model.mean_rate_rad_s},
          {"rotation_period_s",
           model.rotation_period_s > 0.0 ? Json(model.rotation_period_s) : Json(nullptr)},
          {"w_T_sines",
           {{"x", sine_json(model.sines[0])},
            {"y", sine_json(model.sines[1])},
            {"z", sine_json(model.sines[2])}}},
          {"translation", drift(model, scale_sigma)}};
}

Json paper(const ModelInput& input) {
  const auto samples = input.samples.first(std::min(input.samples.size(), kSineSamplesMax + 1));
  std::vector<SineSample> workspace(samples.size());
  const auto model = paper_model(samples, input.body_radius, workspace);
  return model ? describe(model.value(), input.scale_sigma) : Json(nullptr);
}

/// Removes the sigmas of a fit to poses that the dynamics themselves gave: these share the error of
/// the dynamics, so their scatter and number do not measure it.
// The recursion is a few levels deep: this file writes the JSON.
void withhold_sigmas(Json* json) {  // NOLINT(misc-no-recursion)
  for (auto& [key, value] : json->items()) {
    if (key.starts_with("sigma_") || key.starts_with("chi2_") || key.starts_with("rms_")) {
      value = nullptr;
    } else if (value.is_structured()) {
      withhold_sigmas(&value);
    }
  }
}

}  // namespace

void write_model_json(const std::filesystem::path& file, const ModelInput& input) {
  const bool by_pairs = input.options.mode == MotionMode::kPaper;
  Json out{{"mode", by_pairs ? "paper" : "dynamics"},
           {"frame", "T: the target's body frame of motion_smoothed.csv and shape.json"},
           {"length_unit", input.scale_known ? "m" : "map unit"}};
  out["model"] = paper(input);
  if (out["model"].is_null()) {
    out["reason"] = "too few poses to say how the target moves";
  } else if (input.model.accepted() && input.model.of_map) {
    withhold_sigmas(&out["model"]);
    out["model"]["sigmas"] = "none: its poses are the dynamics' own; see beside it";
  }
  out["fit"] = by_pairs ? Json(nullptr) : fit_json(input.model, input.options);
  if (input.model.accepted()) {
    add_dynamics(input.model, input.R_CI, input.scale_sigma, &out);
    add_prediction(input.model,
                   input.R_CI,
                   {.scale_sigma = input.scale_sigma,
                    .camera = input.camera,
                    .body_radius = input.body_radius},
                   &out);
  } else {
    // Without dynamics that hold none of these is known.
    for (const char* key : {"principal_axes_T", "inertia_ratios", "prediction_horizon_s"}) {
      out[key] = nullptr;
    }
    out["prediction"] = Json::array();
  }
  OutputFile stream(file);
  stream.write(out.dump(2) + "\n");
  stream.close();
}

}  // namespace polhode::platform
