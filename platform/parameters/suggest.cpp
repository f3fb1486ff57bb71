#include "parameters/suggest.hpp"

#include <algorithm>
#include <vector>

#include "pipeline/parameter_table.hpp"

namespace polhode::platform {

std::size_t edit_distance(std::string_view a, std::string_view b) {
  // Wagner and Fischer, JACM 1974, with one row.
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

std::string_view nearest_parameter(std::string_view key) {
  std::string_view best;
  std::size_t best_distance = std::max<std::size_t>(3, key.size() / 2);
  for (const ParameterRow& row : parameter_table()) {
    // The right field without its section is near, too.
    const std::string_view field = row.key.substr(row.key.find('.') + 1);
    const std::string_view given = key.substr(key.rfind('.') + 1);
    const std::size_t distance =
        field == given ? 1 : std::min(edit_distance(key, row.key), edit_distance(key, field) + 1);
    if (distance < best_distance) {
      best_distance = distance;
      best = row.key;
    }
  }
  return best;
}

}  // namespace polhode::platform
