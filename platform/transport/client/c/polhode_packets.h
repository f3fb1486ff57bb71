/* Written by tools/generate_bus.py from the files in config/bus: change those. */
#ifndef POLHODE_PACKETS_H
#define POLHODE_PACKETS_H

#include <stdint.h>

#define POLHODE_LAYOUT_VERSION 3
#define POLHODE_APID_FIRST 416

#define POLHODE_MOTION 0 /* number of the packet: its APID less the first one */
#define POLHODE_MOTION_OCTETS 310
#define POLHODE_MOTION_POSE 0x01
#define POLHODE_MOTION_RATE 0x02
#define POLHODE_MOTION_VELOCITY 0x04
#define POLHODE_MOTION_SCALE_KNOWN 0x08
/* number of the scale in force, modulo 16: lengths of one number have one unit; it rises by one at each change of the scale, and with a map begun anew */
#define POLHODE_MOTION_SCALE_NUMBER(flags) ((uint8_t)((flags) >> 4))
#define POLHODE_MOTION_MODE_IDLE 0
#define POLHODE_MOTION_MODE_ACQUIRING 1
#define POLHODE_MOTION_MODE_TRACKING 2
#define POLHODE_MOTION_MODE_LOST 3
#define POLHODE_MOTION_MODE_COASTING 4
/* Attitude, position and their rates of change, at the middle of this frame's exposure. */
struct polhode_motion {
  int64_t timestamp_ns; /* middle of the exposure since 1970-01-01T00:00:00, exact; ns */
  double q_CT[4]; /* takes T components to C components; unit norm, sign continuous in time; flag pose */
  double p_CT[3]; /* position of T's origin seen from C, in C; length; flag pose */
  double v_C[3]; /* velocity of T's origin relative to C's origin, in C; length/s; flag velocity */
  double w_T_rad_s[3]; /* angular velocity of T relative to inertial space, in T; rad/s; flag rate */
  double sigma_att_rad; /* 1-sigma of the attitude, worst axis; rad; flag pose */
  double sigma_pos; /* 1-sigma of the position, worst axis; length; flag pose */
  double sigma_vel; /* 1-sigma of the velocity, worst axis; length/s; flag velocity */
  double sigma_rate_rad_s; /* 1-sigma of the rate, worst axis; rad/s; flag rate */
  float cov_pose[21]; /* covariance of (phi, dp) in C, upper triangle by rows; R_true = exp(phi) R_CT, p_true = p_CT + dp; rad and length; flag pose */
  float cov_v[6]; /* covariance of v_C; (length/s)^2; flag velocity */
  float cov_w[6]; /* covariance of w_T; (rad/s)^2; flag rate */
  uint32_t frame; /* index of the accepted frame */
  uint16_t features; /* detected or tracked in this frame */
  uint16_t matches; /* features associated with landmarks; before a map, with tracks */
  uint16_t inliers; /* matches that agree with the pose */
  uint16_t landmarks; /* landmarks in the map */
  uint16_t keyframes; /* keyframes in the map */
  uint8_t mode; /* what the component is doing; COASTING: the frame could not be looked at, its pose is the motion's prediction */
  uint8_t flags;
};

