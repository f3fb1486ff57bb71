// Written by tools/generate_bus.py from config/bus/*.toml: change those.
// Everything on the bus as plain data: telemetry packets and the arguments of commands.
#pragma once

#include <array>
#include <cstdint>

#include "bus/fields.hpp"

namespace polhode::bus {

// clang-format off
enum class PacketId : std::uint8_t {
  kMotion = 0,
  kModel = 1,
  kPrediction = 2,
  kShape = 3,
  kHousekeeping = 4,
  kEvent = 5,
  kCloud = 6,
  kPlatform = 7,
  kCommandLink = 8,
  kPlatformEvent = 9,
  kPoint = 10,
};

inline constexpr std::size_t kPacketKinds = 11;
inline constexpr int kCommandApid = 15;  ///< above the first one

enum class CommandCode : std::uint8_t {
  kNoop = 0,
  kResetCounters = 1,
  kResetMap = 2,
  kHold = 3,
  kResume = 4,
  kSetKnownLength = 5,
  kSetRange = 6,
  kServicerAttitude = 7,
  kRequestCloud = 8,
  kTableLoad = 9,
  kTableActivate = 10,
  kTableDiscard = 11,
  kCheckpoint = 12,
  kPredictPoint = 13,
};

enum class Rejection : std::uint8_t {
  kNone = 0,
  kLength = 1,
  kHeader = 2,
  kCrc = 3,
  kUnknownCode = 4,
  kRange = 5,
  kState = 6,
  kTooMany = 7,
};

/// Attitude, position and their rates of change, at the middle of this frame's exposure.
struct MotionPacket {
  std::int64_t timestamp_ns = 0;  ///< middle of the exposure since 1970-01-01T00:00:00, exact; ns
  std::array<double, 4> q_CT{};  ///< takes T components to C components; unit norm, sign continuous in time; flag pose
  std::array<double, 3> p_CT{};  ///< position of T's origin seen from C, in C; length; flag pose
  std::array<double, 3> v_C{};  ///< velocity of T's origin relative to C's origin, in C; length/s; flag velocity
  std::array<double, 3> w_T_rad_s{};  ///< angular velocity of T relative to inertial space, in T; rad/s; flag rate
  double sigma_att_rad = 0.0;  ///< 1-sigma of the attitude, worst axis; rad; flag pose
  double sigma_pos = 0.0;  ///< 1-sigma of the position, worst axis; length; flag pose
  double sigma_vel = 0.0;  ///< 1-sigma of the velocity, worst axis; length/s; flag velocity
  double sigma_rate_rad_s = 0.0;  ///< 1-sigma of the rate, worst axis; rad/s; flag rate
  std::array<float, 21> cov_pose{};  ///< covariance of (phi, dp) in C, upper triangle by rows; R_true = exp(phi) R_CT, p_true = p_CT + dp; rad and length; flag pose
  std::array<float, 6> cov_v{};  ///< covariance of v_C; (length/s)^2; flag velocity
  std::array<float, 6> cov_w{};  ///< covariance of w_T; (rad/s)^2; flag rate
  std::uint32_t frame = 0;  ///< index of the accepted frame
  std::uint16_t features = 0;  ///< detected or tracked in this frame
  std::uint16_t matches = 0;  ///< features associated with landmarks; before a map, with tracks
  std::uint16_t inliers = 0;  ///< matches that agree with the pose
  std::uint16_t landmarks = 0;  ///< landmarks in the map
  std::uint16_t keyframes = 0;  ///< keyframes in the map
  std::uint8_t mode = 0;  ///< what the component is doing; COASTING: the frame could not be looked at, its pose is the motion's prediction
  std::uint8_t flags = 0;
  static const Layout& layout();  ///< 310 octets
};

/// Motion of a free rigid body fitted to the poses so far: rates, principal axes, inertia ratios, periods, velocity, centre of mass. Each class states how well the data determine a quantity. WEAK: its 1-sigma is under about half of its value, 30 deg, or half of the body's radius. OBSERVED: under a tenth, 6 deg, or a tenth of the radius. UNOBSERVED: more; its values are zero.
struct ModelPacket {
  std::int64_t timestamp_ns = 0;  ///< the time that the values belong to; ns
  std::array<double, 3> w_T_rad_s{};  ///< the model's angular velocity at that time, relative to inertial space, in T; rad/s; flag rate
  std::array<double, 4> q_TB{};  ///< principal axes of inertia B, by increasing moment: takes B components to T components; each axis is valid as class_axes says; flag axes
  std::array<double, 2> inertia_ratio{};  ///< principal moments over the smallest one: Jy/Jx, Jz/Jx; flag inertia
  double period_spin_s = 0.0;  ///< time in which the body rates repeat (the polhode's period); s; flag spin
  double period_precession_s = 0.0;  ///< mean time of one revolution about the angular momentum; s; flag precession
  std::array<double, 3> momentum_axis_C{};  ///< direction of the angular momentum, in C at that time; zero where class_momentum is UNOBSERVED
  std::array<double, 3> v_C{};  ///< velocity of the centre of mass relative to C's origin, in C at that time; length/s; flag velocity
  std::array<double, 3> c_T{};  ///< centre of mass seen from T's origin, in T; components along UNOBSERVED directions are zero; length; flag mass_centre
  std::array<float, 6> cov_w{};  ///< covariance of w_T; (rad/s)^2; flag rate
  std::array<float, 3> sigma_axes_rad{};  ///< 1-sigma of the direction of each axis, worst direction; rad; flag axes
  std::array<float, 2> sigma_inertia_ratio{};  ///< 1-sigma of the ratios; flag inertia
  float sigma_period_spin_s = 0.0F;  ///< 1-sigma of period_spin_s; s; flag spin
  float sigma_period_precession_s = 0.0F;  ///< 1-sigma of period_precession_s; s; flag precession
  float sigma_momentum_axis_rad = 0.0F;  ///< 1-sigma of momentum_axis_C, worst direction; zero where class_momentum is UNOBSERVED; rad
  std::array<float, 6> cov_v{};  ///< covariance of v_C; (length/s)^2; flag velocity
  std::array<float, 6> cov_c{};  ///< covariance of c_T; along UNOBSERVED directions, the extent that the body allows; length^2; flag mass_centre
  float span_s = 0.0F;  ///< time between the first and the last pose of the fit; s
  std::array<float, 2> chi2_per_dof{};  ///< chi-square per degree of freedom of the fit; 1 where the poses' sigmas are right; cov and sigma of this packet use the noise found by the fit
  std::uint32_t poses = 0;  ///< poses that the fit used
  std::uint32_t frame = 0;  ///< index of the frame at publication
  std::uint8_t dynamics = 0;  ///< what was fitted; LOCAL: a polynomial through the last poses
  std::uint8_t refusal = 0;  ///< why the poses are not accepted as those of a free rigid body
  std::array<std::uint8_t, 3> class_axes{};  ///< how well each axis of B is determined
  std::array<std::uint8_t, 2> class_inertia{};  ///< how well each ratio is determined
  std::uint8_t class_spin = 0;  ///< how well period_spin_s is determined
  std::uint8_t class_precession = 0;  ///< how well period_precession_s is determined
  std::uint8_t class_momentum = 0;  ///< how well momentum_axis_C is determined
  std::array<std::uint8_t, 3> class_mass_centre{};  ///< how well c_T is determined along the principal axes of cov_c
  std::uint8_t flags = 0;
  static const Layout& layout();  ///< 324 octets
};

/// Where the target will be if nothing acts on it. Attitude is valid while its 1-sigma is under 0.5 rad, position while its 1-sigma is under half the distance.
struct PredictionPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the last frame that the prediction uses; ns
  std::int64_t predicted_timestamp_ns = 0;  ///< the time that the values belong to; ns
  std::array<double, 4> q_CT{};  ///< predicted attitude, in C with its orientation at timestamp_ns; w >= 0; flag attitude
  std::array<double, 3> p_CT{};  ///< predicted position of T's origin seen from C's, in C with its orientation at timestamp_ns; length; flag position
  std::array<double, 3> w_T_rad_s{};  ///< predicted angular velocity, in T; rad/s; flag rate
  std::array<float, 21> cov_pose{};  ///< as in the motion packet; rows and columns of what is not valid are zero; rad and length
  std::array<float, 6> cov_w{};  ///< covariance of w_T; (rad/s)^2; flag rate
  std::uint32_t frame = 0;  ///< index of the last frame that the prediction uses
  std::uint16_t poses = 0;  ///< poses that the prediction uses
  std::uint8_t dynamics = 0;  ///< what was used; LOCAL: a polynomial through the last poses
  std::uint8_t flags = 0;
  static const Layout& layout();  ///< 230 octets
};

