// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// Names of codes, for the ground.
#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace polhode::bus {

// clang-format off
struct CodeName {
  std::uint16_t code;
  const char* name;
};

inline constexpr CodeName kCommandsNames[] = {
    {0, "noop"},
    {1, "reset_counters"},
    {2, "reset_map"},
    {3, "hold"},
    {4, "resume"},
    {5, "set_known_length"},
    {6, "set_range"},
    {7, "servicer_attitude"},
    {8, "request_cloud"},
    {9, "table_load"},
    {10, "table_activate"},
    {11, "table_discard"},
    {12, "checkpoint"},
    {13, "predict_point"},
    {255, "none"},
};
inline constexpr CodeName kEventsNames[] = {
    {1, "started"},
    {2, "target_acquired"},
    {3, "target_lost"},
    {4, "target_found_again"},
    {11, "target_frame_new"},
    {12, "motion_changed"},
    {13, "stamps_doubted"},
    {14, "rate_implausible"},
    {15, "table_damaged"},
    {5, "loop_closed"},
    {6, "scale_known"},
    {16, "scale_unknown"},
    {18, "focal_length_doubted"},
    {19, "camera_contradicted"},
    {17, "scale_not_improved"},
    {7, "table_full"},
    {8, "shape_known"},
    {10, "counters_reset"},
    {9, "mode_changed"},
    {20, "frame_unreadable"},
    {21, "frame_dark"},
    {22, "frame_wrong_size"},
    {23, "frame_time_not_increasing"},
    {24, "frame_flat"},
    {25, "frame_saturated"},
    {26, "frame_frozen"},
    {27, "frame_torn"},
    {28, "frame_bit_errors"},
    {29, "frame_with_care"},
    {40, "noop"},
    {41, "command_accepted"},
    {42, "command_length"},
    {43, "command_header"},
    {44, "command_crc"},
    {45, "command_unknown"},
    {46, "command_range"},
    {47, "command_state"},
    {48, "command_too_many"},
    {49, "command_repeated"},
    {60, "table_loaded"},
    {61, "table_refused"},
    {62, "table_activated"},
    {63, "table_not_activated"},
    {70, "cloud_begun"},
    {71, "checkpoint_asked"},
};
inline constexpr CodeName kFaultsNames[] = {
    {0, "none"},
    {1, "dark"},
    {2, "flat"},
    {3, "saturated"},
    {4, "frozen"},
    {5, "torn"},
    {6, "bit errors"},
    {7, "blurred"},
};
inline constexpr CodeName kModelDynamicsNames[] = {
    {0, "NONE"},
    {1, "LOCAL"},
    {2, "TORQUE_FREE"},
    {3, "ORBIT"},
};
inline constexpr CodeName kMotionModeNames[] = {
    {0, "IDLE"},
    {1, "ACQUIRING"},
    {2, "TRACKING"},
    {3, "LOST"},
    {4, "COASTING"},
};
// clang-format on

/// The name of a code; empty where it has none.
constexpr std::string_view name_of(std::span<const CodeName> names, double code) {
  for (const CodeName& row : names) {
    if (row.code == code) {
      return row.name;
    }
  }
  return {};
}

}  // namespace polhode::bus