#define POLHODE_MODEL 1 /* number of the packet: its APID less the first one */
#define POLHODE_MODEL_OCTETS 324
#define POLHODE_MODEL_RATE 0x01
#define POLHODE_MODEL_AXES 0x02
#define POLHODE_MODEL_INERTIA 0x04
#define POLHODE_MODEL_SPIN 0x08
#define POLHODE_MODEL_PRECESSION 0x10
#define POLHODE_MODEL_VELOCITY 0x20
#define POLHODE_MODEL_MASS_CENTRE 0x40
#define POLHODE_MODEL_SCALE_KNOWN 0x80
#define POLHODE_MODEL_DYNAMICS_NONE 0
#define POLHODE_MODEL_DYNAMICS_LOCAL 1
#define POLHODE_MODEL_DYNAMICS_TORQUE_FREE 2
#define POLHODE_MODEL_DYNAMICS_ORBIT 3
#define POLHODE_MODEL_REFUSAL_NONE 0
#define POLHODE_MODEL_REFUSAL_TOO_FEW_POSES 1
#define POLHODE_MODEL_REFUSAL_NO_FIT 2
#define POLHODE_MODEL_REFUSAL_RESIDUALS_TOO_LARGE 3
#define POLHODE_MODEL_CLASS_AXES_UNOBSERVED 0
#define POLHODE_MODEL_CLASS_AXES_WEAK 1
#define POLHODE_MODEL_CLASS_AXES_OBSERVED 2
#define POLHODE_MODEL_CLASS_INERTIA_UNOBSERVED 0
#define POLHODE_MODEL_CLASS_INERTIA_WEAK 1
#define POLHODE_MODEL_CLASS_INERTIA_OBSERVED 2
#define POLHODE_MODEL_CLASS_SPIN_UNOBSERVED 0
#define POLHODE_MODEL_CLASS_SPIN_WEAK 1
#define POLHODE_MODEL_CLASS_SPIN_OBSERVED 2
#define POLHODE_MODEL_CLASS_PRECESSION_UNOBSERVED 0
#define POLHODE_MODEL_CLASS_PRECESSION_WEAK 1
#define POLHODE_MODEL_CLASS_PRECESSION_OBSERVED 2
#define POLHODE_MODEL_CLASS_MOMENTUM_UNOBSERVED 0
#define POLHODE_MODEL_CLASS_MOMENTUM_WEAK 1
#define POLHODE_MODEL_CLASS_MOMENTUM_OBSERVED 2
#define POLHODE_MODEL_CLASS_MASS_CENTRE_UNOBSERVED 0
#define POLHODE_MODEL_CLASS_MASS_CENTRE_WEAK 1
#define POLHODE_MODEL_CLASS_MASS_CENTRE_OBSERVED 2
/* Motion of a free rigid body fitted to the poses so far: rates, principal axes, inertia ratios, periods, velocity, centre of mass. Each class states how well the data determine a quantity. WEAK: its 1-sigma is under about half of its value, 30 deg, or half of the body's radius. OBSERVED: under a tenth, 6 deg, or a tenth of the radius. UNOBSERVED: more; its values are zero. */
struct polhode_model {
  int64_t timestamp_ns; /* the time that the values belong to; ns */
  double w_T_rad_s[3]; /* the model's angular velocity at that time, relative to inertial space, in T; rad/s; flag rate */
  double q_TB[4]; /* principal axes of inertia B, by increasing moment: takes B components to T components; each axis is valid as class_axes says; flag axes */
  double inertia_ratio[2]; /* principal moments over the smallest one: Jy/Jx, Jz/Jx; flag inertia */
  double period_spin_s; /* time in which the body rates repeat (the polhode's period); s; flag spin */
  double period_precession_s; /* mean time of one revolution about the angular momentum; s; flag precession */
  double momentum_axis_C[3]; /* direction of the angular momentum, in C at that time; zero where class_momentum is UNOBSERVED */
  double v_C[3]; /* velocity of the centre of mass relative to C's origin, in C at that time; length/s; flag velocity */
  double c_T[3]; /* centre of mass seen from T's origin, in T; components along UNOBSERVED directions are zero; length; flag mass_centre */
  float cov_w[6]; /* covariance of w_T; (rad/s)^2; flag rate */
  float sigma_axes_rad[3]; /* 1-sigma of the direction of each axis, worst direction; rad; flag axes */
  float sigma_inertia_ratio[2]; /* 1-sigma of the ratios; flag inertia */
  float sigma_period_spin_s; /* 1-sigma of period_spin_s; s; flag spin */
  float sigma_period_precession_s; /* 1-sigma of period_precession_s; s; flag precession */
  float sigma_momentum_axis_rad; /* 1-sigma of momentum_axis_C, worst direction; zero where class_momentum is UNOBSERVED; rad */
  float cov_v[6]; /* covariance of v_C; (length/s)^2; flag velocity */
  float cov_c[6]; /* covariance of c_T; along UNOBSERVED directions, the extent that the body allows; length^2; flag mass_centre */
  float span_s; /* time between the first and the last pose of the fit; s */
  float chi2_per_dof[2]; /* chi-square per degree of freedom of the fit; 1 where the poses' sigmas are right; cov and sigma of this packet use the noise found by the fit */
  uint32_t poses; /* poses that the fit used */
  uint32_t frame; /* index of the frame at publication */
  uint8_t dynamics; /* what was fitted; LOCAL: a polynomial through the last poses */
  uint8_t refusal; /* why the poses are not accepted as those of a free rigid body */
  uint8_t class_axes[3]; /* how well each axis of B is determined */
  uint8_t class_inertia[2]; /* how well each ratio is determined */
  uint8_t class_spin; /* how well period_spin_s is determined */
  uint8_t class_precession; /* how well period_precession_s is determined */
  uint8_t class_momentum; /* how well momentum_axis_C is determined */
  uint8_t class_mass_centre[3]; /* how well c_T is determined along the principal axes of cov_c */
  uint8_t flags;
};