/// Dimensions, body frame, flat faces and cylinder of the target, from the map's confirmed landmarks. The flags axis_x, axis_y, axis_z tell which axes of B follow from the body's geometry; the others are arbitrary.
struct ShapePacket {
  std::int64_t timestamp_ns = 0;  ///< time of the frame at publication; ns
  std::array<double, 4> q_TB{};  ///< body frame B: takes B components to T components; flag shape
  std::array<double, 3> centroid_T{};  ///< centre of the completed body, which is B's origin, in T; length; flag shape
  std::array<double, 3> centroid_measured_T{};  ///< mean of the measured cloud, in T; length; flag shape
  std::array<double, 3> dimensions{};  ///< full lengths along B's axes; length; flag shape
  std::array<double, 3> sigma_dimensions{};  ///< 1-sigma; like all sigmas of this packet, without the scale's error; length; flag shape
  double metres_per_mu = 0.0;  ///< scale by which map units were converted to metres; m/map unit; flag scale_known
  std::array<float, 3> cylinder_axis_T{};  ///< unit vector, either sign; flag cylinder
  std::array<float, 3> cylinder_centre_T{};  ///< on the axis, at half length; length; flag cylinder
  float cylinder_radius = 0.0F;  ///< length; flag cylinder
  float cylinder_length = 0.0F;  ///< length of the part that has points; length; flag cylinder
  float cylinder_coverage_rad = 0.0F;  ///< part of the circumference that has points; rad; flag cylinder
  float sigma_cylinder_axis_rad = 0.0F;  ///< 1-sigma, worst direction; rad; flag cylinder
  float sigma_cylinder_radius = 0.0F;  ///< 1-sigma; length; flag cylinder
  float spacing = 0.0F;  ///< typical distance between neighbouring points; length; flag shape
  float thickness = 0.0F;  ///< 1-sigma noise of the cloud, perpendicular to its surface; length; flag shape
  float sigma_scale = 0.0F;  ///< relative 1-sigma of the scale: sigma of metres_per_mu over its value; flag scale_known
  std::array<float, 36> plane_normal_T{};  ///< normal of plane i: unit vector away from the centroid; rows from plane_count on are zero; flag shape
  std::array<float, 12> plane_offset{};  ///< normal . p = offset for points p of the plane, in T; length; flag shape
  std::array<float, 36> plane_centre_T{};  ///< centre of the rectangle about its points; length; flag shape
  std::array<float, 24> plane_extent{};  ///< full lengths of that rectangle; length; flag shape
  std::array<float, 36> plane_sigma{};  ///< 1-sigma of the tilt about u and v, and of the offset; rad, rad, length; flag shape
  std::uint32_t frame = 0;  ///< index of the frame at publication
  std::uint32_t frame_of_estimate = 0;  ///< index of the frame whose map the estimate used
  std::array<std::uint16_t, 12> plane_inliers{};  ///< points of each plane; flag shape
  std::uint16_t landmarks = 0;  ///< landmarks that the estimate used
  std::uint16_t cloud_points = 0;  ///< points measured, after outlier removal
  std::uint16_t completion_points = 0;  ///< points added by completion
  std::uint8_t plane_count = 0;  ///< planes in this packet
  std::uint8_t completion = 0;  ///< body that the cloud was completed to
  std::uint8_t frame_source = 0;  ///< what B's axes follow from
  std::array<std::uint8_t, 3> dimension_basis{};  ///< what each dimension rests on; NOTHING: the points are flat there; POINTS: where points end, a lower limit; SURFACES: a surface at both ends; flag shape
  std::uint8_t flags = 0;
  std::uint8_t spare = 0;  ///< 0
  static const Layout& layout();  ///< 840 octets
};

