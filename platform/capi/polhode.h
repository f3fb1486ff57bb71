/* SPDX-FileCopyrightText: 2026 The Polhode authors
 * SPDX-License-Identifier: Apache-2.0
 *
 * The component for C11 and whatever calls C: frames in, CCSDS packets out. docs/c_interface.md shows how a cFS app and an
 * F Prime component wrap it.
 *
 * The tables live in memory that the caller hands over. The numerical libraries behind it take what they need from the
 * process's heap. Nothing is thrown: a function that can fail returns a status, and a mistake of the caller's is refused with
 * nothing changed. A handle is used by one thread at a time; a job may be run on another while steps go on.
 * Units and frames are those of the README: q_CT and p_CT take target components to camera components, SI units or map units. */
#ifndef POLHODE_H
#define POLHODE_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Raised when a struct or a function below changes its meaning; it is also the shared library's number (libpolhode.so.1). */
#define POLHODE_ABI 1
#define POLHODE_JOBS_MAX 3        /* out at a time: one of the map, one fit, one shape */
#define POLHODE_STEP_COMMANDS 8   /* carried out before a frame; those beyond are rejected by an event */
#define POLHODE_COMMANDS_MAX 64   /* handed in with a frame */
#define POLHODE_MEMORY_ALIGNMENT 64

typedef int32_t polhode_status;
enum {
  POLHODE_OK = 0,
  POLHODE_BAD_ARGUMENT = 1,     /* a null pointer, an unknown key, an image that does not fit its rows */
  POLHODE_BAD_PARAMETER = 2,    /* out of its range, or against another one; the problem's text says which */
  POLHODE_MEMORY_TOO_SMALL = 3, /* or not aligned */
  POLHODE_BAD_CHECKPOINT = 4,   /* of another build, or cut off; nothing changed */
  POLHODE_JOBS_DIFFER = 5,      /* the finished jobs are not those due at this step, or one was not run; nothing changed */
  POLHODE_FAILED = 6,           /* a library failed, for want of memory as a rule: destroy the component, create it anew */
  POLHODE_NOT_KNOWN = 7,        /* the question has no answer now; the problem's text says why */
  POLHODE_BAD_MODEL = 8         /* of another version, cut off, or larger than this build's tables; nothing changed */
};

const char* polhode_version(void); /* "0.1.0" */
uint32_t polhode_abi(void);        /* POLHODE_ABI of the library that is loaded */
const char* polhode_status_name(polhode_status status);

/* --- parameters ----------------------------------------------------------------------------------------------------------- */

typedef struct polhode_parameters polhode_parameters;

/* Pinhole with radial-tangential distortion; the top-left pixel's centre is (0, 0). */
typedef struct polhode_camera {
  int32_t width_px, height_px;
  double fu_px, fv_px, cu_px, cv_px;
  double k1, k2, p1, p2;
} polhode_camera;

size_t polhode_parameters_octets(void);

/* The defaults, in the caller's memory, aligned as malloc aligns. No end is needed. */
polhode_status polhode_parameters_create(void* memory, size_t octets, polhode_parameters** out);

/* Row times of a rolling shutter stay as they are: "camera.line_time_ns" by polhode_set_real(). */
polhode_status polhode_set_camera(polhode_parameters* parameters, const polhode_camera* camera);

/* One value by its key of config/default.toml, as in "features.count_max". A switch is 0 or 1, a choice its number from 0, in
 * the order that its range names. `index` is 0, or 0 to 3 for a pair of points. `problem` may be null; else it receives a line
 * of at most `problem_octets`, its end included: key, value, allowed range. */
polhode_status polhode_set_real(polhode_parameters* parameters, const char* key, size_t index, double value, char* problem,
                                size_t problem_octets);
polhode_status polhode_set_whole(polhode_parameters* parameters, const char* key, size_t index, int64_t value, char* problem,
                                 size_t problem_octets);

/* All of them together, the camera too. */
polhode_status polhode_check(const polhode_parameters* parameters, char* problem, size_t problem_octets);

/* --- component ------------------------------------------------------------------------------------------------------------ */

typedef struct polhode_component polhode_component;
typedef struct polhode_job polhode_job;

typedef struct polhode_octets {
  const uint8_t* data;
  size_t length;
} polhode_octets;

typedef struct polhode_input {
  int64_t timestamp_ns; /* middle of the exposure, strictly increasing */
  /* Gray, read during the step only. Null: the camera could not deliver the frame whole; it is counted and answered. */
  const uint8_t* pixels;
  int32_t width_px, height_px;
  int32_t pixel_bits;   /* 8, or 16 in the machine's order */
  int32_t memory_short; /* not 0: for a while less is asked of the libraries */
  int64_t stride_octets;
  const double* q_IC; /* null, or the observer's attitude: w, x, y, z, camera components to inertial ones */
  polhode_job* const* finished; /* jobs that are due at this step, run or skipped before */
  size_t finished_count;
  const polhode_octets* commands; /* received since the last step, a packet each */
  size_t command_count;
} polhode_input;

/* COASTING: the frame could not be looked at, its pose is predicted and has no rates. */
enum { POLHODE_IDLE = 0, POLHODE_ACQUIRING = 1, POLHODE_TRACKING = 2, POLHODE_LOST = 3, POLHODE_COASTING = 4 };