#define POLHODE_PREDICTION 2 /* number of the packet: its APID less the first one */
#define POLHODE_PREDICTION_OCTETS 230
#define POLHODE_PREDICTION_ATTITUDE 0x01
#define POLHODE_PREDICTION_RATE 0x02
#define POLHODE_PREDICTION_POSITION 0x04
#define POLHODE_PREDICTION_SCALE_KNOWN 0x08
/* as in the motion packet */
#define POLHODE_PREDICTION_SCALE_NUMBER(flags) ((uint8_t)((flags) >> 4))
#define POLHODE_PREDICTION_DYNAMICS_NONE 0
#define POLHODE_PREDICTION_DYNAMICS_LOCAL 1
#define POLHODE_PREDICTION_DYNAMICS_TORQUE_FREE 2
#define POLHODE_PREDICTION_DYNAMICS_ORBIT 3
/* Where the target will be if nothing acts on it. Attitude is valid while its 1-sigma is under 0.5 rad, position while its 1-sigma is under half the distance. */
struct polhode_prediction {
  int64_t timestamp_ns; /* time of the last frame that the prediction uses; ns */
  int64_t predicted_timestamp_ns; /* the time that the values belong to; ns */
  double q_CT[4]; /* predicted attitude, in C with its orientation at timestamp_ns; w >= 0; flag attitude */
  double p_CT[3]; /* predicted position of T's origin seen from C's, in C with its orientation at timestamp_ns; length; flag position */
  double w_T_rad_s[3]; /* predicted angular velocity, in T; rad/s; flag rate */
  float cov_pose[21]; /* as in the motion packet; rows and columns of what is not valid are zero; rad and length */
  float cov_w[6]; /* covariance of w_T; (rad/s)^2; flag rate */
  uint32_t frame; /* index of the last frame that the prediction uses */
  uint16_t poses; /* poses that the prediction uses */
  uint8_t dynamics; /* what was used; LOCAL: a polynomial through the last poses */
  uint8_t flags;
};

