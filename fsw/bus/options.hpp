#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// Ranges and units are in pipeline/parameter_table.cpp.
// clang-format off
namespace polhode {

struct BusOptions {
  // Any free range of APIDs does; the tables in config/bus and the clients assume this one.
  int apid_first = 0x1A0;              ///< APID of the motion packet; the other packets follow, commands have + 15
  // The four below are chosen for 10 frames/s: every second, and every 5 s.
  int housekeeping_every_frames = 10;  ///< frames from one housekeeping packet to the next
  int model_every_frames = 10;         ///< frames from one model packet to the next; least from one set of predictions to the next
  int shape_every_frames = 50;         ///< frames from one shape packet to the next; least from one estimate to the next
  int event_window_frames = 50;        ///< frames in which only a burst of events of one id is sent
  // Chosen: a cloud of 4000 landmarks is sent in 19 frames. limits::kStepOctets holds four.
  int cloud_chunks_per_frame = 2;      ///< packets of a requested cloud in one frame
};

}  // namespace polhode