/// Counters and state of the component. Counters start at 0 and wrap at 2^32. RESET_COUNTERS sets them to 0, but not frame.
struct HousekeepingPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the frame at publication; ns
  std::uint64_t memory_octets = 0;  ///< size of the component's own tables, fixed since start; octet
  std::uint32_t frame = 0;  ///< index of the frame at publication
  std::uint32_t frames_in = 0;  ///< frames given to the component
  std::uint32_t frames_used = 0;  ///< frames that were processed
  std::uint32_t frames_unreadable = 0;  ///< frames that the camera could not deliver whole
  std::uint32_t frames_dark = 0;  ///< frames too dark to be used
  std::uint32_t frames_wrong_size = 0;  ///< frames whose size is not the camera's
  std::uint32_t frames_time_not_increasing = 0;  ///< frames not later than the one before, or by more than 30 years
  std::uint32_t frames_held = 0;  ///< frames skipped after HOLD
  std::uint32_t frames_missing = 0;  ///< frames that never came, judged by gaps in time
  std::uint32_t frames_flat = 0;  ///< frames without contrast; this kind and the next five are skipped, or used as degraded frames
  std::uint32_t frames_saturated = 0;  ///< frames far more saturated than those before
  std::uint32_t frames_frozen = 0;  ///< frames that repeat the previous image
  std::uint32_t frames_torn = 0;  ///< frames of which a part repeats the previous image
  std::uint32_t frames_bit_errors = 0;  ///< frames with damaged pixels, lines or blocks
  std::uint32_t frames_blurred = 0;  ///< frames far less sharp than those before
  std::uint32_t frames_with_care = 0;  ///< degraded frames: used for a pose only, not for the map
  std::uint32_t poses = 0;  ///< frames with a pose
  std::uint32_t lost = 0;  ///< times that the target was lost
  std::uint32_t relocalised = 0;  ///< times that the target was found again by its map
  std::uint32_t restarts = 0;  ///< times that a new map was begun after a loss
  std::uint32_t start_contests = 0;  ///< hypothesis selections, each an attempt to begin a map
  std::uint32_t keyframes_inserted = 0;  ///< keyframes added to the map
  std::uint32_t keyframes_culled = 0;  ///< keyframes removed from the map
  std::uint32_t landmarks_created = 0;  ///< landmarks added to the map
  std::uint32_t landmarks_culled = 0;  ///< landmarks removed from the map
  std::uint32_t closures = 0;  ///< loops closed
  std::uint32_t shapes = 0;  ///< estimates of the shape
  std::uint32_t jobs_issued = 0;  ///< initialisations, adjustments of the map, fits of the dynamics, shape estimates, tests of the camera
  std::uint32_t jobs_without_result = 0;  ///< jobs skipped because memory was short, and adjustments without a usable solution
  std::uint32_t steps_short_of_memory = 0;  ///< steps with reduced work because memory was short
  std::uint32_t scale_contradictions = 0;  ///< times that the readings of the scale began to contradict each other
  std::uint32_t tables_full = 0;  ///< times that a new entry found its table full
  std::uint32_t commands_accepted = 0;  ///< commands carried out
  std::uint32_t commands_rejected = 0;  ///< commands refused
  std::uint32_t events_sent = 0;  ///< events sent as packets
  std::uint32_t events_suppressed = 0;  ///< events counted but not sent, beyond their burst
  std::uint32_t packets_not_sent = 0;  ///< packets that did not fit into the output of a frame
  std::uint32_t table_crc = 0;  ///< CRC-32 of the active parameter table
  std::uint32_t table_loaded_crc = 0;  ///< CRC-32 of the entries loaded since the inactive table was begun
  std::uint16_t table_entries = 0;  ///< entries loaded into the inactive table
  std::uint16_t landmarks = 0;  ///< landmarks in the map
  std::uint16_t keyframes = 0;  ///< keyframes in the map
  std::uint16_t cloud_chunks_left = 0;  ///< packets of a requested cloud still to be sent
  std::uint8_t last_command = 0;  ///< function code of the last command, accepted or not; 255: none yet
  std::uint8_t last_rejection = 0;  ///< why the last rejected command was refused
  std::uint8_t mode = 0;  ///< what the component is doing; COASTING: the frame could not be looked at, its pose is the motion's prediction
  std::array<std::uint8_t, 3> version{};  ///< of the component
  std::uint8_t flags = 0;
  std::uint8_t tables_damaged = 0;  ///< tables found damaged in memory, and reset or rebuilt; 255: so many or more
  static const Layout& layout();  ///< 206 octets
};

