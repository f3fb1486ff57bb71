#include "pipeline/mend_parameters.hpp"

#include <algorithm>
#include <tuple>

#include "base/assert.hpp"
#include "base/fixed_vector.hpp"
#include "pipeline/parameter_image.hpp"
#include "pipeline/state.hpp"

namespace polhode {
namespace {

/// Values in which the tables may differ for all choices to be tried: 256 of them, each the CRC of
/// a table. Chosen: a table has some 5 kB, so even 4096 flips in 12 MB of tables hit one in two
/// places.
constexpr std::size_t kTriedMax = 8;

using Rows = FixedVector<const ParameterRow*, kTriedMax>;

bool agree(const ParameterRow& row, const Parameters& a, const Parameters& b) {
  for (std::size_t i = 0; i < value_count(row); ++i) {
    if (bits_of(row, i, a) != bits_of(row, i, b)) {
      return false;
    }
  }
  return true;
}

void copy_row(const ParameterRow& row, Parameters* from, Parameters* to) {
  std::visit([&](auto where) { where(*to) = where(*from); }, row.member);
}

/// @return false: no choice gives the CRC, or there are too many; nothing is changed.
bool choose_by_crc(Configuration* c) {
  Rows differing;
  for (const ParameterRow& row : parameter_table()) {
    if (!agree(row, c->parameters, c->spare) && !differing.push_back(&row)) {
      return false;
    }
  }
  Parameters chosen = c->parameters;
  for (unsigned choice = 0; choice < 1U << differing.size(); ++choice) {
    for (std::size_t i = 0; i < differing.size(); ++i) {
      const bool of_spare = (choice >> i & 1U) != 0;
      copy_row(*differing[i], of_spare ? &c->spare : &c->parameters, &chosen);
    }
    if (table_crc(chosen) == c->table_crc) {
      c->parameters = chosen;
      return true;
    }
  }
  return false;
}

auto members_of(const CameraModel& m) {
  return std::tie(m.width_px,
                  m.height_px,
                  m.fu_px,
                  m.fv_px,
                  m.cu_px,
                  m.cv_px,
                  m.k1,
                  m.k2,
                  m.p1,
                  m.p2,
                  m.line_time_s);
}

bool tells_model(const CameraParameters& camera, const CameraModel& model) {
  const CameraModel stated = to_model(camera);
  return members_of(stated) == members_of(model);
}

bool is_of_camera(const ParameterRow& row) { return row.key.starts_with("camera."); }

/// The tables agree in the camera, or the camera model shows which of them is right.
bool camera_is_known(const Configuration& c) {
  const auto rows = parameter_table();
  return std::all_of(rows.begin(),
                     rows.end(),
                     [&](const ParameterRow& row) {
                       return !is_of_camera(row) || agree(row, c.parameters, c.spare);
                     }) ||
         tells_model(c.parameters.camera, c.camera) || tells_model(c.spare.camera, c.camera);
}

/// @return values that are their defaults now.
std::uint32_t take_defaults(Configuration* c) {
  Parameters defaults;
  defaults.camera =
      tells_model(c->spare.camera, c->camera) ? c->spare.camera : c->parameters.camera;
  std::uint32_t taken = 0;
  for (const ParameterRow& row : parameter_table()) {
    if (!agree(row, c->parameters, c->spare)) {
      copy_row(row, &defaults, &c->parameters);
      ++taken;
    }
  }
  if (check(c->parameters) || needs_more_memory(c->parameters, *c)) {  // they do not go together
    c->parameters = defaults;
    taken = static_cast<std::uint32_t>(parameter_table().size());
  }
  return taken;
}

}  // namespace

Repair mend_parameters(Configuration* configuration) {
  Configuration& c = *configuration;
  if (table_crc(c.parameters) == c.table_crc) {
    return {};
  }
  if (table_crc(c.spare) == c.table_crc) {
    c.parameters = c.spare;
    return {.entries = 1};
  }
  if (table_crc(c.spare) == table_crc(c.parameters)) {
    c.table_crc = table_crc(c.parameters);
    return {.entries = 1};
  }
  if (choose_by_crc(&c)) {
    return {.entries = 2};  // one of each table, at least
  }
  POLHODE_ASSERT(camera_is_known(c), c.camera.fu_px);
  const std::uint32_t taken = take_defaults(&c);
  const bool is_allowed = !check(c.parameters) && !needs_more_memory(c.parameters, c);
  POLHODE_ASSERT(is_allowed, taken);
  c.table_crc = table_crc(c.parameters);
  return {.entries = taken, .reset = true};
}

}  // namespace polhode