#define POLHODE_SHAPE 3 /* number of the packet: its APID less the first one */
#define POLHODE_SHAPE_OCTETS 840
#define POLHODE_SHAPE_SHAPE 0x01
#define POLHODE_SHAPE_CYLINDER 0x02
#define POLHODE_SHAPE_SCALE_KNOWN 0x04
#define POLHODE_SHAPE_AXIS_X 0x08
#define POLHODE_SHAPE_AXIS_Y 0x10
#define POLHODE_SHAPE_AXIS_Z 0x20
#define POLHODE_SHAPE_COMPLETION_NONE 0
#define POLHODE_SHAPE_COMPLETION_BOX 1
#define POLHODE_SHAPE_COMPLETION_CYLINDER 2
#define POLHODE_SHAPE_FRAME_SOURCE_PRINCIPAL 0
#define POLHODE_SHAPE_FRAME_SOURCE_PLANES 1
#define POLHODE_SHAPE_FRAME_SOURCE_CYLINDER 2
#define POLHODE_SHAPE_DIMENSION_BASIS_NOTHING 0
#define POLHODE_SHAPE_DIMENSION_BASIS_POINTS 1
#define POLHODE_SHAPE_DIMENSION_BASIS_SURFACES 2
/* Dimensions, body frame, flat faces and cylinder of the target, from the map's confirmed landmarks. The flags axis_x, axis_y, axis_z tell which axes of B follow from the body's geometry; the others are arbitrary. */
struct polhode_shape {
  int64_t timestamp_ns; /* time of the frame at publication; ns */
  double q_TB[4]; /* body frame B: takes B components to T components; flag shape */
  double centroid_T[3]; /* centre of the completed body, which is B's origin, in T; length; flag shape */
  double centroid_measured_T[3]; /* mean of the measured cloud, in T; length; flag shape */
  double dimensions[3]; /* full lengths along B's axes; length; flag shape */
  double sigma_dimensions[3]; /* 1-sigma; like all sigmas of this packet, without the scale's error; length; flag shape */
  double metres_per_mu; /* scale by which map units were converted to metres; m/map unit; flag scale_known */
  float cylinder_axis_T[3]; /* unit vector, either sign; flag cylinder */
  float cylinder_centre_T[3]; /* on the axis, at half length; length; flag cylinder */
  float cylinder_radius; /* length; flag cylinder */
  float cylinder_length; /* length of the part that has points; length; flag cylinder */
  float cylinder_coverage_rad; /* part of the circumference that has points; rad; flag cylinder */
  float sigma_cylinder_axis_rad; /* 1-sigma, worst direction; rad; flag cylinder */
  float sigma_cylinder_radius; /* 1-sigma; length; flag cylinder */
  float spacing; /* typical distance between neighbouring points; length; flag shape */
  float thickness; /* 1-sigma noise of the cloud, perpendicular to its surface; length; flag shape */
  float sigma_scale; /* relative 1-sigma of the scale: sigma of metres_per_mu over its value; flag scale_known */
  float plane_normal_T[36]; /* normal of plane i: unit vector away from the centroid; rows from plane_count on are zero; flag shape */
  float plane_offset[12]; /* normal . p = offset for points p of the plane, in T; length; flag shape */
  float plane_centre_T[36]; /* centre of the rectangle about its points; length; flag shape */
  float plane_extent[24]; /* full lengths of that rectangle; length; flag shape */
  float plane_sigma[36]; /* 1-sigma of the tilt about u and v, and of the offset; rad, rad, length; flag shape */
  uint32_t frame; /* index of the frame at publication */
  uint32_t frame_of_estimate; /* index of the frame whose map the estimate used */
  uint16_t plane_inliers[12]; /* points of each plane; flag shape */
  uint16_t landmarks; /* landmarks that the estimate used */
  uint16_t cloud_points; /* points measured, after outlier removal */
  uint16_t completion_points; /* points added by completion */
  uint8_t plane_count; /* planes in this packet */
  uint8_t completion; /* body that the cloud was completed to */
  uint8_t frame_source; /* what B's axes follow from */
  uint8_t dimension_basis[3]; /* what each dimension rests on; NOTHING: the points are flat there; POINTS: where points end, a lower limit; SURFACES: a surface at both ends; flag shape */
  uint8_t flags;
  uint8_t spare; /* 0 */
};

