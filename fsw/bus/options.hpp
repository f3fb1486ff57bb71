#pragma once

// One line per option: tests/structure/test_parameters.py reads these lines.
// clang-format off
namespace polhode {

struct BusOptions {
  // Any free range of APIDs does; the tables in config/bus and the clients assume this one.
  int apid_first = 0x1A0;              ///< APID of the motion packet; the other packets follow, commands have + 15, 1 .. 2031
  // The four below are chosen for 10 frames/s: every second, and every 5 s.
  int housekeeping_every_frames = 10;  ///< frames from one housekeeping packet to the next, 1 .. 100000
  int model_every_frames = 10;         ///< frames from one model packet to the next; least from one set of predictions to the next, 1 .. 100000
  int shape_every_frames = 50;         ///< frames from one shape packet to the next; least from one estimate to the next, 1 .. 100000
  int event_window_frames = 50;        ///< frames in which only a burst of events of one id is sent, 1 .. 100000
  // Chosen: a cloud of 4000 landmarks is sent in 19 frames. limits::kStepOctets holds four.
  int cloud_chunks_per_frame = 2;      ///< packets of a requested cloud in one frame, 1 .. 4
};

}  // namespace polhode
