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
#define POLHODE_MOTION_MODE_IDLE 0
#define POLHODE_MOTION_MODE_ACQUIRING 1
#define POLHODE_MOTION_MODE_TRACKING 2
#define POLHODE_MOTION_MODE_LOST 3
/* How the target is turned, where it is, how both change, at the middle of this frame's exposure. */
struct polhode_motion {
  int64_t timestamp_ns; /* middle of the exposure since 1970-01-01T00:00:00, exact; ns */
  double q_CT[4]; /* takes T components to C components; unit norm, sign continuous in time; flag pose */
  double p_CT[3]; /* T's origin seen from C, in C; length; flag pose */
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
  uint16_t features; /* detected or followed in this frame */
  uint16_t matches; /* tied to landmarks, or to tracks before a map */
  uint16_t inliers; /* that agree with the pose */
  uint16_t landmarks; /* in the map */
  uint16_t keyframes; /* in the map */
  uint8_t mode; /* what the component is doing */
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
/* The motion of a free rigid body that fits the poses so far: rates, principal axes, inertia ratios, periods, velocity, centre of mass. Each class says what the data tell: 1-sigma under about a half of its value, 30 deg, or of the body's radius is WEAK, under a tenth, 6 deg, OBSERVED; what is UNOBSERVED is zero. */
struct polhode_model {
  int64_t timestamp_ns; /* the time that the values belong to; ns */
  double w_T_rad_s[3]; /* the model's angular velocity at that time, relative to inertial space, in T; rad/s; flag rate */
  double q_TB[4]; /* principal axes of inertia B by growing moment: takes B components to T components; an axis holds as class_axes says; flag axes */
  double inertia_ratio[2]; /* principal moments over the least one: Jy/Jx, Jz/Jx; flag inertia */
  double period_spin_s; /* time in which the body rates repeat (the polhode's period); s; flag spin */
  double period_precession_s; /* mean time of a turn about the angular momentum; s; flag precession */
  double momentum_axis_C[3]; /* direction of the angular momentum, in C at that time; zero where class_momentum is UNOBSERVED */
  double v_C[3]; /* velocity of the centre of mass relative to C's origin, in C at that time; length/s; flag velocity */
  double c_T[3]; /* centre of mass seen from T's origin, in T; its part along UNOBSERVED directions is left out; length; flag mass_centre */
  float cov_w[6]; /* covariance of w_T; (rad/s)^2; flag rate */
  float sigma_axes_rad[3]; /* 1-sigma of each axis' direction, worst way; rad; flag axes */
  float sigma_inertia_ratio[2]; /* 1-sigma of the ratios; flag inertia */
  float sigma_period_spin_s; /* 1-sigma; s; flag spin */
  float sigma_period_precession_s; /* 1-sigma; s; flag precession */
  float sigma_momentum_axis_rad; /* 1-sigma, worst way; zero where class_momentum is UNOBSERVED; rad */
  float cov_v[6]; /* covariance of v_C; (length/s)^2; flag velocity */
  float cov_c[6]; /* covariance of c_T; along UNOBSERVED directions what is possible of the body; length^2; flag mass_centre */
  float span_s; /* time between the first and the last pose of the fit; s */
  float chi2_per_dof[2]; /* of the fit; 1 where the declared sigmas are right; cov and sigma are by the noise as found */
  uint32_t poses; /* that the fit used */
  uint32_t frame; /* index of the frame at publication */
  uint8_t dynamics; /* what was fitted; LOCAL: a polynomial through the last poses */
  uint8_t refusal; /* why the poses are not taken for a free rigid body's */
  uint8_t class_axes[3]; /* what the data tell of each axis of B */
  uint8_t class_inertia[2]; /* of each ratio */
  uint8_t class_spin; /* of its period */
  uint8_t class_precession; /* of its period */
  uint8_t class_momentum; /* of its direction */
  uint8_t class_mass_centre[3]; /* along the principal axes of cov_c */
  uint8_t flags;
};

#define POLHODE_PREDICTION 2 /* number of the packet: its APID less the first one */
#define POLHODE_PREDICTION_OCTETS 230
#define POLHODE_PREDICTION_ATTITUDE 0x01
#define POLHODE_PREDICTION_RATE 0x02
#define POLHODE_PREDICTION_POSITION 0x04
#define POLHODE_PREDICTION_SCALE_KNOWN 0x08
#define POLHODE_PREDICTION_DYNAMICS_NONE 0
#define POLHODE_PREDICTION_DYNAMICS_LOCAL 1
#define POLHODE_PREDICTION_DYNAMICS_TORQUE_FREE 2
#define POLHODE_PREDICTION_DYNAMICS_ORBIT 3
/* Where the target will be if nothing acts on it. Attitude and position are valid while their 1-sigma is under 0.5 rad and under half the distance. */
struct polhode_prediction {
  int64_t timestamp_ns; /* of the last frame that the prediction knows; ns */
  int64_t predicted_timestamp_ns; /* the time that the values belong to; ns */
  double q_CT[4]; /* predicted attitude, in C as it was turned at timestamp_ns; w >= 0; flag attitude */
  double p_CT[3]; /* predicted position of T's origin seen from C's, in C as it was turned at timestamp_ns; length; flag position */
  double w_T_rad_s[3]; /* predicted angular velocity, in T; rad/s; flag rate */
  float cov_pose[21]; /* as in the motion packet; rows and columns of what is not valid are zero; rad and length */
  float cov_w[6]; /* covariance of w_T; (rad/s)^2; flag rate */
  uint32_t frame; /* index of the last frame that the prediction knows */
  uint16_t poses; /* that the prediction rests on */
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
/* Dimensions, body frame, flat faces and cylinder of the target, from the map's confirmed landmarks. The flags axis_x, axis_y, axis_z say which axes of B the body's geometry fixes; the others are a choice. */
struct polhode_shape {
  int64_t timestamp_ns; /* of the frame at publication; ns */
  double q_TB[4]; /* body frame B: takes B components to T components; flag shape */
  double centroid_T[3]; /* centre of the completed body, B's origin, in T; length; flag shape */
  double centroid_measured_T[3]; /* mean of the measured cloud, in T; length; flag shape */
  double dimensions[3]; /* full lengths along B's axes; length; flag shape */
  double sigma_dimensions[3]; /* 1-sigma, without that of the unit, as all sigmas of this packet; length; flag shape */
  double metres_per_mu; /* the scale that turned map units into metres; m/map unit; flag scale_known */
  float cylinder_axis_T[3]; /* unit, either sign; flag cylinder */
  float cylinder_centre_T[3]; /* on the axis, at half length; length; flag cylinder */
  float cylinder_radius; /* length; flag cylinder */
  float cylinder_length; /* of the part that has points; length; flag cylinder */
  float cylinder_coverage_rad; /* how much of the round has points; rad; flag cylinder */
  float sigma_cylinder_axis_rad; /* 1-sigma, worst direction; rad; flag cylinder */
  float sigma_cylinder_radius; /* 1-sigma; length; flag cylinder */
  float spacing; /* typical distance of neighbouring points; length; flag shape */
  float thickness; /* 1-sigma noise of the cloud across its surface; length; flag shape */
  float sigma_scale; /* 1-sigma of a length's unit, of metres_per_mu that is, over its value; flag scale_known */
  float plane_normal_T[36]; /* of plane i: unit, away from the centroid; planes from plane_count on are zero; flag shape */
  float plane_offset[12]; /* normal . p = offset for points p of the plane, in T; length; flag shape */
  float plane_centre_T[36]; /* centre of the rectangle that holds its points; length; flag shape */
  float plane_extent[24]; /* that rectangle's full lengths; length; flag shape */
  float plane_sigma[36]; /* 1-sigma of the tilt about u and v, and of the offset; rad, rad, length; flag shape */
  uint32_t frame; /* index of the frame at publication */
  uint32_t frame_of_estimate; /* index of the frame whose map it was estimated from */
  uint16_t plane_inliers[12]; /* points of the plane; flag shape */
  uint16_t landmarks; /* that the estimate used */
  uint16_t cloud_points; /* measured, after denoising */
  uint16_t completion_points; /* added */
  uint8_t plane_count; /* planes that follow */
  uint8_t completion; /* what the cloud was completed to */
  uint8_t frame_source; /* where B's axes come from */
  uint8_t dimension_basis[3]; /* what each length rests on: the points are flat there; where points end, so at least so long; surfaces at both ends; flag shape */
  uint8_t flags;
  uint8_t spare; /* 0 */
};

#define POLHODE_HOUSEKEEPING 4 /* number of the packet: its APID less the first one */
#define POLHODE_HOUSEKEEPING_OCTETS 206
#define POLHODE_HOUSEKEEPING_HELD 0x01
#define POLHODE_HOUSEKEEPING_SCALE_KNOWN 0x02
#define POLHODE_HOUSEKEEPING_TABLE_LOADED 0x04
#define POLHODE_HOUSEKEEPING_SERVICER_ATTITUDE 0x08
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
/* Counters and state of the component. Counters start at 0, wrap at 2^32 and go to 0 by RESET_COUNTERS; frame does not. */
struct polhode_housekeeping {
  int64_t timestamp_ns; /* of the frame at publication; ns */
  uint64_t memory_octets; /* of the component's own tables, fixed since start; octet */
  uint32_t frame; /* index of the frame at publication */
  uint32_t frames_in; /* handed over */
  uint32_t frames_used; /* that were looked at */
  uint32_t frames_unreadable; /* that the camera could not deliver whole */
  uint32_t frames_dark; /* too dark to be used */
  uint32_t frames_wrong_size;
  uint32_t frames_time_not_increasing;
  uint32_t frames_held; /* passed over while held */
  uint32_t frames_missing; /* that never came, by the gaps in time */
  uint32_t frames_flat; /* without contrast; this and the next five: skipped, or used with care */
  uint32_t frames_saturated; /* far more saturated than those before */
  uint32_t frames_frozen; /* the previous picture once more */
  uint32_t frames_torn; /* a part of which is the previous picture's */
  uint32_t frames_bit_errors; /* with pixels, lines or blocks that are not of the picture */
  uint32_t frames_blurred; /* far less sharp than those before */
  uint32_t frames_with_care; /* used for a pose, not for the map */
  uint32_t poses; /* frames with a pose */
  uint32_t lost; /* times that tracking was lost */
  uint32_t relocalised; /* times that it was found again */
  uint32_t restarts; /* times that a map was begun anew after a loss */
  uint32_t start_contests; /* attempts at starting a map */
  uint32_t keyframes_inserted;
  uint32_t keyframes_culled;
  uint32_t landmarks_created;
  uint32_t landmarks_culled;
  uint32_t closures; /* loops closed */
  uint32_t shapes; /* estimates of the shape */
  uint32_t jobs_issued; /* starts, adjustments, fits of the motion, shapes */
  uint32_t jobs_without_result; /* skipped for want of memory */
  uint32_t steps_short_of_memory; /* in which less was asked of the libraries */
  uint32_t scale_contradictions; /* times that the readings of the scale stopped agreeing */
  uint32_t tables_full; /* times that a table had no free slot */
  uint32_t commands_accepted;
  uint32_t commands_rejected;
  uint32_t events_sent;
  uint32_t events_suppressed; /* held back by the throttle */
  uint32_t packets_not_sent; /* that found no room in a frame's output */
  uint32_t table_crc; /* CRC-32 of the active parameter table */
  uint32_t table_loaded_crc; /* CRC-32 over the entries loaded since the inactive table was begun */
  uint16_t table_entries; /* entries loaded into the inactive table */
  uint16_t landmarks; /* in the map */
  uint16_t keyframes; /* in the map */
  uint16_t cloud_chunks_left; /* of a requested cloud, still to be sent */
  uint8_t last_command; /* function code of the last command, accepted or not; 255: none yet */
  uint8_t last_rejection; /* why the last rejected command was refused */
  uint8_t mode;
  uint8_t version[3]; /* of the component */
  uint8_t flags;
  uint8_t spare; /* 0 */
};

#define POLHODE_EVENT 5 /* number of the packet: its APID less the first one */
#define POLHODE_EVENT_OCTETS 182
#define POLHODE_EVENT_SEVERITY_DEBUG 0
#define POLHODE_EVENT_SEVERITY_INFO 1
#define POLHODE_EVENT_SEVERITY_WARNING 2
#define POLHODE_EVENT_SEVERITY_ERROR 3
#define POLHODE_EVENT_SEVERITY_CRITICAL 4
/* Something happened. The id alone says what; the text is for people. */
struct polhode_event {
  int64_t timestamp_ns; /* of the frame; ns */
  double value[2]; /* the event's numbers, in the order of its text */
  uint32_t frame; /* index of the frame */
  uint32_t occurrences; /* of this id since start or RESET_COUNTERS, this one and suppressed ones included */
  uint32_t suppressed; /* of this id since the last one that was sent */
  uint16_t id; /* see the table of events */
  uint8_t severity;
  uint8_t text_octets; /* length of the text */
  char text[123]; /* ASCII without control characters, zero-padded */
  uint8_t spare[2]; /* 0 */
};

#define POLHODE_CLOUD 6 /* number of the packet: its APID less the first one */
#define POLHODE_CLOUD_OCTETS 1370
#define POLHODE_CLOUD_SCALE_KNOWN 0x01
/* A part of the map's landmarks as they were when the request was executed. */
struct polhode_cloud {
  int64_t timestamp_ns; /* of the last frame that was looked at before the request was executed; ns */
  double metres_per_mu; /* already applied to the points; m/map unit; flag scale_known */
  uint32_t points_total; /* of the whole cloud */
  uint32_t first_point; /* index of this packet's first point */
  uint16_t cloud; /* number of the request, from 1, wraps */
  uint16_t chunk; /* of this cloud, from 0 */
  uint16_t chunks; /* of this cloud */
  uint8_t points; /* in this packet; the rest is zero */
  uint8_t flags;
  float p_T[330]; /* landmarks, in T; length */
};

#define POLHODE_PLATFORM 7 /* number of the packet: its APID less the first one */
#define POLHODE_PLATFORM_OCTETS 94
#define POLHODE_PLATFORM_WATCHDOG 0x01
#define POLHODE_PLATFORM_LOCKED_MEMORY 0x02
#define POLHODE_PLATFORM_REAL_TIME 0x04
/* What the machine around the component did: not part of the stream that the same frames reproduce. */
struct polhode_platform {
  int64_t timestamp_ns; /* of the last frame; ns */
  uint64_t resident_octets; /* of the process now; octet */
  uint64_t resident_peak_octets; /* of the process since start; octet */
  uint32_t uptime_s; /* s */
  uint32_t frames_dropped; /* missing in the camera's count, passed over for newer ones, or for want of time */
  uint32_t camera_errors; /* damaged frames, failed streams, disconnections */
  uint32_t camera_reopened; /* streams opened after the first one */
  uint32_t deadline_misses; /* steps that took longer than a frame */
  uint32_t jobs_late; /* results that were not there when due; each costs a frame */
  uint32_t last_step_us; /* us */
  uint32_t longest_step_us; /* since start; us */
  uint32_t packets_sent; /* over all transports */
  uint32_t packets_dropped; /* of readers that are there and have had no room for long */
  uint32_t commands_received; /* datagrams at the command socket */
  uint32_t commands_dropped; /* by the system before they were taken, as far as it tells (UDP) */
  uint16_t restarts; /* from checkpoint to checkpoint, since a cold start */
  uint8_t flags;
  uint8_t spare; /* 0 */
};

#endif
