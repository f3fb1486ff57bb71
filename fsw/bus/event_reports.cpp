// Written by tools/generate_bus.py from config/bus/*.toml: change those.
#include "bus/event_reports.hpp"

#include "bus/events.hpp"

namespace polhode::bus::event {

// clang-format off
void started(const Started& is, EventLog* log) { log_event(EventId::kStarted, {.values = {static_cast<double>(is.table_crc)}, .word = is.version}, log); }
void target_acquired(const TargetAcquired& is, EventLog* log) { log_event(EventId::kTargetAcquired, {.values = {static_cast<double>(is.landmarks), static_cast<double>(is.keyframes)}}, log); }
void target_lost(const TargetLost& is, EventLog* log) { log_event(EventId::kTargetLost, {.values = {static_cast<double>(is.poses)}}, log); }
void target_found_again(const TargetFoundAgain& is, EventLog* log) { log_event(EventId::kTargetFoundAgain, {.values = {static_cast<double>(is.frames)}}, log); }
void target_frame_new(const TargetFrameNew& is, EventLog* log) { log_event(EventId::kTargetFrameNew, {.values = {static_cast<double>(is.frames), static_cast<double>(is.target_frame)}}, log); }
void motion_changed(const MotionChanged& is, EventLog* log) { log_event(EventId::kMotionChanged, {.values = {static_cast<double>(is.before), static_cast<double>(is.now)}}, log); }
void stamps_doubted(const StampsDoubted& is, EventLog* log) { log_event(EventId::kStampsDoubted, {.values = {is.shortest_s, is.longest_s}}, log); }
void rate_implausible(const RateImplausible& is, EventLog* log) { log_event(EventId::kRateImplausible, {.values = {is.rate_deg_s}}, log); }
void table_damaged(const TableDamaged& is, EventLog* log) { log_event(EventId::kTableDamaged, {.values = {static_cast<double>(is.entries), static_cast<double>(is.reset)}, .word = is.table}, log); }
void loop_closed(const LoopClosed& is, EventLog* log) { log_event(EventId::kLoopClosed, {.values = {static_cast<double>(is.loops)}}, log); }
void scale_known(const ScaleKnown& is, EventLog* log) { log_event(EventId::kScaleKnown, {.values = {is.metres_per_mu, is.relative_sigma}, .word = is.number}, log); }
void scale_unknown(const ScaleUnknown& is, EventLog* log) { log_event(EventId::kScaleUnknown, {.values = {is.metres_per_mu, static_cast<double>(is.number)}}, log); }
void focal_length_doubted(const FocalLengthDoubted& is, EventLog* log) { log_event(EventId::kFocalLengthDoubted, {.values = {is.stated_px, is.fits_px}, .word = is.sigma}, log); }
void camera_contradicted(const CameraContradicted& is, EventLog* log) { log_event(EventId::kCameraContradicted, {.values = {is.fits, is.sigma_or_v}, .word = is.quantity}, log); }
void scale_not_improved(const ScaleNotImproved& is, EventLog* log) { log_event(EventId::kScaleNotImproved, {.values = {is.relative_sigma, static_cast<double>(is.keyframes)}}, log); }
void table_full(const TableFull& is, EventLog* log) { log_event(EventId::kTableFull, {.values = {static_cast<double>(is.times)}}, log); }
void shape_known(const ShapeKnown& is, EventLog* log) { log_event(EventId::kShapeKnown, {.values = {static_cast<double>(is.points), static_cast<double>(is.planes)}}, log); }
void counters_reset(EventLog* log) { log_event(EventId::kCountersReset, {}, log); }
void mode_changed(const ModeChanged& is, EventLog* log) { log_event(EventId::kModeChanged, {.values = {static_cast<double>(is.before), static_cast<double>(is.now)}}, log); }
void frame_unreadable(const FrameUnreadable& is, EventLog* log) { log_event(EventId::kFrameUnreadable, {.values = {static_cast<double>(is.frame)}}, log); }
void frame_dark(const FrameDark& is, EventLog* log) { log_event(EventId::kFrameDark, {.values = {static_cast<double>(is.frame), is.bright_level}}, log); }
void frame_wrong_size(const FrameWrongSize& is, EventLog* log) { log_event(EventId::kFrameWrongSize, {.values = {static_cast<double>(is.frame)}}, log); }
void frame_time_not_increasing(const FrameTimeNotIncreasing& is, EventLog* log) { log_event(EventId::kFrameTimeNotIncreasing, {.values = {static_cast<double>(is.frame)}}, log); }
void frame_flat(const FrameFlat& is, EventLog* log) { log_event(EventId::kFrameFlat, {.values = {static_cast<double>(is.frame), is.contrast}}, log); }
void frame_saturated(const FrameSaturated& is, EventLog* log) { log_event(EventId::kFrameSaturated, {.values = {static_cast<double>(is.frame), is.fraction}}, log); }
void frame_frozen(const FrameFrozen& is, EventLog* log) { log_event(EventId::kFrameFrozen, {.values = {static_cast<double>(is.frame), is.repeated_rows}}, log); }
void frame_torn(const FrameTorn& is, EventLog* log) { log_event(EventId::kFrameTorn, {.values = {static_cast<double>(is.frame), is.repeated_rows}}, log); }
void frame_bit_errors(const FrameBitErrors& is, EventLog* log) { log_event(EventId::kFrameBitErrors, {.values = {static_cast<double>(is.frame), is.traces}}, log); }
void frame_with_care(const FrameWithCare& is, EventLog* log) { log_event(EventId::kFrameWithCare, {.values = {static_cast<double>(is.frame), static_cast<double>(is.fault)}}, log); }
void noop(const Noop& is, EventLog* log) { log_event(EventId::kNoop, {.word = is.version}, log); }
void command_accepted(const CommandAccepted& is, EventLog* log) { log_event(EventId::kCommandAccepted, {.values = {static_cast<double>(is.command)}, .word = is.name}, log); }
void command_length(const CommandLength& is, EventLog* log) { log_event(EventId::kCommandLength, {.values = {static_cast<double>(is.octets), static_cast<double>(is.expected)}}, log); }
void command_header(EventLog* log) { log_event(EventId::kCommandHeader, {}, log); }
void command_crc(const CommandCrc& is, EventLog* log) { log_event(EventId::kCommandCrc, {.values = {static_cast<double>(is.octets)}}, log); }
void command_unknown(const CommandUnknown& is, EventLog* log) { log_event(EventId::kCommandUnknown, {.values = {static_cast<double>(is.code)}}, log); }
void command_range(const CommandRange& is, EventLog* log) { log_event(EventId::kCommandRange, {.values = {static_cast<double>(is.command)}, .word = is.argument}, log); }
void command_state(const CommandState& is, EventLog* log) { log_event(EventId::kCommandState, {.values = {static_cast<double>(is.command)}, .word = is.reason}, log); }
void command_too_many(const CommandTooMany& is, EventLog* log) { log_event(EventId::kCommandTooMany, {.values = {static_cast<double>(is.beyond), static_cast<double>(is.limit)}}, log); }
void command_repeated(const CommandRepeated& is, EventLog* log) { log_event(EventId::kCommandRepeated, {.values = {static_cast<double>(is.command), static_cast<double>(is.sequence)}, .word = is.name}, log); }
void table_loaded(const TableLoaded& is, EventLog* log) { log_event(EventId::kTableLoaded, {.values = {static_cast<double>(is.entries), static_cast<double>(is.in_all)}}, log); }
void table_refused(const TableRefused& is, EventLog* log) { log_event(EventId::kTableRefused, {.values = {static_cast<double>(is.entry)}, .word = is.key}, log); }
void table_activated(const TableActivated& is, EventLog* log) { log_event(EventId::kTableActivated, {.values = {static_cast<double>(is.crc)}}, log); }
void table_not_activated(const TableNotActivated& is, EventLog* log) { log_event(EventId::kTableNotActivated, {.word = is.reason}, log); }
void cloud_begun(const CloudBegun& is, EventLog* log) { log_event(EventId::kCloudBegun, {.values = {static_cast<double>(is.points), static_cast<double>(is.packets)}}, log); }
void checkpoint_asked(const CheckpointAsked& is, EventLog* log) { log_event(EventId::kCheckpointAsked, {.values = {static_cast<double>(is.frame)}}, log); }
// clang-format on

}  // namespace polhode::bus::event
