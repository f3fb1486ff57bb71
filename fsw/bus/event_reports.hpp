// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// One function an event, with its arguments by name: event::target_lost({.poses = 3}, &log).
#pragma once

#include <cstdint>
#include <string_view>

#include "bus/packets.hpp"
#include "image/verdict.hpp"
#include "motion/motion_state.hpp"

namespace polhode::bus {

struct EventLog;

namespace event {

// clang-format off
/// INFO: component {version} started, table CRC {table_crc}
struct Started {
  std::string_view version;
  std::uint32_t table_crc;
};
void started(const Started& is, EventLog* log);

/// INFO: map begun: {landmarks} landmarks, {keyframes} keyframes
struct TargetAcquired {
  std::uint32_t landmarks;
  std::uint32_t keyframes;
};
void target_acquired(const TargetAcquired& is, EventLog* log);

/// WARNING: target lost after {poses} poses
struct TargetLost {
  std::uint32_t poses;
};
void target_lost(const TargetLost& is, EventLog* log);

/// INFO: target found again after {frames} frames
struct TargetFoundAgain {
  std::uint32_t frames;
};
void target_found_again(const TargetFoundAgain& is, EventLog* log);

/// WARNING: map begun anew after {frames} frames, in a new frame T and unit, number {target_frame}
struct TargetFrameNew {
  std::uint32_t frames;
  std::uint32_t target_frame;
};
void target_frame_new(const TargetFrameNew& is, EventLog* log);

/// INFO: dynamics {before} to {now} (1: local fits, 2: torque-free, 3: in orbit)
struct MotionChanged {
  std::uint8_t before;  ///< model.dynamics
  std::uint8_t now;  ///< model.dynamics
};
void motion_changed(const MotionChanged& is, EventLog* log);

/// WARNING: time stamps doubted: intervals {shortest_s} to {longest_s} s, yet it turns alike over all; no rates
struct StampsDoubted {
  double shortest_s;  ///< s
  double longest_s;  ///< s
};
void stamps_doubted(const StampsDoubted& is, EventLog* log);

/// WARNING: {rate_deg_s} deg/s: faster than debris turns; are the time stamps nanoseconds?
struct RateImplausible {
  double rate_deg_s;  ///< deg/s
};
void rate_implausible(const RateImplausible& is, EventLog* log);

/// WARNING: {table} damaged in memory: {entries} entries dropped or put right, reset {reset}
struct TableDamaged {
  std::string_view table;
  std::uint32_t entries;
  std::uint8_t reset;  ///< 0 .. 1
};
void table_damaged(const TableDamaged& is, EventLog* log);

/// INFO: {loops} loops closed
struct LoopClosed {
  std::uint32_t loops;
};
void loop_closed(const LoopClosed& is, EventLog* log);

/// INFO: scale known: {metres_per_mu} m per map unit, relative sigma {relative_sigma}; {number}
struct ScaleKnown {
  double metres_per_mu;  ///< m/map unit, 0 .. inf
  double relative_sigma;  ///< 0 .. inf
  std::string_view number;
};
void scale_known(const ScaleKnown& is, EventLog* log);

/// WARNING: scale unknown from here on, lengths in map units, number {number}; before: {metres_per_mu} m per map unit
struct ScaleUnknown {
  double metres_per_mu;  ///< m/map unit, 0 .. inf
  std::uint32_t number;
};
void scale_unknown(const ScaleUnknown& is, EventLog* log);

/// WARNING: focal length {stated_px} px contradicted: {fits_px} px fits, {sigma}; sigmas are widened
struct FocalLengthDoubted {
  double stated_px;  ///< px
  double fits_px;  ///< px
  std::string_view sigma;
};
void focal_length_doubted(const FocalLengthDoubted& is, EventLog* log);

/// WARNING: stated camera contradicted: {quantity} {fits}, {sigma_or_v} fits; sigmas are widened
struct CameraContradicted {
  std::string_view quantity;
  double fits;
  double sigma_or_v;
};
void camera_contradicted(const CameraContradicted& is, EventLog* log);

/// INFO: the length read anew in a map of {keyframes} keyframes is no better known: relative sigma {relative_sigma}
struct ScaleNotImproved {
  double relative_sigma;  ///< 0 .. inf
  std::uint32_t keyframes;
};
void scale_not_improved(const ScaleNotImproved& is, EventLog* log);

/// WARNING: a table was full {times} times
struct TableFull {
  std::uint32_t times;
};
void table_full(const TableFull& is, EventLog* log);

/// INFO: shape estimated: {points} points, {planes} planes
struct ShapeKnown {
  std::uint32_t points;
  std::uint32_t planes;
};
void shape_known(const ShapeKnown& is, EventLog* log);

/// INFO: counters reset
void counters_reset(EventLog* log);

/// INFO: mode {before} to {now}
struct ModeChanged {
  Mode before;  ///< motion.mode
  Mode now;  ///< motion.mode
};
void mode_changed(const ModeChanged& is, EventLog* log);

/// WARNING: frame {frame} unreadable
struct FrameUnreadable {
  std::uint32_t frame;
};
void frame_unreadable(const FrameUnreadable& is, EventLog* log);

/// WARNING: frame {frame} too dark
struct FrameDark {
  std::uint32_t frame;
  double bright_level;  ///< 0 .. 1
};
void frame_dark(const FrameDark& is, EventLog* log);

/// ERROR: frame {frame} has the wrong size
struct FrameWrongSize {
  std::uint32_t frame;
};
void frame_wrong_size(const FrameWrongSize& is, EventLog* log);

/// ERROR: frame {frame}: time does not increase, or by 30 years
struct FrameTimeNotIncreasing {
  std::uint32_t frame;
};
void frame_time_not_increasing(const FrameTimeNotIncreasing& is, EventLog* log);

/// WARNING: frame {frame} without contrast
struct FrameFlat {
  std::uint32_t frame;
  double contrast;  ///< 0 .. 1
};
void frame_flat(const FrameFlat& is, EventLog* log);

/// WARNING: frame {frame} skipped: {fraction} of it saturated
struct FrameSaturated {
  std::uint32_t frame;
  double fraction;  ///< 0 .. 1
};
void frame_saturated(const FrameSaturated& is, EventLog* log);

/// WARNING: frame {frame} is the one before
struct FrameFrozen {
  std::uint32_t frame;
  double repeated_rows;
};
void frame_frozen(const FrameFrozen& is, EventLog* log);

/// WARNING: frame {frame} torn: {repeated_rows} rows are old
struct FrameTorn {
  std::uint32_t frame;
  double repeated_rows;
};
void frame_torn(const FrameTorn& is, EventLog* log);

/// WARNING: frame {frame} has bit errors
struct FrameBitErrors {
  std::uint32_t frame;
  double traces;
};
void frame_bit_errors(const FrameBitErrors& is, EventLog* log);

/// INFO: frame {frame} used with care: fault {fault}
struct FrameWithCare {
  std::uint32_t frame;
  FrameFault fault;  ///< faults
};
void frame_with_care(const FrameWithCare& is, EventLog* log);

/// INFO: NOOP, version {version}
struct Noop {
  std::string_view version;
};
void noop(const Noop& is, EventLog* log);

/// INFO: command {command} {name} accepted
struct CommandAccepted {
  CommandCode command;  ///< commands
  std::string_view name;
};
void command_accepted(const CommandAccepted& is, EventLog* log);

/// ERROR: command refused: {octets} octets, expected {expected}
struct CommandLength {
  std::uint32_t octets;
  std::uint32_t expected;
};
void command_length(const CommandLength& is, EventLog* log);

/// ERROR: command refused: header or layout version
void command_header(EventLog* log);

/// ERROR: command refused: CRC of {octets} octets differs
struct CommandCrc {
  std::uint32_t octets;
};
void command_crc(const CommandCrc& is, EventLog* log);

/// ERROR: command refused: unknown code {code}
struct CommandUnknown {
  std::uint8_t code;
};
void command_unknown(const CommandUnknown& is, EventLog* log);

/// ERROR: command {command} refused: {argument} out of range
struct CommandRange {
  CommandCode command;  ///< commands
  std::string_view argument;
};
void command_range(const CommandRange& is, EventLog* log);

/// ERROR: command {command} refused: {reason}
struct CommandState {
  CommandCode command;  ///< commands
  std::string_view reason;
};
void command_state(const CommandState& is, EventLog* log);

/// ERROR: {beyond} commands in one frame refused, {limit} are the limit
struct CommandTooMany {
  std::uint32_t beyond;
  std::uint32_t limit;
};
void command_too_many(const CommandTooMany& is, EventLog* log);

/// INFO: command {command} {name} of count {sequence} was carried out before
struct CommandRepeated {
  CommandCode command;  ///< commands
  std::string_view name;
  std::uint16_t sequence;  ///< 0 .. 16383
};
void command_repeated(const CommandRepeated& is, EventLog* log);

/// INFO: {entries} entries loaded, {in_all} in all
struct TableLoaded {
  std::uint32_t entries;
  std::uint32_t in_all;
};
void table_loaded(const TableLoaded& is, EventLog* log);

/// ERROR: table entry {entry} refused: {key}
struct TableRefused {
  std::uint32_t entry;
  std::string_view key;
};
void table_refused(const TableRefused& is, EventLog* log);

/// INFO: table activated, CRC {crc}
struct TableActivated {
  std::uint32_t crc;
};
void table_activated(const TableActivated& is, EventLog* log);

/// ERROR: table not activated: {reason}
struct TableNotActivated {
  std::string_view reason;
};
void table_not_activated(const TableNotActivated& is, EventLog* log);

/// INFO: cloud of {points} points in {packets} packets
struct CloudBegun {
  std::uint32_t points;
  std::uint32_t packets;
};
void cloud_begun(const CloudBegun& is, EventLog* log);

/// INFO: checkpoint asked for at frame {frame}
struct CheckpointAsked {
  std::uint32_t frame;
};
void checkpoint_asked(const CheckpointAsked& is, EventLog* log);

// clang-format on

}  // namespace event
}  // namespace polhode::bus