#define POLHODE_HOUSEKEEPING 4 /* number of the packet: its APID less the first one */
#define POLHODE_HOUSEKEEPING_OCTETS 206
#define POLHODE_HOUSEKEEPING_HELD 0x01
#define POLHODE_HOUSEKEEPING_SCALE_KNOWN 0x02
#define POLHODE_HOUSEKEEPING_TABLE_LOADED 0x04
#define POLHODE_HOUSEKEEPING_SERVICER_ATTITUDE 0x08
#define POLHODE_HOUSEKEEPING_FOCAL_LENGTH_DOUBTED 0x10
#define POLHODE_HOUSEKEEPING_CAMERA_CONTRADICTED 0x20
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_NONE 0
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_LENGTH 1
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_HEADER 2
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_CRC 3
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_UNKNOWN_CODE 4
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_RANGE 5
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_STATE 6
#define POLHODE_HOUSEKEEPING_LAST_REJECTION_TOO_MANY 7
#define POLHODE_HOUSEKEEPING_MODE_IDLE 0
#define POLHODE_HOUSEKEEPING_MODE_ACQUIRING 1
#define POLHODE_HOUSEKEEPING_MODE_TRACKING 2
#define POLHODE_HOUSEKEEPING_MODE_LOST 3
#define POLHODE_HOUSEKEEPING_MODE_COASTING 4
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_NOOP 0
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_RESET_COUNTERS 1
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_RESET_MAP 2
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_HOLD 3
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_RESUME 4
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_SET_KNOWN_LENGTH 5
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_SET_RANGE 6
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_SERVICER_ATTITUDE 7
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_REQUEST_CLOUD 8
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_TABLE_LOAD 9
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_TABLE_ACTIVATE 10
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_TABLE_DISCARD 11
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_CHECKPOINT 12
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_PREDICT_POINT 13
#define POLHODE_HOUSEKEEPING_LAST_COMMAND_NONE 255
/* Counters and state of the component. Counters start at 0 and wrap at 2^32. RESET_COUNTERS sets them to 0, but not frame. */
struct polhode_housekeeping {
  int64_t timestamp_ns; /* time of the frame at publication; ns */
  uint64_t memory_octets; /* size of the component's own tables, fixed since start; octet */
  uint32_t frame; /* index of the frame at publication */
  uint32_t frames_in; /* frames given to the component */
  uint32_t frames_used; /* frames that were processed */
  uint32_t frames_unreadable; /* frames that the camera could not deliver whole */
  uint32_t frames_dark; /* frames too dark to be used */
  uint32_t frames_wrong_size; /* frames whose size is not the camera's */
  uint32_t frames_time_not_increasing; /* frames not later than the one before, or by more than 30 years */
  uint32_t frames_held; /* frames skipped after HOLD */
  uint32_t frames_missing; /* frames that never came, judged by gaps in time */
  uint32_t frames_flat; /* frames without contrast; this kind and the next five are skipped, or used as degraded frames */
  uint32_t frames_saturated; /* frames far more saturated than those before */
  uint32_t frames_frozen; /* frames that repeat the previous image */
  uint32_t frames_torn; /* frames of which a part repeats the previous image */
  uint32_t frames_bit_errors; /* frames with damaged pixels, lines or blocks */
  uint32_t frames_blurred; /* frames far less sharp than those before */
  uint32_t frames_with_care; /* degraded frames: used for a pose only, not for the map */
  uint32_t poses; /* frames with a pose */
  uint32_t lost; /* times that the target was lost */
  uint32_t relocalised; /* times that the target was found again by its map */
  uint32_t restarts; /* times that a new map was begun after a loss */
  uint32_t start_contests; /* hypothesis selections, each an attempt to begin a map */
  uint32_t keyframes_inserted; /* keyframes added to the map */
  uint32_t keyframes_culled; /* keyframes removed from the map */
  uint32_t landmarks_created; /* landmarks added to the map */
  uint32_t landmarks_culled; /* landmarks removed from the map */
  uint32_t closures; /* loops closed */
  uint32_t shapes; /* estimates of the shape */
  uint32_t jobs_issued; /* initialisations, adjustments of the map, fits of the dynamics, shape estimates, tests of the camera */
  uint32_t jobs_without_result; /* jobs skipped because memory was short, and adjustments without a usable solution */
  uint32_t steps_short_of_memory; /* steps with reduced work because memory was short */
  uint32_t scale_contradictions; /* times that the readings of the scale began to contradict each other */
  uint32_t tables_full; /* times that a new entry found its table full */
  uint32_t commands_accepted; /* commands carried out */
  uint32_t commands_rejected; /* commands refused */
  uint32_t events_sent; /* events sent as packets */
  uint32_t events_suppressed; /* events counted but not sent, beyond their burst */
  uint32_t packets_not_sent; /* packets that did not fit into the output of a frame */
  uint32_t table_crc; /* CRC-32 of the active parameter table */
  uint32_t table_loaded_crc; /* CRC-32 of the entries loaded since the inactive table was begun */
  uint16_t table_entries; /* entries loaded into the inactive table */
  uint16_t landmarks; /* landmarks in the map */
  uint16_t keyframes; /* keyframes in the map */
  uint16_t cloud_chunks_left; /* packets of a requested cloud still to be sent */
  uint8_t last_command; /* function code of the last command, accepted or not; 255: none yet */
  uint8_t last_rejection; /* why the last rejected command was refused */
  uint8_t mode; /* what the component is doing; COASTING: the frame could not be looked at, its pose is the motion's prediction */
  uint8_t version[3]; /* of the component */
  uint8_t flags;
  uint8_t tables_damaged; /* tables found damaged in memory, and reset or rebuilt; 255: so many or more */
};