/// Something happened. The id alone states what; the text is for people.
struct EventPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the frame; ns
  std::array<double, 2> value{};  ///< the event's numbers, in the order of its arguments
  std::uint32_t frame = 0;  ///< index of the frame
  std::uint32_t occurrences = 0;  ///< events of this id since start or RESET_COUNTERS, this one and suppressed ones included
  std::uint32_t suppressed = 0;  ///< events of this id suppressed since the last one that was sent
  std::uint16_t id = 0;  ///< see the table of events
  std::uint8_t severity = 0;  ///< how serious the event is
  std::uint8_t text_octets = 0;  ///< length of the text
  std::array<char, 122> text{};  ///< ASCII without control characters, zero-padded
  std::uint16_t command_sequence = 0;  ///< sequence count of the command that this answers; 0: of none, or of one without a count
  static const Layout& layout();  ///< 182 octets
};

/// A part of the map's landmarks at the time when the request was executed.
struct CloudPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the last frame processed before the request was executed; ns
  double metres_per_mu = 0.0;  ///< already applied to the points; m/map unit; flag scale_known
  std::uint32_t points_total = 0;  ///< points of the whole cloud
  std::uint32_t first_point = 0;  ///< index of this packet's first point
  std::uint16_t cloud = 0;  ///< number of the request, from 1, wraps
  std::uint16_t chunk = 0;  ///< number of this packet in its cloud, from 0
  std::uint16_t chunks = 0;  ///< packets of this cloud
  std::uint8_t points = 0;  ///< points in this packet; the rest is zero
  std::uint8_t flags = 0;
  std::array<float, 330> p_T{};  ///< landmarks, in T; length
  static const Layout& layout();  ///< 1370 octets
};

