// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// All events: id, severity and the text for people.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "bus/code_names.hpp"

namespace polhode::bus {

// clang-format off
enum class Severity : std::uint8_t {
  kDebug = 0,
  kInfo = 1,
  kWarning = 2,
  kError = 3,
  kCritical = 4,
};

enum class EventId : std::uint16_t {
  kStarted = 1,
  kTargetAcquired = 2,
  kTargetLost = 3,
  kTargetFoundAgain = 4,
  kTargetFrameNew = 11,
  kMotionChanged = 12,
  kStampsDoubted = 13,
  kRateImplausible = 14,
  kTableDamaged = 15,
  kLoopClosed = 5,
  kScaleKnown = 6,
  kScaleUnknown = 16,
  kFocalLengthDoubted = 18,
  kCameraContradicted = 19,
  kScaleNotImproved = 17,
  kTableFull = 7,
  kShapeKnown = 8,
  kCountersReset = 10,
  kModeChanged = 9,
  kFrameUnreadable = 20,
  kFrameDark = 21,
  kFrameWrongSize = 22,
  kFrameTimeNotIncreasing = 23,
  kFrameFlat = 24,
  kFrameSaturated = 25,
  kFrameFrozen = 26,
  kFrameTorn = 27,
  kFrameBitErrors = 28,
  kFrameWithCare = 29,
  kNoop = 40,
  kCommandAccepted = 41,
  kCommandLength = 42,
  kCommandHeader = 43,
  kCommandCrc = 44,
  kCommandUnknown = 45,
  kCommandRange = 46,
  kCommandState = 47,
  kCommandTooMany = 48,
  kCommandRepeated = 49,
  kTableLoaded = 60,
  kTableRefused = 61,
  kTableActivated = 62,
  kTableNotActivated = 63,
  kCloudBegun = 70,
  kCheckpointAsked = 71,
};

struct EventRow {
  EventId id;
  Severity severity;
  std::uint32_t burst;  ///< sent at most in a window of frames
  const char* name;
  const char* text;  ///< {0}, {1}: the event's numbers; {}: its word
  std::array<std::span<const CodeName>, 2> words;  ///< what the numbers are codes of; empty for numbers
};

inline constexpr std::size_t kEventKinds = 45;
inline constexpr std::array<EventRow, kEventKinds> kEvents{{
    {EventId::kStarted, Severity::kInfo, 4, "started", "component {} started, table CRC {0}", {{{}, {}}}},
    {EventId::kTargetAcquired, Severity::kInfo, 4, "target_acquired", "map begun: {0} landmarks, {1} keyframes", {{{}, {}}}},
    {EventId::kTargetLost, Severity::kWarning, 4, "target_lost", "target lost after {0} poses", {{{}, {}}}},
    {EventId::kTargetFoundAgain, Severity::kInfo, 4, "target_found_again", "target found again after {0} frames", {{{}, {}}}},
    {EventId::kTargetFrameNew, Severity::kWarning, 4, "target_frame_new", "map begun anew after {0} frames, in a new frame T and unit, number {1}", {{{}, {}}}},
    {EventId::kMotionChanged, Severity::kInfo, 4, "motion_changed", "dynamics {0} to {1} (1: local fits, 2: torque-free, 3: in orbit)", {{kModelDynamicsNames, kModelDynamicsNames}}},
    {EventId::kStampsDoubted, Severity::kWarning, 4, "stamps_doubted", "time stamps doubted: intervals {0} to {1} s, yet it turns alike over all; no rates", {{{}, {}}}},
    {EventId::kRateImplausible, Severity::kWarning, 4, "rate_implausible", "{0} deg/s: faster than debris turns; are the time stamps nanoseconds?", {{{}, {}}}},
    {EventId::kTableDamaged, Severity::kWarning, 4, "table_damaged", "{} damaged in memory: {0} entries dropped or put right, reset {1}", {{{}, {}}}},
    {EventId::kLoopClosed, Severity::kInfo, 4, "loop_closed", "{0} loops closed", {{{}, {}}}},
    {EventId::kScaleKnown, Severity::kInfo, 4, "scale_known", "scale known: {0} m per map unit, relative sigma {1}; {}", {{{}, {}}}},
    {EventId::kScaleUnknown, Severity::kWarning, 4, "scale_unknown", "scale unknown from here on, lengths in map units, number {1}; before: {0} m per map unit", {{{}, {}}}},
    {EventId::kFocalLengthDoubted, Severity::kWarning, 4, "focal_length_doubted", "focal length {0} px contradicted: {1} px fits, {}; sigmas are widened", {{{}, {}}}},
    {EventId::kCameraContradicted, Severity::kWarning, 4, "camera_contradicted", "stated camera contradicted: {} {0}, {1} fits; sigmas are widened", {{{}, {}}}},
    {EventId::kScaleNotImproved, Severity::kInfo, 4, "scale_not_improved", "the length read anew in a map of {1} keyframes is no better known: relative sigma {0}", {{{}, {}}}},
    {EventId::kTableFull, Severity::kWarning, 4, "table_full", "a table was full {0} times", {{{}, {}}}},
    {EventId::kShapeKnown, Severity::kInfo, 4, "shape_known", "shape estimated: {0} points, {1} planes", {{{}, {}}}},
    {EventId::kCountersReset, Severity::kInfo, 4, "counters_reset", "counters reset", {{{}, {}}}},
    {EventId::kModeChanged, Severity::kInfo, 4, "mode_changed", "mode {0} to {1}", {{kMotionModeNames, kMotionModeNames}}},
    {EventId::kFrameUnreadable, Severity::kWarning, 4, "frame_unreadable", "frame {0} unreadable", {{{}, {}}}},
    {EventId::kFrameDark, Severity::kWarning, 4, "frame_dark", "frame {0} too dark", {{{}, {}}}},
    {EventId::kFrameWrongSize, Severity::kError, 4, "frame_wrong_size", "frame {0} has the wrong size", {{{}, {}}}},
    {EventId::kFrameTimeNotIncreasing, Severity::kError, 4, "frame_time_not_increasing", "frame {0}: time does not increase, or by 30 years", {{{}, {}}}},
    {EventId::kFrameFlat, Severity::kWarning, 4, "frame_flat", "frame {0} without contrast", {{{}, {}}}},
    {EventId::kFrameSaturated, Severity::kWarning, 4, "frame_saturated", "frame {0} skipped: {1} of it saturated", {{{}, {}}}},
    {EventId::kFrameFrozen, Severity::kWarning, 4, "frame_frozen", "frame {0} is the one before", {{{}, {}}}},
    {EventId::kFrameTorn, Severity::kWarning, 4, "frame_torn", "frame {0} torn: {1} rows are old", {{{}, {}}}},
    {EventId::kFrameBitErrors, Severity::kWarning, 4, "frame_bit_errors", "frame {0} has bit errors", {{{}, {}}}},
    {EventId::kFrameWithCare, Severity::kInfo, 4, "frame_with_care", "frame {0} used with care: fault {1}", {{{}, kFaultsNames}}},
    {EventId::kNoop, Severity::kInfo, 16, "noop", "NOOP, version {}", {{{}, {}}}},
    {EventId::kCommandAccepted, Severity::kInfo, 16, "command_accepted", "command {0} {} accepted", {{kCommandsNames, {}}}},
    {EventId::kCommandLength, Severity::kError, 16, "command_length", "command refused: {0} octets, expected {1}", {{{}, {}}}},
    {EventId::kCommandHeader, Severity::kError, 16, "command_header", "command refused: header or layout version", {{{}, {}}}},
    {EventId::kCommandCrc, Severity::kError, 16, "command_crc", "command refused: CRC of {0} octets differs", {{{}, {}}}},
    {EventId::kCommandUnknown, Severity::kError, 16, "command_unknown", "command refused: unknown code {0}", {{{}, {}}}},
    {EventId::kCommandRange, Severity::kError, 16, "command_range", "command {0} refused: {} out of range", {{kCommandsNames, {}}}},
    {EventId::kCommandState, Severity::kError, 16, "command_state", "command {0} refused: {}", {{kCommandsNames, {}}}},
    {EventId::kCommandTooMany, Severity::kError, 16, "command_too_many", "{0} commands in one frame refused, {1} are the limit", {{{}, {}}}},
    {EventId::kCommandRepeated, Severity::kInfo, 16, "command_repeated", "command {0} {} of count {1} was carried out before", {{kCommandsNames, {}}}},
    {EventId::kTableLoaded, Severity::kInfo, 16, "table_loaded", "{0} entries loaded, {1} in all", {{{}, {}}}},
    {EventId::kTableRefused, Severity::kError, 16, "table_refused", "table entry {0} refused: {}", {{{}, {}}}},
    {EventId::kTableActivated, Severity::kInfo, 16, "table_activated", "table activated, CRC {0}", {{{}, {}}}},
    {EventId::kTableNotActivated, Severity::kError, 16, "table_not_activated", "table not activated: {}", {{{}, {}}}},
    {EventId::kCloudBegun, Severity::kInfo, 16, "cloud_begun", "cloud of {0} points in {1} packets", {{{}, {}}}},
    {EventId::kCheckpointAsked, Severity::kInfo, 16, "checkpoint_asked", "checkpoint asked for at frame {0}", {{{}, {}}}},
}};
// clang-format on

}  // namespace polhode::bus