#define POLHODE_EVENT 5 /* number of the packet: its APID less the first one */
#define POLHODE_EVENT_OCTETS 182
#define POLHODE_EVENT_SEVERITY_DEBUG 0
#define POLHODE_EVENT_SEVERITY_INFO 1
#define POLHODE_EVENT_SEVERITY_WARNING 2
#define POLHODE_EVENT_SEVERITY_ERROR 3
#define POLHODE_EVENT_SEVERITY_CRITICAL 4
#define POLHODE_EVENT_ID_STARTED 1 /* value[0]: table_crc */
#define POLHODE_EVENT_ID_TARGET_ACQUIRED 2 /* value[0]: landmarks, value[1]: keyframes */
#define POLHODE_EVENT_ID_TARGET_LOST 3 /* value[0]: poses */
#define POLHODE_EVENT_ID_TARGET_FOUND_AGAIN 4 /* value[0]: frames */
#define POLHODE_EVENT_ID_TARGET_FRAME_NEW 11 /* value[0]: frames, value[1]: target_frame */
#define POLHODE_EVENT_ID_MOTION_CHANGED 12 /* value[0]: before (model.dynamics), value[1]: now (model.dynamics) */
#define POLHODE_EVENT_ID_STAMPS_DOUBTED 13 /* value[0]: shortest_s (s), value[1]: longest_s (s) */
#define POLHODE_EVENT_ID_RATE_IMPLAUSIBLE 14 /* value[0]: rate_deg_s (deg/s) */
#define POLHODE_EVENT_ID_TABLE_DAMAGED 15 /* value[0]: entries, value[1]: reset (0 .. 1) */
#define POLHODE_EVENT_ID_LOOP_CLOSED 5 /* value[0]: loops */
#define POLHODE_EVENT_ID_SCALE_KNOWN 6 /* value[0]: metres_per_mu (m/map unit, 0 .. inf), value[1]: relative_sigma (0 .. inf) */
#define POLHODE_EVENT_ID_SCALE_UNKNOWN 16 /* value[0]: metres_per_mu (m/map unit, 0 .. inf), value[1]: number */
#define POLHODE_EVENT_ID_FOCAL_LENGTH_DOUBTED 18 /* value[0]: stated_px (px), value[1]: fits_px (px) */
#define POLHODE_EVENT_ID_CAMERA_CONTRADICTED 19 /* value[0]: fits, value[1]: sigma_or_v */
#define POLHODE_EVENT_ID_SCALE_NOT_IMPROVED 17 /* value[0]: relative_sigma (0 .. inf), value[1]: keyframes */
#define POLHODE_EVENT_ID_TABLE_FULL 7 /* value[0]: times */
#define POLHODE_EVENT_ID_SHAPE_KNOWN 8 /* value[0]: points, value[1]: planes */
#define POLHODE_EVENT_ID_COUNTERS_RESET 10
#define POLHODE_EVENT_ID_MODE_CHANGED 9 /* value[0]: before (motion.mode), value[1]: now (motion.mode) */
#define POLHODE_EVENT_ID_FRAME_UNREADABLE 20 /* value[0]: frame */
#define POLHODE_EVENT_ID_FRAME_DARK 21 /* value[0]: frame, value[1]: bright_level (0 .. 1) */
#define POLHODE_EVENT_ID_FRAME_WRONG_SIZE 22 /* value[0]: frame */
#define POLHODE_EVENT_ID_FRAME_TIME_NOT_INCREASING 23 /* value[0]: frame */
#define POLHODE_EVENT_ID_FRAME_FLAT 24 /* value[0]: frame, value[1]: contrast (0 .. 1) */
#define POLHODE_EVENT_ID_FRAME_SATURATED 25 /* value[0]: frame, value[1]: fraction (0 .. 1) */
#define POLHODE_EVENT_ID_FRAME_FROZEN 26 /* value[0]: frame, value[1]: repeated_rows */
#define POLHODE_EVENT_ID_FRAME_TORN 27 /* value[0]: frame, value[1]: repeated_rows */
#define POLHODE_EVENT_ID_FRAME_BIT_ERRORS 28 /* value[0]: frame, value[1]: traces */
#define POLHODE_EVENT_ID_FRAME_WITH_CARE 29 /* value[0]: frame, value[1]: fault (faults) */
#define POLHODE_EVENT_ID_NOOP 40
#define POLHODE_EVENT_ID_COMMAND_ACCEPTED 41 /* value[0]: command (commands) */
#define POLHODE_EVENT_ID_COMMAND_LENGTH 42 /* value[0]: octets, value[1]: expected */
#define POLHODE_EVENT_ID_COMMAND_HEADER 43
#define POLHODE_EVENT_ID_COMMAND_CRC 44 /* value[0]: octets */
#define POLHODE_EVENT_ID_COMMAND_UNKNOWN 45 /* value[0]: code */
#define POLHODE_EVENT_ID_COMMAND_RANGE 46 /* value[0]: command (commands) */
#define POLHODE_EVENT_ID_COMMAND_STATE 47 /* value[0]: command (commands) */
#define POLHODE_EVENT_ID_COMMAND_TOO_MANY 48 /* value[0]: beyond, value[1]: limit */
#define POLHODE_EVENT_ID_COMMAND_REPEATED 49 /* value[0]: command (commands), value[1]: sequence (0 .. 16383) */
#define POLHODE_EVENT_ID_TABLE_LOADED 60 /* value[0]: entries, value[1]: in_all */
#define POLHODE_EVENT_ID_TABLE_REFUSED 61 /* value[0]: entry */
#define POLHODE_EVENT_ID_TABLE_ACTIVATED 62 /* value[0]: crc */
#define POLHODE_EVENT_ID_TABLE_NOT_ACTIVATED 63
#define POLHODE_EVENT_ID_CLOUD_BEGUN 70 /* value[0]: points, value[1]: packets */
#define POLHODE_EVENT_ID_CHECKPOINT_ASKED 71 /* value[0]: frame */
/* Something happened. The id alone states what; the text is for people. */
struct polhode_event {
  int64_t timestamp_ns; /* time of the frame; ns */
  double value[2]; /* the event's numbers, in the order of its arguments */
  uint32_t frame; /* index of the frame */
  uint32_t occurrences; /* events of this id since start or RESET_COUNTERS, this one and suppressed ones included */
  uint32_t suppressed; /* events of this id suppressed since the last one that was sent */
  uint16_t id; /* see the table of events */
  uint8_t severity; /* how serious the event is */
  uint8_t text_octets; /* length of the text */
  char text[123]; /* ASCII without control characters, zero-padded */
  uint16_t command_sequence; /* sequence count of the command that this answers; 0: of none, or of one without a count */
};