/// State of the machine around the component. Not part of the stream that the same frames reproduce.
struct PlatformPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the last frame; ns
  std::uint64_t resident_octets = 0;  ///< resident memory of the process; octet
  std::uint64_t resident_peak_octets = 0;  ///< its greatest value since start; octet
  std::uint32_t uptime_s = 0;  ///< time since the start of the process; s
  std::uint32_t frames_dropped = 0;  ///< frames missing by the camera's count, skipped for newer ones, or for lack of time
  std::uint32_t camera_errors = 0;  ///< damaged frames, failed streams, disconnections
  std::uint32_t camera_reopened = 0;  ///< streams opened after the first one
  std::uint32_t deadline_misses = 0;  ///< steps that took longer than a frame
  std::uint32_t jobs_late = 0;  ///< job results that were not there when due; each costs a frame
  std::uint32_t last_step_us = 0;  ///< duration of the last step; us
  std::uint32_t longest_step_us = 0;  ///< longest step since start; us
  std::uint32_t packets_sent = 0;  ///< over all transports
  std::uint32_t packets_dropped = 0;  ///< packets lost to readers that are there but had no room for long
  std::uint32_t commands_received = 0;  ///< datagrams received at the command socket
  std::uint32_t commands_dropped = 0;  ///< commands dropped by the system before they were read, as far as it reports (UDP)
  std::uint16_t restarts = 0;  ///< starts from a checkpoint since the last cold start
  std::uint8_t flags = 0;
  std::uint8_t spare = 0;  ///< 0
  static const Layout& layout();  ///< 94 octets
};