/* A value has a meaning only where its flag is 1. */
typedef struct polhode_motion {
  int64_t timestamp_ns;
  uint32_t frame;
  uint32_t target_frame; /* number of the frame T that the pose is in */
  uint8_t mode, pose_valid, rate_valid, velocity_valid, scale_known;
  uint8_t scale_number; /* of the scale in force, modulo 16: lengths of one number have one unit */
  uint8_t spare[2];
  uint16_t features, matches, inliers, landmarks, keyframes, spare_count;
  double q_CT[4], p_CT[3], v_C[3], w_T_rad_s[3];
  double sigma_att_rad, sigma_pos, sigma_vel, sigma_rate_rad_s;
} polhode_motion;

typedef struct polhode_output {
  polhode_motion motion;
  polhode_octets packets;             /* whole packets, in order; valid until the next step */
  polhode_job* jobs[POLHODE_JOBS_MAX]; /* for the caller to run, each until the step that it names */
  uint32_t job_count;
  uint8_t frame_used;       /* 0: an event packet says why not */
  uint8_t checkpoint_asked; /* by command: the caller is to write one now */
  uint8_t spare[2];
} polhode_output;

/* Octets for a component with these parameters, acquired once. 0: null parameters. */
size_t polhode_memory_needed(const polhode_parameters* parameters);

/* The memory is aligned to POLHODE_MEMORY_ALIGNMENT and outlives the component. Sets OpenCV's number of threads to 1. */
polhode_status polhode_create(void* memory, size_t octets, const polhode_parameters* parameters, polhode_component** out, char* problem,
                              size_t problem_octets);
/* Gives back what libraries hold; the memory is the caller's again. No job may be running. */
void polhode_destroy(polhode_component* component);

/* One frame. Bounded work. On any status but POLHODE_OK the output is untouched. */
polhode_status polhode_step(polhode_component* component, const polhode_input* input, polhode_output* output);
uint32_t polhode_next_step(const polhode_component* component); /* number of the step to come */

/* Where a point of the target will be: the question of a planner. Lengths in the unit that is published. */
typedef struct polhode_point_question {
  int64_t timestamp_ns;  /* not before the last frame */
  double p_T[3];         /* taken as exact */
  double normal_T[3];    /* direction that the surface faces there, a unit vector; zero: not asked for */
  uint32_t target_frame; /* number of the frame T that the point is in: polhode_motion.target_frame */
  uint32_t spare;
} polhode_point_question;

/* In C with its orientation at the last frame. A value has a meaning only where its flag is 1. Covariances hold what is not known of
 * motion, mass centre, map, scale and camera: xx, xy, xz, yy, yz, zz. */
typedef struct polhode_point {
  int64_t timestamp_ns;      /* that was asked for */
  int64_t from_timestamp_ns; /* of the last frame */
  double p_C[3], v_C[3], normal_C[3];
  double cov_p[6], cov_v[6];
  double sigma_normal_rad; /* 1-sigma of the direction, worst way */
  uint8_t position_valid, velocity_valid, normal_valid, scale_known;
  uint8_t scale_number; /* as of polhode_motion */
  uint8_t dynamics;     /* what was used: 1 the last poses alone, 2 torque-free, 3 in orbit */
  uint8_t spare[2];
} polhode_point;

/* By what the last step left; between steps. Changes nothing of the component. Up to 2 ms. POLHODE_NOT_KNOWN, with `out` untouched,
 * where there is no map, the time is before the last frame, the point is of another frame T, or no motion is known so far ahead: 10 s
 * by the last poses alone, 100 rad of rotation by the dynamics. `problem` as of polhode_set_real(). */
polhode_status polhode_predict_point(const polhode_component* component, const polhode_point_question* question, polhode_point* out,
                                     char* problem, size_t problem_octets);

/* Work that takes longer than a frame has time. There is none where both jobs.delay_frames and jobs.delay_of_all_frames are 0: a step
 * then takes up to a second. */
polhode_status polhode_run_job(polhode_job* job);
void polhode_skip_job(polhode_job* job); /* instead: it comes back without a result, which the component counts */
uint32_t polhode_due_step(const polhode_job* job);

/* A counter by its name in the housekeeping packet, as in "frames_used". */
polhode_status polhode_counter(const polhode_component* component, const char* name, uint32_t* value);

/* --- checkpoint ----------------------------------------------------------------------------------------------------------- */

size_t polhode_checkpoint_octets_max(void);
/* `octets` is at least polhode_checkpoint_octets_max(). Between steps. */
polhode_status polhode_save_checkpoint(const polhode_component* component, uint8_t* out, size_t octets, size_t* written);
/* Before the first step. The caller checks that the octets are whole: only the build's layout is checked here. */
polhode_status polhode_restore_checkpoint(polhode_component* component, const uint8_t* octets, size_t length);

/* --- the next pass -------------------------------------------------------------------------------------------------------- */

size_t polhode_model_octets_max(void);
/* What was learnt of the target: map, inertia, mass centre, scale. The same octets as of `polhode model save`, on every machine.
   `octets` is at least polhode_model_octets_max(). Between steps. POLHODE_NOT_KNOWN: there is no map. */
polhode_status polhode_save_model(const polhode_component* component, uint8_t* out, size_t octets, size_t* written);
/* Before the first step. The target is looked for by it; poses by it are in frame T number 1. Of POLHODE_BAD_MODEL the problem's text
   says why; nothing changed. */
polhode_status polhode_load_model(polhode_component* component, const uint8_t* octets, size_t length, char* problem, size_t problem_octets);

/* --- mistakes of our own -------------------------------------------------------------------------------------------------- */

/* Called before the process is aborted, when a check of the component's own logic fails. Set before the first create. */
typedef void (*polhode_assertion_hook)(const char* expression, const char* file, int32_t line, double value);
void polhode_set_assertion_hook(polhode_assertion_hook hook);

#ifdef __cplusplus
}
#endif
#endif