#define POLHODE_CLOUD 6 /* number of the packet: its APID less the first one */
#define POLHODE_CLOUD_OCTETS 1370
#define POLHODE_CLOUD_SCALE_KNOWN 0x01
/* A part of the map's landmarks at the time when the request was executed. */
struct polhode_cloud {
  int64_t timestamp_ns; /* time of the last frame processed before the request was executed; ns */
  double metres_per_mu; /* already applied to the points; m/map unit; flag scale_known */
  uint32_t points_total; /* points of the whole cloud */
  uint32_t first_point; /* index of this packet's first point */
  uint16_t cloud; /* number of the request, from 1, wraps */
  uint16_t chunk; /* number of this packet in its cloud, from 0 */
  uint16_t chunks; /* packets of this cloud */
  uint8_t points; /* points in this packet; the rest is zero */
  uint8_t flags;
  float p_T[330]; /* landmarks, in T; length */
};

#define POLHODE_PLATFORM 7 /* number of the packet: its APID less the first one */
#define POLHODE_PLATFORM_OCTETS 94
#define POLHODE_PLATFORM_WATCHDOG 0x01
#define POLHODE_PLATFORM_LOCKED_MEMORY 0x02
#define POLHODE_PLATFORM_REAL_TIME 0x04
/* State of the machine around the component. Not part of the stream that the same frames reproduce. */
struct polhode_platform {
  int64_t timestamp_ns; /* time of the last frame; ns */
  uint64_t resident_octets; /* resident memory of the process; octet */
  uint64_t resident_peak_octets; /* its greatest value since start; octet */
  uint32_t uptime_s; /* time since the start of the process; s */
  uint32_t frames_dropped; /* frames missing by the camera's count, skipped for newer ones, or for lack of time */
  uint32_t camera_errors; /* damaged frames, failed streams, disconnections */
  uint32_t camera_reopened; /* streams opened after the first one */
  uint32_t deadline_misses; /* steps that took longer than a frame */
  uint32_t jobs_late; /* job results that were not there when due; each costs a frame */
  uint32_t last_step_us; /* duration of the last step; us */
  uint32_t longest_step_us; /* longest step since start; us */
  uint32_t packets_sent; /* over all transports */
  uint32_t packets_dropped; /* packets lost to readers that are there but had no room for long */
  uint32_t commands_received; /* datagrams received at the command socket */
  uint32_t commands_dropped; /* commands dropped by the system before they were read, as far as it reports (UDP) */
  uint16_t restarts; /* starts from a checkpoint since the last cold start */
  uint8_t flags;
  uint8_t spare; /* 0 */
};

