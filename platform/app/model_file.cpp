#include "app/model_file.hpp"

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include <unistd.h>

#include <array>
#include <cstdint>
#include <fstream>
#include <span>
#include <system_error>

#include "errors.hpp"
#include "input_text.hpp"
#include "model_octets.hpp"
#include "os/linux/memory/table_memory.hpp"
#include "output_file.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

bool begins_as_model(const fs::path& file) {
  std::array<std::uint8_t, kModelHeadOctets> begin{};
  std::ifstream(file, std::ios::binary).read(reinterpret_cast<char*>(begin.data()), begin.size());
  return platform::begins_as_model(begin);
}

std::span<std::uint8_t> bytes_of(const TableMemory& memory) {
  return {reinterpret_cast<std::uint8_t*>(memory.span().data()), memory.span().size()};
}

constexpr const char* unit_of(const TargetModelFacts& f) {
  return f.scale_known ? "m" : "map units";
}

std::string inertia_line(const TargetModelFacts& f) {
  // Half of the prior's sigma: then three quarters of the information is from the poses.
  if (!f.body.known || !(f.body.shape_sigma.maxCoeff() <= 0.5 * kShapeSigma)) {
    return "inertia ratios: unknown\n";
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(inertia_of(f.body.shape).J_T);
  const Eigen::Vector3d ratios = principal.eigenvalues() / principal.eigenvalues()[2];
  return fmt::format("inertia ratios: {:.3f}, {:.3f}, 1\n", ratios[0], ratios[1]);
}

std::string mass_centre_line(const TargetModelFacts& f) {
  const double unit = f.scale_known ? f.metres_per_mu : 1.0;
  // Half of the body, which is the prior's sigma.
  if (!f.body.known || !(f.body.mass_centre_sigma.maxCoeff() <= 0.5 * f.radius_mu)) {
    return "mass centre: unknown\n";
  }
  const Eigen::Vector3d c = unit * f.body.mass_centre_T;
  const Eigen::Vector3d sigma = unit * f.body.mass_centre_sigma;
  return fmt::format("mass centre in T: {:.4g}, {:.4g}, {:.4g}, sigmas {:.2g}, {:.2g}, {:.2g} {}\n",
                     c[0],
                     c[1],
                     c[2],
                     sigma[0],
                     sigma[1],
                     sigma[2],
                     unit_of(f));
}

}  // namespace

std::string load_model_file(const fs::path& file, Component* component, TargetModelFacts* facts) {
  std::error_code problem;
  if (!fs::is_regular_file(file, problem)) {
    return problem ? fmt::format("cannot be read: {}", problem.message()) : "no regular file";
  }
  const std::uintmax_t bytes = fs::file_size(file, problem);
  if (problem || !begins_as_model(file)) {
    return "no model of a target";
  }
  if (bytes > model_octets_max()) {
    return "larger than this program's tables";
  }
  const TableMemory memory(bytes);  // beside the pools, which are the libraries'
  const std::span<std::uint8_t> whole = bytes_of(memory).first(bytes);
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(whole.data()), static_cast<std::streamsize>(whole.size()));
  if (!in) {
    return "cannot be read to its end";
  }
  return load_model_octets(whole, component, facts);
}

void check_model_place(const fs::path& file) {
  std::error_code problem;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, problem) || ::access(folder.c_str(), W_OK | X_OK) != 0) {
    throw UnusableInput(
        fmt::format("{}: its folder is not there, or cannot be written to", file.string()));
  }
  if (is_absent(file)) {
    return;
  }
  if (!fs::is_regular_file(fs::symlink_status(file, problem)) || !begins_as_model(file)) {
    throw UnusableInput(fmt::format(
        "{}: is there and no model of a target; allowed is a new name, or a model to be replaced",
        file.string()));
  }
}

void write_model_file(const fs::path& file, const Component& component) {
  const TableMemory memory(model_octets_max());
  const std::span<std::uint8_t> out = bytes_of(memory);
  const std::size_t bytes = save_model_octets(component, out);
  if (bytes == 0) {
    throw RunFailure(fmt::format("{}: not written: there is no map", file.string()));
  }
  write_file(file, {reinterpret_cast<const char*>(out.data()), bytes});
}

std::string describe(const TargetModelFacts& f) {
  const bool metres = f.scale_known;
  const double unit = metres ? f.metres_per_mu : 1.0;
  std::string text = fmt::format("{} landmarks from {} views, within {:.4g} {} of their middle\n",
                                 f.landmarks,
                                 f.keyframes,
                                 unit * f.radius_mu,
                                 unit_of(f));
  text += metres ? fmt::format("scale: {:.6g} m per map unit, relative sigma {:.2g}\n",
                               f.metres_per_mu,
                               f.scale_sigma)
                 : "scale: unknown, lengths are in map units\n";
  return text + inertia_line(f) + mass_centre_line(f);
}

}  // namespace polhode::platform
