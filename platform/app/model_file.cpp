#include "app/model_file.hpp"

#include <fmt/format.h>
#include <Eigen/Eigenvalues>

#include <unistd.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <span>
#include <string_view>
#include <system_error>

#include "base/crc.hpp"
#include "errors.hpp"
#include "input_text.hpp"
#include "os/linux/memory/table_memory.hpp"
#include "output_file.hpp"

namespace polhode::platform {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "PLHMODEL";
constexpr std::size_t kNumberBytes = 8;
constexpr std::size_t kHeaderBytes = kMagic.size() + 2 * kNumberBytes;  // bytes, CRC-32

void put_number(std::uint64_t number, std::uint8_t* out) {
  for (std::size_t i = 0; i < kNumberBytes; ++i) {
    out[i] = static_cast<std::uint8_t>(number >> 8 * i);
  }
}

std::uint64_t number_at(const std::uint8_t* bytes) {
  std::uint64_t number = 0;
  for (std::size_t i = 0; i < kNumberBytes; ++i) {
    number |= std::uint64_t{bytes[i]} << 8 * i;
  }
  return number;
}

bool begins_as_model(const fs::path& file) {
  std::array<char, kMagic.size()> begin{};
  std::ifstream(file, std::ios::binary).read(begin.data(), begin.size());
  return std::string_view(begin.data(), begin.size()) == kMagic;
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
  if (problem || bytes < kHeaderBytes || !begins_as_model(file)) {
    return "no model of a target";
  }
  if (bytes > kHeaderBytes + target_model_octets_max()) {
    return "larger than this program's tables";
  }
  const TableMemory memory(bytes);  // beside the pools, which are the libraries'
  const std::span<std::uint8_t> whole = bytes_of(memory).first(bytes);
  std::ifstream in(file, std::ios::binary);
  in.read(reinterpret_cast<char*>(whole.data()), static_cast<std::streamsize>(whole.size()));
  if (!in) {
    return "cannot be read to its end";
  }
  const std::span<const std::uint8_t> content = whole.subspan(kHeaderBytes);
  if (number_at(&whole[kMagic.size()]) != content.size() ||
      number_at(&whole[kMagic.size() + kNumberBytes]) != crc32_iso_hdlc(content)) {
    return "cut off or damaged";
  }
  const Result<TargetModelFacts> loaded = load_target_model(content, component);
  if (!loaded) {
    return loaded.error().message;
  }
  *facts = loaded.value();
  return "";
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
  const TableMemory memory(kHeaderBytes + target_model_octets_max());
  const std::span<std::uint8_t> out = bytes_of(memory);
  const std::size_t bytes = save_target_model(component, out.subspan(kHeaderBytes));
  if (bytes == 0) {
    throw RunFailure(fmt::format("{}: not written: there is no map", file.string()));
  }
  std::memcpy(out.data(), kMagic.data(), kMagic.size());
  put_number(bytes, &out[kMagic.size()]);
  put_number(crc32_iso_hdlc(out.subspan(kHeaderBytes, bytes)), &out[kMagic.size() + kNumberBytes]);
  write_file(file, {reinterpret_cast<const char*>(out.data()), kHeaderBytes + bytes});
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