/// What came to the command ports, and who may give commands. What the component then refused is in housekeeping.
struct CommandLinkPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the last frame; ns
  std::uint64_t highest_number = 0;  ///< greatest number of a signed command taken; numbers up to it that left the window are refused
  std::uint32_t received = 0;  ///< datagrams received
  std::uint32_t passed = 0;  ///< commands handed to the component
  std::uint32_t refused_sender = 0;  ///< refused: sent by another user (Unix sockets)
  std::uint32_t refused_form = 0;  ///< refused: no packet with a trailer
  std::uint32_t refused_mac = 0;  ///< refused: not signed by this key
  std::uint32_t refused_number = 0;  ///< refused: taken before, or older than the window
  std::uint32_t dropped = 0;  ///< dropped by the system before they were read, as far as it reports (UDP)
  std::uint32_t numbers_not_kept = 0;  ///< commands passed whose number the disk refused: they could be repeated after a restart
  std::uint8_t ports = 0;  ///< command ports
  std::uint8_t flags = 0;  ///< key: commands are signed; unauthenticated: anybody who reaches a UDP port may give them; number_not_kept: numbers_not_kept is not 0
  std::array<std::uint8_t, 2> spare{};  ///< 0
  static const Layout& layout();  ///< 70 octets
};

/// Something happened in the machine around the component, as the disk took no more. The id alone states what; the text is for people.
struct PlatformEventPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the last frame; ns
  std::array<double, 4> value{};  ///< the event's numbers, in the order of its text
  std::uint16_t id = 0;  ///< 1: the disk did not take all since the start: packets of so many steps in bus.ccsds, checkpoints, records of the recording, packets of file: transports
  std::uint8_t severity = 0;  ///< how serious the event is
  std::uint8_t text_octets = 0;  ///< length of the text
  std::array<char, 122> text{};  ///< ASCII without control characters, zero-padded
  std::array<std::uint8_t, 2> spare{};  ///< 0
  static const Layout& layout();  ///< 186 octets
};

/// Where a point of the target will be, and which way its surface will face, if nothing acts on it. Covariances hold what is not known of motion, mass centre, map, scale and camera. The position is valid while its 1-sigma is under half the distance and that of the attitude under 0.5 rad, the normal while the latter is.
struct PointPacket {
  std::int64_t timestamp_ns = 0;  ///< time of the last frame that the prediction uses; ns
  std::int64_t predicted_timestamp_ns = 0;  ///< the time that the values belong to; ns
  std::array<double, 3> p_C{};  ///< the point seen from C, in C with its orientation at timestamp_ns; length; flag position
  std::array<double, 3> v_C{};  ///< its velocity relative to C's origin, likewise; by the dynamics alone; length/s; flag velocity
  std::array<double, 3> normal_C{};  ///< direction that the surface faces there, likewise; flag normal
  std::array<float, 6> cov_p{};  ///< covariance of p_C; length^2; flag position
  std::array<float, 6> cov_v{};  ///< covariance of v_C; (length/s)^2; flag velocity
  float sigma_normal_rad = 0.0F;  ///< 1-sigma of the direction of normal_C, worst way; rad; flag normal
  std::uint32_t number = 0;  ///< of the command
  std::uint32_t target_frame = 0;  ///< number of the frame T that the point is in
  std::uint8_t dynamics = 0;  ///< what was used; LOCAL: a polynomial through the last poses
  std::uint8_t flags = 0;
  std::array<std::uint8_t, 2> spare{};  ///< 0
  static const Layout& layout();  ///< 170 octets
};

