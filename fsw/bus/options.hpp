#pragma once

// One line an option:
// clang-format off
namespace polhode {

// One line an option: the tables of parameters and tests/structure/test_parameters.py read these lines.
struct BusOptions {
  int apid_first = 0x1A0;              ///< application process id of the motion packet; the others' follow, commands come at + 15, 1 .. 2031
  int housekeeping_every_frames = 10;  ///< housekeeping packet every so many frames, 1 .. 100000
  int model_every_frames = 10;         ///< motion model, and predictions begun, every so many frames, 1 .. 100000
  int shape_every_frames = 50;         ///< shape estimated and sent every so many frames, 1 .. 100000
  int event_window_frames = 50;        ///< events of one id are throttled over so many frames, 1 .. 100000
  int cloud_chunks_per_frame = 2;      ///< packets of a requested cloud in one frame, 1 .. 4
};

}  // namespace polhode
