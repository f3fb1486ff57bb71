// Options of a live run on its machine: the sections [device], [run] and
// [recording] of a configuration. The estimator does not see them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace polhode::platform {

// One line an option:
// clang-format off
struct DeviceOptions {
  std::string source;                   ///< a video device, or the folder of a sequence that is played at its own pace
  std::string pixel_format = "auto";    ///< "auto", or one of GREY, Y16, Y12, Y10, YUYV, RGB24, MJPEG, JPEG
  double rate_hz = 10.0;                ///< asked of the device, 0.01 .. 1000
  int buffers = 4;                      ///< of the device's ring, 2 .. 32
  int backlog_frames_max = 1;           ///< filled frames that may wait behind the oldest; those beyond are passed over, oldest first, 0 .. 32
  int silence_ms_max = 2000;            ///< a stream that brings nothing for so long is opened again, 50 .. 600000
  int exposure_us = 0;                  ///< set at start; 0: as the device has it, 0 .. 10000000
  double gain = -1.0;                   ///< fraction of the device's range; -1: as it has it, -1 .. 1
  bool exposure_control = true;         ///< exposure and gain follow the target's brightness, as far as the device has controls for them
  double gain_factor_max = 16.0;        ///< light at the gain's highest setting, of that at its lowest, 1 .. 1000
  int readout_us = 0;                   ///< end of exposure to the device's time stamp, 0 .. 10000000
  std::string clock = "monotonic";      ///< of time stamps: "monotonic" (since boot), or "utc" (its offset is taken once, at start)
  double sequence_speed = 1.0;          ///< of a played sequence; 0: as fast as it is taken, 0 .. 1000
  int sequence_passes = 1;              ///< forth, back, forth ... , 1 .. 100000
  std::int64_t sequence_start_ns = 0;   ///< monotonic time of its first frame, so that a run started again finds it in the middle; 0: at start, 0 .. 4000000000000000000
};

struct RunOptions {
  std::string folder;                   ///< of bus.ccsds (continued) and run.json; empty: none
  std::string checkpoint;               ///< file of the state that a run starts from and leaves; empty: none
  std::string model;                    ///< of the target, from another pass, for a start without a checkpoint; empty: none
  int checkpoint_frames = 50;           ///< frames from one to the next, 1 .. 1000000
  int checkpoint_age_s_max = 600;       ///< an older one is not used: the motion model no longer holds, 1 .. 1000000
  int start_s_max = 10;                 ///< a camera that brings no stream within so long ends the run; 0: wait for ever, 0 .. 1000000
  int frames_max = 0;                   ///< accepted frames after which the run ends; 0: none, 0 .. 2000000000
  int report_s = 10;                    ///< seconds from one line on stderr to the next, 1 .. 86400
  bool lock_memory = true;              ///< no page leaves the memory, as far as the limit on locked memory allows it
  int core = -1;                        ///< that the thread that steps frames is bound to; -1: to none, -1 .. 1023
  int priority = 0;                     ///< real-time priority (SCHED_FIFO) of the thread that steps frames, one more than that of the jobs' thread; 0: an ordinary one, 0 .. 99
};

struct RecordingOptions {
  std::string folder;                   ///< empty: nothing is recorded
  int disk_mb_max = 1024;               ///< all recordings in the folder; the oldest go first, 16 .. 100000000
  int segment_mb = 64;                  ///< a file of it, 1 .. 1000
  int slots = 8;                        ///< frames that may wait for the disk; beyond that they are not recorded and counted, 2 .. 64
  bool complete = false;                ///< rather let the run wait for the disk than miss a frame
};
// clang-format on

struct MachineOptions {
  DeviceOptions device;
  RunOptions run;
  RecordingOptions recording;
};

/// True for a section that is read here: load_configuration() passes over it.
bool is_machine_section(std::string_view section);

/// @param settings as load_configuration(); those of other sections are passed over.
/// @throws UnusableInput naming file and line (or --set), key, value and what is allowed.
MachineOptions load_machine_options(const std::filesystem::path& file,
                                    std::span<const std::string> settings);

/// One line an option: key, value, allowed range.
std::string machine_table(const MachineOptions& options);

/// All keys, dotted.
std::vector<std::string> machine_keys();

}  // namespace polhode::platform
