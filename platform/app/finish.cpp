#include "app/finish.hpp"

namespace polhode::platform {

void finish_replay(Component& /*component*/,
                   const Sequence& /*sequence*/,
                   ObservationSpool& /*observations*/,
                   const std::filesystem::path& /*folder*/) {}

}  // namespace polhode::platform