/// gives the distance between two image points of a frame; once measured in the map, it replaces any earlier length or range
struct SetKnownLengthCommand {
  std::int64_t frame_timestamp_ns = 0;  ///< time of the frame in which the points are seen: one that has become a keyframe, or one yet to come; ns
  double length_m = 0.0;  ///< distance between the two points; m
  std::array<double, 2> first_px{};  ///< one end; px
  std::array<double, 2> second_px{};  ///< the other end; px
  static const Layout& layout();  ///< 58 octets
};

/// gives a range finder's reading to the target's nearest surface on the boresight; once applied to the map, it replaces any earlier length or range
struct SetRangeCommand {
  std::int64_t frame_timestamp_ns = 0;  ///< time of the frame at which it was read: one that has become a keyframe, or one yet to come; ns
  double range_m = 0.0;  ///< the reading; m
  static const Layout& layout();  ///< 26 octets
};

/// attitude and angular velocity of the camera relative to inertial space; until the first one the camera is assumed not to rotate
struct ServicerAttitudeCommand {
  std::int64_t timestamp_ns = 0;  ///< the time that the values belong to; later than that of the last one; ns
  std::array<double, 4> q_IC{};  ///< takes C components to I components; norm within 1e-3 of 1
  std::array<double, 3> w_C_rad_s{};  ///< angular velocity of C relative to I, in C; rad/s
  static const Layout& layout();  ///< 74 octets
};

/// sends the map's landmarks in cloud packets; a request still being sent is dropped
struct RequestCloudCommand {
  std::uint32_t points_max = 0;  ///< points at most, taken evenly from the map
  static const Layout& layout();  ///< 14 octets
};

/// loads entries into the inactive parameter table; the first one after start, activation or discard begins it as a copy of the active table. One bad entry, and nothing of the packet is loaded
struct TableLoadCommand {
  std::uint16_t entries = 0;  ///< entries that follow
  std::array<std::uint16_t, 3> spare{};  ///< 0
  static const Layout& layout();  ///< with the CRC and no entries
};

inline constexpr std::size_t kTableLoadEntriesMax = 64;
struct TableLoadEntry {
  std::uint32_t key_crc = 0;  ///< CRC-32 (ISO-HDLC) of the parameter's dotted key, as in features.count_max
  std::uint16_t index = 0;  ///< component of a compound value, else 0
  std::uint16_t spare = 0;  ///< 0
  std::uint64_t value = 0;  ///< bits of a binary64, or a whole number in two's complement (a switch: 0 or 1), by the parameter's type
  static const Layout& layout();  ///< 16 octets, offsets from its first
};

/// checks the inactive table as a whole and makes it active before the next frame is processed
struct TableActivateCommand {
  std::uint32_t crc32 = 0;  ///< CRC-32 (ISO-HDLC) over the octets of all entries loaded since the table was begun
  std::uint32_t entries = 0;  ///< number of these entries
  static const Layout& layout();  ///< 18 octets
};

/// asks where a point of the target will be: a packet `point` answers in the same step. Refused where no motion is known that reaches the time: 10 s ahead by the last poses alone, 100 rad of rotation by the dynamics
struct PredictPointCommand {
  std::int64_t predicted_timestamp_ns = 0;  ///< the time that is asked for; not before the last frame; ns
  std::array<double, 3> p_T{};  ///< the point, taken as exact, in the unit of lengths that packets now have; length
  std::array<double, 3> normal_T{};  ///< direction that the surface faces there, norm within 1e-3 of 1; zero: not asked for
  std::uint32_t target_frame = 0;  ///< number of the frame T that the point is in, the first is 1, later ones are told by event target_frame_new
  std::uint32_t number = 0;  ///< the asker's own, for the answer
  static const Layout& layout();  ///< 74 octets
};

// clang-format on

}  // namespace polhode::bus
