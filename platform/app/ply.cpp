#include "app/ply.hpp"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <string>

#include "output_file.hpp"

namespace polhode::platform {
namespace {

void put_float(std::string& out, double value) {
  const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
  for (unsigned shift = 0; shift < 32; shift += 8) {
    out += static_cast<char>((bits >> shift) & 0xFFU);
  }
}

void put_whole(std::string& out, std::uint32_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) {
    out += static_cast<char>((value >> shift) & 0xFFU);
  }
}

void put_vector(std::string& out, const Eigen::Vector3d& vector) {
  put_float(out, vector.x());
  put_float(out, vector.y());
  put_float(out, vector.z());
}

std::string header(const PlyCloud& cloud) {
  std::string text = "ply\nformat binary_little_endian 1.0\n";
  text += fmt::format("comment {}\nelement vertex {}\n", cloud.comment, cloud.points.size());
  text += "property float x\nproperty float y\nproperty float z\n";
  if (!cloud.normals.empty()) {
    text += "property float nx\nproperty float ny\nproperty float nz\n";
  }
  if (!cloud.rgb.empty()) {
    text += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  }
  if (!cloud.added.empty()) {
    text += "property uchar added\n";
  }
  if (!cloud.sigma.empty()) {
    text += "property float sigma\n";
  }
  if (!cloud.views.empty()) {
    text += "property int views\n";
  }
  if (!cloud.landmark.empty()) {
    text += "property int landmark\n";
  }
  if (!cloud.faces.empty()) {
    text += fmt::format("element face {}\nproperty list uchar int vertex_indices\n",
                        cloud.faces.size());
  }
  return text + "end_header\n";
}

}  // namespace

void write_ply(const std::filesystem::path& file, const PlyCloud& cloud) {
  std::string content = header(cloud);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    put_vector(content, cloud.points[i]);
    if (!cloud.normals.empty()) {
      put_vector(content, cloud.normals[i]);
    }
    if (!cloud.rgb.empty()) {
      for (const std::uint8_t channel : cloud.rgb[i]) {
        content += static_cast<char>(channel);
      }
    }
    if (!cloud.added.empty()) {
      content += static_cast<char>(cloud.added[i]);
    }
    if (!cloud.sigma.empty()) {
      put_float(content, static_cast<double>(cloud.sigma[i]));
    }
    if (!cloud.views.empty()) {
      put_whole(content, static_cast<std::uint32_t>(cloud.views[i]));
    }
    if (!cloud.landmark.empty()) {
      put_whole(content, static_cast<std::uint32_t>(cloud.landmark[i]));
    }
  }
  for (const auto& face : cloud.faces) {
    content += static_cast<char>(face.size());
    for (const std::uint32_t corner : face) {
      put_whole(content, corner);
    }
  }
  write_file(file, content);
}

}  // namespace polhode::platform
