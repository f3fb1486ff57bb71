#include "transport/command_window.hpp"

#include <algorithm>

namespace polhode::platform {

bool CommandWindow::is_new(std::uint64_t number) const {
  return number > floor_ && std::find(taken().begin(), taken().end(), number) == taken().end();
}

void CommandWindow::take(std::uint64_t number) {
  highest_ = std::max(highest_, number);
  if (count_ < taken_.size()) {
    taken_[count_++] = number;
    return;
  }
  const auto least = std::min_element(taken_.begin(), taken_.end());
  floor_ = std::min(*least, number);
  *least = std::max(*least, number);
}

}  // namespace polhode::platform