#define POLHODE_COMMAND_LINK 8 /* number of the packet: its APID less the first one */
#define POLHODE_COMMAND_LINK_OCTETS 70
#define POLHODE_COMMAND_LINK_KEY 0x01
#define POLHODE_COMMAND_LINK_UNAUTHENTICATED 0x02
#define POLHODE_COMMAND_LINK_NUMBER_NOT_KEPT 0x04
/* What came to the command ports, and who may give commands. What the component then refused is in housekeeping. */
struct polhode_command_link {
  int64_t timestamp_ns; /* time of the last frame; ns */
  uint64_t highest_number; /* greatest number of a signed command taken; numbers up to it that left the window are refused */
  uint32_t received; /* datagrams received */
  uint32_t passed; /* commands handed to the component */
  uint32_t refused_sender; /* refused: sent by another user (Unix sockets) */
  uint32_t refused_form; /* refused: no packet with a trailer */
  uint32_t refused_mac; /* refused: not signed by this key */
  uint32_t refused_number; /* refused: taken before, or older than the window */
  uint32_t dropped; /* dropped by the system before they were read, as far as it reports (UDP) */
  uint32_t numbers_not_kept; /* commands passed whose number the disk refused: they could be repeated after a restart */
  uint8_t ports; /* command ports */
  uint8_t flags; /* key: commands are signed; unauthenticated: anybody who reaches a UDP port may give them; number_not_kept: numbers_not_kept is not 0 */
  uint8_t spare[2]; /* 0 */
};

#define POLHODE_PLATFORM_EVENT 9 /* number of the packet: its APID less the first one */
#define POLHODE_PLATFORM_EVENT_OCTETS 186
#define POLHODE_PLATFORM_EVENT_SEVERITY_DEBUG 0
#define POLHODE_PLATFORM_EVENT_SEVERITY_INFO 1
#define POLHODE_PLATFORM_EVENT_SEVERITY_WARNING 2
#define POLHODE_PLATFORM_EVENT_SEVERITY_ERROR 3
#define POLHODE_PLATFORM_EVENT_SEVERITY_CRITICAL 4
/* Something happened in the machine around the component, as the disk took no more. The id alone states what; the text is for people. */
struct polhode_platform_event {
  int64_t timestamp_ns; /* time of the last frame; ns */
  double value[4]; /* the event's numbers, in the order of its text */
  uint16_t id; /* 1: the disk did not take all since the start: packets of so many steps in bus.ccsds, checkpoints, records of the recording, packets of file: transports */
  uint8_t severity; /* how serious the event is */
  uint8_t text_octets; /* length of the text */
  char text[123]; /* ASCII without control characters, zero-padded */
  uint8_t spare[2]; /* 0 */
};

#define POLHODE_POINT 10 /* number of the packet: its APID less the first one */
#define POLHODE_POINT_OCTETS 170
#define POLHODE_POINT_POSITION 0x01
#define POLHODE_POINT_VELOCITY 0x02
#define POLHODE_POINT_NORMAL 0x04
#define POLHODE_POINT_SCALE_KNOWN 0x08
/* as in the motion packet */
#define POLHODE_POINT_SCALE_NUMBER(flags) ((uint8_t)((flags) >> 4))
#define POLHODE_POINT_DYNAMICS_NONE 0
#define POLHODE_POINT_DYNAMICS_LOCAL 1
#define POLHODE_POINT_DYNAMICS_TORQUE_FREE 2
#define POLHODE_POINT_DYNAMICS_ORBIT 3
/* Where a point of the target will be, and which way its surface will face, if nothing acts on it. Covariances hold what is not known of motion, mass centre, map, scale and camera. The position is valid while its 1-sigma is under half the distance and that of the attitude under 0.5 rad, the normal while the latter is. */
struct polhode_point {
  int64_t timestamp_ns; /* time of the last frame that the prediction uses; ns */
  int64_t predicted_timestamp_ns; /* the time that the values belong to; ns */
  double p_C[3]; /* the point seen from C, in C with its orientation at timestamp_ns; length; flag position */
  double v_C[3]; /* its velocity relative to C's origin, likewise; by the dynamics alone; length/s; flag velocity */
  double normal_C[3]; /* direction that the surface faces there, likewise; flag normal */
  float cov_p[6]; /* covariance of p_C; length^2; flag position */
  float cov_v[6]; /* covariance of v_C; (length/s)^2; flag velocity */
  float sigma_normal_rad; /* 1-sigma of the direction of normal_C, worst way; rad; flag normal */
  uint32_t number; /* of the command */
  uint32_t target_frame; /* number of the frame T that the point is in */
  uint8_t dynamics; /* what was used; LOCAL: a polynomial through the last poses */
  uint8_t flags;
  uint8_t spare[2]; /* 0 */
};

#endif
