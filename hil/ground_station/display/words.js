// Written by tools/generate_bus.py from config/bus/*.toml: change those.
"use strict";

// Event: what each of its two numbers is a code of; empty: it is a number.
const eventCodes = {
  "motion_changed": [
    "model.dynamics",
    "model.dynamics"
  ],
  "mode_changed": [
    "motion.mode",
    "motion.mode"
  ],
  "frame_with_care": [
    "",
    "faults"
  ],
  "command_accepted": [
    "commands",
    ""
  ],
  "command_range": [
    "commands",
    ""
  ],
  "command_state": [
    "commands",
    ""
  ],
  "command_repeated": [
    "commands",
    ""
  ]
};

// Names of codes.
const codeNames = {
  "commands": {
    "0": "noop",
    "1": "reset_counters",
    "2": "reset_map",
    "3": "hold",
    "4": "resume",
    "5": "set_known_length",
    "6": "set_range",
    "7": "servicer_attitude",
    "8": "request_cloud",
    "9": "table_load",
    "10": "table_activate",
    "11": "table_discard",
    "12": "checkpoint",
    "13": "predict_point",
    "255": "none"
  },
  "faults": {
    "0": "none",
    "1": "dark",
    "2": "flat",
    "3": "saturated",
    "4": "frozen",
    "5": "torn",
    "6": "bit errors",
    "7": "blurred"
  },
  "model.dynamics": {
    "0": "NONE",
    "1": "LOCAL",
    "2": "TORQUE_FREE",
    "3": "ORBIT"
  },
  "motion.mode": {
    "0": "IDLE",
    "1": "ACQUIRING",
    "2": "TRACKING",
    "3": "LOST",
    "4": "COASTING"
  }
};
